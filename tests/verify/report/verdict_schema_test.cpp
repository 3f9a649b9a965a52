/// docs/verdict.schema.json says what verdict.json holds: what is written validates, and what is broken does not.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "testing/json_schema.h"
#include "testing/meshes.h"
#include "testing/program.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

using Json = nlohmann::json;

std::string fault(const Json& verdict) {
  static const JsonSchema schema(source_file("docs/verdict.schema.json"));
  return schema.fault(verdict, JsonSchema::Keys::named);
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
  CHECK(fault(bad) == "document.artifacts[0].findings[0].kind: enum");
  bad["artifacts"][0]["findings"][0].erase("text");
  CHECK(fault(bad).find("findings[0]") != std::string::npos);
}
