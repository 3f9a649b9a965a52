/// docs/faces.schema.json says what faces.json holds: what is written validates, and what is broken does not.
#include "cli/measure/faces_file.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "testing/damage/file_damage.h"
#include "testing/json_schema.h"
#include "testing/measured.h"
#include "testing/places.h"

namespace partscribe::testing {

namespace {

using Json = nlohmann::json;

std::string fault(const Json& faces) {
  static const JsonSchema schema(source_file("docs/faces.schema.json"));
  return schema.fault(faces, JsonSchema::Keys::named);
}

/// Cells outside quotes.
std::ptrdiff_t cells_of(const std::string& line) {
  bool quoted = false;
  std::ptrdiff_t count = 1;
  for (const char c : line) {
    quoted ^= c == '"';
    count += c == ',' && !quoted;
  }
  return count;
}

}  // namespace

TEST_CASE("faces.json: validates against its schema, and a broken one does not") {
  const MeasuredPart part = measured_plate();
  auto json = Json::parse(faces_json(part));
  CHECK(fault(json) == "");
  CHECK(fault(Json::parse(faces_json(part, {"a/faces.json"}, {"a warning"}))) == "");
  json["faces"][2]["kind"] = "tube";
  CHECK(fault(json) == "document.faces[2].kind: enum");
  json["faces"][2].erase("area");
  CHECK(fault(json).find("faces[2]") != std::string::npos);
}

TEST_CASE("faces.json: a face has one number in ids, names, neighbours, relations and features") {
  const auto json = Json::parse(faces_json(measured_plate()));
  for (std::size_t f = 0; f < json["faces"].size(); ++f) CHECK(json["faces"][f]["id"] == f + 1);
  CHECK(json["faces"][3]["name"] == "cylinder 4");
  CHECK(json["faces"][3]["neighbours"][1]["id"] == 5);
  CHECK(json["faces"][3]["neighbours"][1]["edge"] == "concave");
  CHECK(json["features"][1]["faces"] == Json({4, 5}));
  CHECK(json["relations"][2]["faces"] == Json({4, 5}));
}

TEST_CASE("faces.json: lengths are mm, angles degrees, and what a kind has not is left out") {
  const auto json = Json::parse(faces_json(measured_plate()));
  CHECK(json["units"] == "mm");
  const auto &plane = json["faces"][0], &hole = json["faces"][2], &cone = json["faces"][4], &free = json["faces"][5];
  CHECK(plane["size"] == Json({80, 60}));
  CHECK_FALSE(plane.contains("radius"));
  CHECK_FALSE(plane.contains("convex"));
  CHECK(hole["radius"] == 3.0021);
  CHECK(hole["convex"] == false);
  CHECK(hole["arc_deg"] == 360);
  CHECK(hole["sigma"]["radius"] == 0.0021);
  CHECK(hole["sigma"]["axis_deg"] == 0.01);
  CHECK(cone["half_angle_deg"] == 45);
  CHECK(cone["sigma"]["half_angle_deg"] == 0.2);
  CHECK_FALSE(free.contains("point"));
  CHECK_FALSE(free.contains("sigma"));
  CHECK(json["relations"][4]["unit"] == "deg");
  CHECK(json["relations"][4]["value"] == 0.35);
  CHECK(json["relations"][4]["accepted"] == false);
  CHECK(json["features"][1]["dimensions"][1]["unit"] == "deg");
  CHECK(json["features"][1]["dimensions"][1]["value"] == 90);
  CHECK(json["features"][2]["dimensions"][0]["unit"] == "");
  CHECK(json["features"][1]["place"] == Json({68, 30, 7}));
  CHECK(json["unclassified"][0]["area"] == 12.5);
}

TEST_CASE("faces.json: many small places without a face are one entry, and no area is lost") {
  MeasuredPart part = measured_plate();
  for (int i = 0; i < 300; ++i) part.unclassified.push_back({0.25, {1.0 * i, 0, 0}, "too small", true});
  const auto json = Json::parse(faces_json(part));
  CHECK(fault(json) == "");
  REQUIRE(json["unclassified"].size() == 101);
  double sum = 0;
  for (const auto& place : json["unclassified"]) sum += place["area"].get<double>();
  CHECK(sum == Approx(12.5 + 300 * 0.25));
}

TEST_CASE("faces.csv and features.csv: a row for each face and each size, every row as long as the heading") {
  const MeasuredPart part = measured_plate();
  for (const auto& text : {faces_csv(part), features_csv(part)}) {
    const auto lines = lines_of(text);
    for (const auto& line : lines) CHECK(cells_of(line) == cells_of(lines.front()));
  }
  const auto faces = lines_of(faces_csv(part));
  REQUIRE(faces.size() == 7);
  CHECK(faces[3].starts_with("3,cylinder 3,cylinder,inside,"));
  CHECK(faces[6].starts_with("6,free form 6,free_form,,30,"));
  const auto features = lines_of(features_csv(part));
  REQUIRE(features.size() == 5);
  CHECK(features[3] == "hole 2,countersunk hole,angle,deg,90,0.4,68,30,7,4 5");
  CHECK(features[4] == "row of holes 1,row of holes,count,,2,0,49.333333,30,6.333333,3 4 5");
}

}  // namespace partscribe::testing
