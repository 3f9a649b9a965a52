/// Claims about bodies that went through a file.
#include "codegen/exchange/as_read.h"

#include <BRepCheck_Analyzer.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Shape.hxx>
#include <catch2/catch.hpp>

#include "codegen/exchange/brep_shapes.h"

namespace partscribe::testing {
namespace {

std::vector<double> areas_of(const TopoDS_Shape& body) {
  std::vector<double> areas;
  for (TopExp_Explorer face(body, TopAbs_FACE); face.More(); face.Next())
    areas.push_back(codegen::area_of(face.Current()));
  return areas;
}

}  // namespace

TEST_CASE("as read: both files hold a valid body with the same faces in the same order") {
  model::ExtrudeOf<double> bar;
  using Corner = model::SketchPointOf<double>;
  bar.sketch.loops = {{"outline", {Corner{0, 0, ""}, Corner{70, 0, ""}, Corner{20, 40, ""}}}};
  bar.height = 12;
  const TopoDS_Shape body = codegen::brep_of(bar);
  const std::vector<double> expected = areas_of(body);
  REQUIRE(expected.size() == 5);
  const auto read = codegen::as_read(body);
  REQUIRE(read);
  REQUIRE(read->size() == 2);
  for (const TopoDS_Shape& shape : *read) {
    CHECK(BRepCheck_Analyzer(shape).IsValid());
    const std::vector<double> found = areas_of(shape);
    REQUIRE(found.size() == expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) CHECK(found[k] == Approx(expected[k]).epsilon(1e-6));
  }
}

TEST_CASE("as read: nothing comes of nothing") { CHECK_FALSE(codegen::as_read(TopoDS_Shape())); }

}  // namespace partscribe::testing
