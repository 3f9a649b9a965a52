#include "cli/mcp/tools.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

namespace partscribe::cli {

TEST_CASE("agents: a tool that says it only reads has no argument that names a file to write") {
  for (const auto& tool : nlohmann::json::parse(tool_list())) {
    const std::string name = tool["name"];
    const bool reads = tool["annotations"]["readOnlyHint"];
    INFO(name);
    CHECK(reads == (name == "verify" || name == "explain"));
    for (const char* output : {"out", "force", "csv", "junit", "json_file", "pictures", "picture"})
      if (reads) CHECK_FALSE(tool["inputSchema"]["properties"].contains(output));
  }
}

}  // namespace partscribe::cli
