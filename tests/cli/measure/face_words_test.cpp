/// What a person reads of a measured part.
#include "cli/measure/face_words.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "testing/measured.h"

namespace partscribe::testing {

namespace {

using Row = std::vector<std::string>;

bool has_row(const TableRows& rows, const Row& row) { return std::find(rows.begin(), rows.end(), row) != rows.end(); }

}  // namespace

TEST_CASE("face words: a face is told by kind and number, sizes as on a drawing, and how sure they are") {
  const auto rows = face_rows(measured_plate());
  REQUIRE(rows.size() == 7);
  CHECK(rows[1] == Row{"plane 1", "80 x 60", "(40, 30, 0)", "(0, 0, -1)", "", "4700", "0.01", "0.0004", "0.01"});
  CHECK(rows[3] == Row{"cylinder 3", "inside diameter 6.0042 ± 0.0042, length 10", "(12, 30, 5)", "(0, 0, 1)",
                       "360 deg", "189", "0.01", "0.0004", "0.01"});
  CHECK(rows[5][1] == "inside diameters 6 to 10, half angle 45 ± 0.2 deg");
  CHECK(rows[6] == Row{"free form 6", "", "(1, 2, 3)", "", "runs out", "30", "", "", ""});
}

TEST_CASE("face words: what goes around less than half has a radius, and faces of a mesh few digits") {
  MeasuredPart part = measured_plate();
  part.faces.of_mesh = true;
  Face& face = part.faces.faces[2];
  face.arc = pi / 2, face.coverage = 0.25, face.hollow = false;
  face.fit.sigma_radius = 1e-5;
  CHECK(face_rows(part)[3][1] == "outside radius 3.002, length 10");
  CHECK(face_rows(part)[3][4] == "90 deg");
  face.coverage = 0.125;  // a window takes half of it
  CHECK(face_rows(part)[3][4] == "90 deg, 12.5 %");
}

TEST_CASE("face words: features come with sizes in their units") {
  const auto rows = feature_rows(measured_plate());
  CHECK(has_row(rows, {"hole 1", "through hole", "diameter 6.0042 ± 0.0042", "(12, 30, 5)", "3"}));
  CHECK(has_row(rows,
                {"hole 2", "countersunk hole", "diameter 5.9974 ± 0.0042, angle 90 ± 0.4 deg", "(68, 30, 7)", "4, 5"}));
  CHECK(has_row(rows, {"row of holes 1", "row of holes", "count 2", "(49.33, 30, 6.33)", "3, 4, 5"}));
}

TEST_CASE("face words: pairs that hold become groups, and those that do not are named") {
  const auto rows = relation_rows(measured_plate());
  CHECK(has_row(rows, {"direction A", "planes 1, 2; cylinder 3", "within 0.02 deg"}));
  CHECK(has_row(rows, {"one axis", "cylinder 4; cone 5", "within 0.0021 mm"}));
  CHECK(has_row(rows, {"equal radius", "cylinders 3, 4: radius 3", "within 0.0034 mm"}));
  CHECK(has_row(rows, {"not parallel", "cylinders 3, 4", "off by 0.35 ± 0.04 deg"}));
}

TEST_CASE("face words: directions that are square to each other are named once") {
  MeasuredPart part = measured_plate();
  part.faces.faces.push_back(plane_face({0, 30, 5}, {-1, 0, 0}, 600));
  part.faces.faces.push_back(plane_face({80, 30, 5}, {1, 0, 0}, 600));
  part.plane_sizes.resize(8, Vec2::Zero());
  for (const std::uint32_t f : {0u, 1u})
    for (const std::uint32_t side : {6u, 7u})
      part.relations.push_back({RelationKind::orthogonal, f, side, radians(0.003), radians(0.01), 0.3, true});
  CHECK(has_row(relation_rows(part), {"square", "A to plane 7, A to plane 8", "within 0.003 deg"}));
  part.relations.push_back({RelationKind::parallel, 6, 7, 0, radians(0.01), 0, true});
  CHECK(has_row(relation_rows(part), {"direction B", "planes 7, 8", "within 0.001 deg"}));
  CHECK(has_row(relation_rows(part), {"square", "A to B", "within 0.003 deg"}));
}

TEST_CASE("face words: of many pairs that do not hold those between the largest faces are told") {
  MeasuredPart part = measured_plate();
  part.relations.clear();
  for (std::uint32_t i = 0; i < 20; ++i)
    part.relations.push_back({RelationKind::parallel, i % 2, 4, radians(1), radians(0.1), 10, false});
  part.relations.push_back({RelationKind::orthogonal, 0, 2, radians(0.4), radians(0.1), 4, false});
  const auto rows = relation_rows(part);
  REQUIRE(rows.size() == 10);
  CHECK(rows[1] == Row{"not orthogonal", "plane 1; cylinder 3", "off by 0.4 ± 0.1 deg"});
  CHECK(rows[9][1] == "and 13 more that do not hold, in faces.json");
}

TEST_CASE("face words: what belongs to no face is told with its share") {
  MeasuredPart part = measured_plate();
  const auto text = unclassified_text(part);
  INFO(text);
  CHECK(text.find("Free form: 30 of ") != std::string::npos);
  CHECK(text.find("Unclassified: 12.5 of ") != std::string::npos);
  CHECK(text.find("(0.13 %)") != std::string::npos);
  CHECK(text.find("near (79, 1, 10)") != std::string::npos);
  for (int i = 0; i < 20; ++i) part.unclassified.push_back({0.5, {1.0 * i, 0, 0}, "too small", true});
  CHECK(unclassified_text(part).find("  10 mm2    in 20 places      too small\n") != std::string::npos);
  part.unclassified.clear();
  CHECK(unclassified_text(part).find("Unclassified: nothing of ") != std::string::npos);
}

TEST_CASE("face words: a long table is cut and says where the rest is") {
  MeasuredPart part = measured_plate();
  for (int i = 0; i < 60; ++i) part.faces.faces.push_back(plane_face({1.0 * i, 0, 0}, {0, 0, 1}, 1));
  part.plane_sizes.resize(part.faces.faces.size(), Vec2::Zero());
  const auto text = measured_text(part);
  CHECK(text.find("plane 40 ") != std::string::npos);
  CHECK(text.find("plane 41 ") == std::string::npos);
  CHECK(text.find("and 26 more in faces.csv\n") != std::string::npos);
}

}  // namespace partscribe::testing
