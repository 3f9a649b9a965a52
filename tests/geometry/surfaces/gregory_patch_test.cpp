/// Single Gregory patches: what each border sees, twists that disagree, and the same surface as NURBS.
#include "geometry/surfaces/gregory_patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::geometry;

namespace {

/// A shaken bicubic net over 30 x 30 mm; `torn` moves the second inner point of so many corners.
GregoryPatch shaken_patch(int torn, std::uint64_t seed) {
  partscribe::core::Random random(seed);
  const auto shake = [&] { return Vec3(random.normal(), random.normal(), 3 * random.normal()); };
  GregoryPatch patch;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) patch.points[i][j] = Vec3(10.0 * double(i), 10.0 * double(j), 0) + shake();
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j) {
      patch.across_u[i][j] = patch.across_v[i][j] = patch.points[i + 1][j + 1];
      if (int(2 * i + j) < torn) patch.across_v[i][j] += shake();
    }
  return patch;
}

/// mm, the farthest apart at equal parameters, in corners and ever closer to them as well.
double farthest_apart(const GregoryPatch& patch, const NurbsSurface& surface) {
  double worst = 0;
  std::vector<double> at = {0, 1e-9, 1e-6, 1e-3};
  for (int i = 1; i < 20; ++i) at.push_back(i / 20.0);
  for (const double end : {1e-3, 1e-6, 0.0}) at.push_back(1 - end);
  for (const double u : at)
    for (const double v : at) worst = std::max(worst, (patch.at(u, v) - surface.at(u, v)).norm());
  return worst;
}

}  // namespace

TEST_CASE("gregory patch: borders are its cubics, and each sees its own inner control points") {
  const GregoryPatch patch = shaken_patch(4, 1);
  NurbsCurve<3> border, across;
  border.t = across.t = clamped(3, {0, 1});
  for (std::size_t j = 0; j < 4; ++j) border.points.push_back(patch.points[0][j]);
  across.points = {3 * (patch.points[1][0] - patch.points[0][0]), 3 * (patch.across_u[0][0] - patch.points[0][1]),
                   3 * (patch.across_u[0][1] - patch.points[0][2]), 3 * (patch.points[1][3] - patch.points[0][3])};
  NurbsCurve<3> top, over_top;
  top.t = over_top.t = border.t;
  for (std::size_t i = 0; i < 4; ++i) top.points.push_back(patch.points[i][3]);
  over_top.points = {3 * (patch.points[0][3] - patch.points[0][2]), 3 * (patch.points[1][3] - patch.across_v[0][1]),
                     3 * (patch.points[2][3] - patch.across_v[1][1]), 3 * (patch.points[3][3] - patch.points[3][2])};
  for (int k = 0; k <= 20; ++k) {
    const double t = k / 20.0;
    CHECK((patch.at(0, t) - border.at(t)).norm() < 1e-12);
    CHECK((patch.tangents(0, t).du - across.at(t)).norm() < 1e-11);
    CHECK((patch.at(t, 1) - top.at(t)).norm() < 1e-12);
    CHECK((patch.tangents(t, 1).dv - over_top.at(t)).norm() < 1e-11);
  }
}

TEST_CASE("gregory patch: first derivatives are those of the places, up to the corners") {
  const GregoryPatch patch = shaken_patch(3, 2);
  constexpr double h = 1e-6;
  for (const double u : {1e-4, 0.1, 0.5, 0.9999})
    for (const double v : {1e-4, 0.3, 0.8, 0.9999}) {
      const auto t = patch.tangents(u, v);
      CHECK((t.p - patch.at(u, v)).norm() < 1e-12);
      CHECK((t.du - (patch.at(u + h, v) - patch.at(u - h, v)) / (2 * h)).norm() < 1e-3);
      CHECK((t.dv - (patch.at(u, v + h) - patch.at(u, v - h)) / (2 * h)).norm() < 1e-3);
    }
  CHECK((patch.tangents(0, 0).du - 3 * (patch.points[1][0] - patch.points[0][0])).norm() < 1e-11);
  CHECK((patch.tangents(1, 1).dv - 3 * (patch.points[3][3] - patch.points[3][2])).norm() < 1e-11);
  CHECK((patch.tangents(1e-9, 2e-9).normal() - patch.tangents(0, 0).normal()).norm() < 1e-7);
}

TEST_CASE("gregory patch: where twists disagree the mixed derivative depends on how a corner is approached") {
  const GregoryPatch torn = shaken_patch(1, 3);
  const auto twist = [&](double u, double v) {
    const double h = 1e-3 * std::max(u, v);
    return Vec3((torn.tangents(u, v + h).du - torn.tangents(u, v - h).du) / (2 * h));
  };
  // 9 (P00 - P10 - P01 + Q): along each border that of its own inner point.
  const auto twist_of = [&](const Vec3& inner) {
    return Vec3(9 * (torn.points[0][0] - torn.points[1][0] - torn.points[0][1] + inner));
  };
  REQUIRE((twist_of(torn.across_u[0][0]) - twist_of(torn.across_v[0][0])).norm() > 1);
  CHECK((twist(1e-8, 1e-5) - twist_of(torn.across_u[0][0])).norm() < 0.1);
  CHECK((twist(1e-5, 1e-8) - twist_of(torn.across_v[0][0])).norm() < 0.1);
  CHECK((twist(1 - 1e-5, 1 - 1e-5) - twist(1 - 1e-5, 1 - 2e-5)).norm() < 0.5);  // not in a corner that is whole
}

TEST_CASE("gregory patch: as NURBS it is the same surface, of one degree more for each corner that is torn") {
  for (int torn = 0; torn <= 4; ++torn)
    for (const std::uint64_t seed : {4, 5}) {
      const GregoryPatch patch = shaken_patch(torn, seed);
      const NurbsSurface surface = rational_bezier(patch);
      INFO(torn << " torn corners");
      CHECK(surface.u.degree == 3 + torn);
      CHECK(surface.v.degree == 3 + torn);
      CHECK(surface.points.size() == std::size_t((4 + torn) * (4 + torn)));
      CHECK(surface.weights.empty() == (torn == 0));
      for (const double w : surface.weights) CHECK(w > 0);
      CHECK(farthest_apart(patch, surface) < 1e-9);
      for (const double u : {0.0, 1.0})
        for (const double v : {0.0, 1.0}) CHECK((surface.at(u, v) - patch.at(u, v)).norm() < 1e-12);
      // Normals as well, inside, on borders, and close to the corners.
      for (const double u : {0.0, 1e-4, 0.2, 0.7, 1.0})
        for (const double v : {0.3, 0.9999})
          CHECK((normal_at(surface, u, v) - patch.tangents(u, v).normal()).norm() < 1e-7);
    }
}

TEST_CASE("gregory patch: a spoiled conversion is another surface") {
  const GregoryPatch patch = shaken_patch(4, 6);
  NurbsSurface surface = rational_bezier(patch);
  surface.weights[9] *= 1.001;
  CHECK(farthest_apart(patch, surface) > 1e-6);
  CHECK(farthest_apart(patch, rational_bezier(patch, 1e-3)) > 1e-6);  // a corner's weight that is not small
}
