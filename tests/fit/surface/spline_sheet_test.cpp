#include "fit/surface/spline_sheet.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "fit/evidence/evidence.h"
#include "fit/input/prepare.h"
#include "model/surface_patches.h"

using namespace partscribe::fit;

namespace {

/// A sheet over 60 x 40 with a window, as a mesh of 1 mm cells: points and triangles of the scan.
Scan hood() {
  Scan scan;
  const int columns = 60, rows = 40;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i)
      scan.mesh.vertices.emplace_back(i, j, 5 * std::sin(i / 11.0) * std::cos(j / 14.0));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      if (i >= 20 && i < 34 && j >= 12 && j < 24) continue;
      const auto a = std::uint32_t(j * (columns + 1) + i), b = a + 1, c = a + std::uint32_t(columns) + 1, d = c + 1;
      scan.mesh.triangles.push_back({a, b, d});
      scan.mesh.triangles.push_back({a, d, c});
    }
  scan.mesh = welded(scan.mesh, 0);
  scan.cloud.points = scan.mesh.vertices;
  return scan;
}

}  // namespace

TEST_CASE("spline sheet: a sheet with a window becomes one surface with an outline and a hole of four lines each") {
  Context context;
  Scan scan = hood();
  auto input = prepare(scan, 0.05, context);
  REQUIRE(input.ok());
  const auto sheet = spline_sheet(scan.mesh, *input, context);
  REQUIRE(sheet);
  const auto& set = std::get<SurfaceSet>(sheet->shape);
  REQUIRE(set.patches.size() == 1);
  CHECK_FALSE(set.closed);
  CHECK_FALSE(complaint_about(set.patches[0]));
  CHECK(set.patches[0].trims.size() == 8);
  CHECK(set.patches[0].control.size() < 250);
  CHECK(evidence_of(*sheet, *input, context).local_max < 0.05);
  const auto surfaces = trimmed_surfaces(set.patches);
  const auto triangles = triangulated(surfaces, 0.01);
  CHECK(area(triangles.mesh) == Approx(area(scan.mesh)).epsilon(0.01));
}

TEST_CASE("spline sheet: two pieces are two surfaces; a closed body is none") {
  Context context;
  Scan scan = hood();
  const auto one = scan.mesh;
  const auto first = static_cast<std::uint32_t>(one.vertices.size());
  for (const Vec3& p : one.vertices) scan.mesh.vertices.push_back(p + Vec3(0, 60, 10));
  for (const auto& t : one.triangles) scan.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  scan.cloud.points = scan.mesh.vertices;
  auto input = prepare(scan, 0.1, context);
  REQUIRE(input.ok());
  const auto sheet = spline_sheet(scan.mesh, *input, context);
  REQUIRE(sheet);
  CHECK(std::get<SurfaceSet>(sheet->shape).patches.size() == 2);

  TriangleMesh tetrahedron{{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}},
                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  CHECK_FALSE(spline_sheet(tetrahedron, *input, context));
}
