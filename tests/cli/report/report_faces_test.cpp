/// The section of a report that says what faces the scan has.
#include "cli/report/report_faces.h"

#include <catch2/catch.hpp>

#include "testing/measured.h"

namespace partscribe::testing {

TEST_CASE("report faces: the section has the picture with a text, and the rows of all tables, escaped") {
  MeasuredPart part = measured_plate();
  part.features[0].name = "hole <1>";
  const ReportPicture picture = {"faces.png", "Faces", "six faces", 4, 3, "png"};
  const std::string html = faces_section(part, picture);
  CHECK(html.find("alt=\"six faces\"") != std::string::npos);
  CHECK(html.find("hole &lt;1&gt;") != std::string::npos);
  CHECK(html.find("inside diameter 6.0042 \xc2\xb1 0.0042, length 10") != std::string::npos);
  CHECK(html.find("direction A") != std::string::npos);
  CHECK(html.find("Unclassified: 12.5 of ") != std::string::npos);
  CHECK(html.find("mm\xc2\xb2") != std::string::npos);
}

TEST_CASE("report faces: tables without rows are left out, long ones say how many rows are missing") {
  MeasuredPart part = measured_plate();
  part.features.clear();
  for (int i = 0; i < 60; ++i) part.faces.faces.push_back(plane_face({1.0 * i, 0, 0}, {0, 0, 1}, 1));
  part.plane_sizes.resize(part.faces.faces.size(), Vec2::Zero());
  const std::string html = faces_section(part, {});
  CHECK(html.find("Features, as measured") == std::string::npos);
  CHECK(html.find("plane 40<") != std::string::npos);
  CHECK(html.find("plane 41<") == std::string::npos);
  CHECK(html.find("26 more are in the files of") != std::string::npos);
}

}  // namespace partscribe::testing
