#include "fit/surface/spline_charts.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "fit/input/prepare.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/surfaces/edge_curve.h"
#include "testing/free_forms.h"
#include "testing/meshes.h"

using namespace partscribe::core;
using namespace partscribe::fit;

namespace {

std::vector<TrimmedSurface> charts_over(const TriangleMesh& mesh, double tolerance) {
  Context context;
  Scan scan = partscribe::testing::scan_of(mesh);
  const auto input = prepare(scan, tolerance, context);
  REQUIRE(input.ok());
  return spline_charts(mesh, *input, context);
}

struct Meeting {
  double gap = 0, angle = 0;  // mm and radians, the largest
};

Meeting meeting_of(const std::vector<TrimmedSurface>& surfaces) {
  Meeting result;
  for (const auto& [number, sides] : edge_sides(surfaces)) {
    REQUIRE(sides.size() == 2);
    result.gap = std::max(result.gap, edge_gap(sides, 40));
    for (int i = 0; i <= 40; ++i) {
      Vec3 normal[2];
      for (std::size_t k = 0; k < 2; ++k) {
        const auto& t = sides[k].trim->t;
        const double share = k == 0 ? i / 40.0 : 1 - i / 40.0;
        const Vec2 uv = sides[k].trim->at(t.low() + share * (t.high() - t.low()));
        normal[k] = sides[k].surface->derivatives(uv.x(), uv.y()).normal();
      }
      result.angle = std::max(result.angle, std::acos(std::min(1.0, normal[0].dot(normal[1]))));
    }
  }
  return result;
}

/// Each triangle cut into four, some times over.
TriangleMesh in_quarters(TriangleMesh mesh, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    TriangleMesh next;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto first = static_cast<std::uint32_t>(next.vertices.size());
      for (int k = 0; k < 3; ++k) next.vertices.push_back(mesh.corner(t, k));
      for (int k = 0; k < 3; ++k) next.vertices.push_back(0.5 * (mesh.corner(t, k) + mesh.corner(t, (k + 1) % 3)));
      next.triangles.push_back({first, first + 3, first + 5});
      next.triangles.push_back({first + 3, first + 1, first + 4});
      next.triangles.push_back({first + 5, first + 4, first + 2});
      next.triangles.push_back({first + 3, first + 4, first + 5});
    }
    mesh = welded(next, 0);
  }
  return mesh;
}

}  // namespace

TEST_CASE("spline charts: surfaces of a smooth lump meet within a fifth of the tolerance and some degrees") {
  const auto surfaces = charts_over(partscribe::testing::pebble(40), 0.2);
  REQUIRE(surfaces.size() >= 4);
  const Meeting meeting = meeting_of(surfaces);
  CHECK(meeting.gap < 0.04);
  CHECK(meeting.angle < 6 * pi / 180);
}

TEST_CASE("spline charts: a block becomes six planes that meet in its corners") {
  // Facets of 2 mm, so that charts may end anywhere.
  const auto fine = in_quarters(partscribe::testing::box({0, 0, 0}, {30, 20, 10}), 3);
  const auto surfaces = charts_over(fine, 0.1);
  REQUIRE(surfaces.size() == 6);
  for (const auto& s : surfaces) {
    CHECK(s.surface.points.size() == 16);
    REQUIRE(s.loops.size() == 1);
    CHECK(s.loops[0].size() == 4);
  }
  CHECK(meeting_of(surfaces).gap < 0.02);
  const auto triangles = triangulated(surfaces, 0.02);
  CHECK(topology(triangles.mesh).closed());
  CHECK(volume(triangles.mesh) == Approx(6000).epsilon(0.002));
}

TEST_CASE("spline charts: surfaces of a bent block with round edges lie near its mesh between its corners as well") {
  TriangleMesh mesh = in_quarters(partscribe::testing::box({-1, -1, -1}, {1, 1, 1}), 5);
  for (Vec3& p : mesh.vertices) {
    p = Vec3(45, 25, 30).cwiseProduct(p) / std::pow(p.array().pow(6).sum(), 1.0 / 6);
    p.x() += 3 * std::sin(p.z() / 12), p.y() += 2 * std::sin(p.x() / 17);
  }
  const double tolerance = 0.05;
  const auto surfaces = charts_over(mesh, tolerance);
  REQUIRE(!surfaces.empty());
  CHECK(meeting_of(surfaces).gap < 0.4 * tolerance);
  const auto triangles = triangulated(surfaces, tolerance / 4);
  CHECK(topology(triangles.mesh).closed());
  const MeshDistance distance(mesh);
  double off = 0;
  for (std::size_t t = 0; t < triangles.mesh.triangles.size(); ++t)
    off = std::max(
        off,
        distance.closest((triangles.mesh.corner(t, 0) + triangles.mesh.corner(t, 1) + triangles.mesh.corner(t, 2)) / 3)
            .distance);
  CHECK(off < tolerance);
}
