/// How deep a JSON text is nested is known before it is parsed.
#include "core/json_nesting.h"

#include <catch2/catch.hpp>
#include <string>

using namespace partscribe::core;

namespace {

std::string nested(int depth) {
  return std::string(static_cast<std::size_t>(depth), '[') + std::string(static_cast<std::size_t>(depth), ']');
}

}  // namespace

TEST_CASE("json nesting: lists and objects count, and what stands beside each other or in a text does not") {
  CHECK_FALSE(nested_too_deeply(nested(deepest_json)));
  CHECK(nested_too_deeply(nested(deepest_json + 1)));
  CHECK(nested_too_deeply(std::string(1'000'000, '[')));
  CHECK(nested_too_deeply("{\"a\": " + nested(deepest_json) + "}"));
  std::string beside = "[", quoted = "[\"\\\"";
  for (int i = 0; i < 1000; ++i) beside += "[],", quoted += "[{";
  CHECK_FALSE(nested_too_deeply(beside + "1]"));
  CHECK_FALSE(nested_too_deeply(quoted + "\"]"));
  CHECK_FALSE(nested_too_deeply(""));
}
