/// docs/verdict.schema.json says what verdict.json holds: what is written validates, and what is broken does not.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/files.h"
#include "tests/verify/shapes.h"

using namespace partscribe;
using namespace partscribe::testing;

namespace {

using Json = nlohmann::json;

const Json& schema() {
  static const Json document = [] {
    const auto text = read_file(Path(PARTSCRIBE_SOURCE_DIR) / "docs" / "verdict.schema.json");
    ensure(text.ok(), "the schema cannot be read");
    return Json::parse(*text);
  }();
  return document;
}

bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number() && value.get<double>() == std::floor(value.get<double>());
  FAIL("unknown type " + type);
  return false;
}

/// The first fault and where it is, empty if there is none. Keys that no property names are faults.
std::string fault(const Json& value, const Json& rule = schema(), const std::string& at = "verdict") {
  static const std::set<std::string> known = {"$schema",    "title",   "description", "$defs",    "$ref",
                                              "type",       "enum",    "required",    "properties", "items",
                                              "minItems",   "maxItems", "minimum",    "maximum",  "exclusiveMinimum"};
  for (const auto& [keyword, argument] : rule.items()) {
    if (!known.count(keyword)) FAIL("the schema uses the unknown keyword " + keyword);
    const std::string wrong = at + ": " + keyword;
    std::string inner;
    if (keyword == "$ref") inner = fault(value, schema().at("$defs").at(argument.get<std::string>().substr(8)), at);
    else if (keyword == "type" && !has_type(value, argument)) return wrong;
    else if (keyword == "enum" && std::find(argument.begin(), argument.end(), value) == argument.end()) return wrong;
    else if (keyword == "minimum" && value.is_number() && value < argument) return wrong;
    else if (keyword == "maximum" && value.is_number() && value > argument) return wrong;
    else if (keyword == "exclusiveMinimum" && value.is_number() && value <= argument) return wrong;
    else if (keyword == "minItems" && value.is_array() && value.size() < argument.get<std::size_t>()) return wrong;
    else if (keyword == "maxItems" && value.is_array() && value.size() > argument.get<std::size_t>()) return wrong;
    else if (keyword == "items" && value.is_array()) {
      for (std::size_t i = 0; i < value.size() && inner.empty(); ++i) inner = fault(value[i], argument, at + "[" + std::to_string(i) + "]");
    } else if (keyword == "required" && value.is_object()) {
      for (const auto& key : argument)
        if (!value.contains(key.get<std::string>())) return wrong + " " + key.get<std::string>();
    } else if (keyword == "properties" && value.is_object()) {
      for (const auto& [key, member] : value.items()) {
        if (!argument.contains(key)) return at + ": unknown key " + key;
        if (inner.empty()) inner = fault(member, argument[key], at + "." + key);
      }
    }
    if (!inner.empty()) return inner;
  }
  return "";
}

}  // namespace

TEST_CASE("verdict.schema.json: real verdicts with findings and dimensions validate, broken ones do not") {
  VerifyOptions options;
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  const auto scan = scanned(truth, 30000, 0.02);
  const auto good = Json::parse(write_verdict_json(verdict_on(truth, scan, options)));
  CHECK(fault(good) == "");
  auto bad = Json::parse(write_verdict_json(verdict_on(holed_plate(40, 10, 6.3, 5, -8), scan, options)));
  CHECK(fault(bad) == "");
  REQUIRE_FALSE(bad["artifacts"][0]["findings"].empty());
  REQUIRE_FALSE(bad["artifacts"][0]["objects"][0]["dimensions"].empty());
  bad["artifacts"][0]["findings"][0]["kind"] = "odd";
  CHECK(fault(bad) == "verdict.artifacts[0].findings[0].kind: enum");
  bad["artifacts"][0]["findings"][0].erase("text");
  CHECK(fault(bad).find("findings[0]") != std::string::npos);
}
