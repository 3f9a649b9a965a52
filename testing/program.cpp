#include "testing/program.h"

#include <catch2/catch.hpp>

#include "core/number.h"

namespace partscribe::testing {

ProcessOutput run_partscribe(const std::vector<std::string>& arguments, const Path& working_directory) {
  std::vector<std::string> words = {program().string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  Context context;
  const auto output = run_process(words, {.seconds = 800, .processes = 4096}, context, working_directory);
  REQUIRE(output.ok());
  return *output;
}

std::string bytes_of(const Path& file) {
  const auto bytes = read_file(file);
  INFO(file.string());
  REQUIRE(bytes.ok());
  return *bytes;
}

void simulate_part(const std::string& part, const Path& folder, int resolution, double sigma) {
  const auto output = run_partscribe({"simulate", source_file("corpus/" + part + "/model.json").string(),
                                      "--resolution", std::to_string(resolution), "--sigma", print_number(sigma),
                                      "--seed", "11", "--out", folder.string()});
  INFO(output.err);
  REQUIRE(output.exit_code == 0);
}

}  // namespace partscribe::testing
