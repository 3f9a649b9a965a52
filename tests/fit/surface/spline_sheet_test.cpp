#include "fit/surface/spline_sheet.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "fit/input/prepare.h"
#include "fit/surface/flatten.h"
#include "testing/free_forms.h"

using namespace partscribe::fit;

TEST_CASE("spline sheet: a sheet with a window becomes one surface with an outline and a hole of four lines each") {
  Context context;
  Scan scan = partscribe::testing::scan_of(partscribe::testing::hood());
  const auto input = prepare(scan, 0.05, context);
  REQUIRE(input.ok());
  const auto places = flattened(scan.mesh);
  REQUIRE(places);
  const auto sheet = spline_sheet(scan.mesh, *places, *input, context);
  REQUIRE(sheet);
  REQUIRE(sheet->loops.size() == 2);
  CHECK(sheet->loops[0].size() == 4);
  CHECK(sheet->loops[1].size() == 4);
  CHECK(sheet->surface.points.size() < 250);
  const std::vector surfaces = {*sheet};
  const SurfaceDistance distance(surfaces, 0.01, false);
  double worst = 0;
  for (const Vec3& p : scan.mesh.vertices) worst = std::max(worst, std::abs(distance(p).distance));
  CHECK(worst < 0.05);
  CHECK(area(triangulated(surfaces, 0.01).mesh) == Approx(area(scan.mesh)).epsilon(0.01));
}
