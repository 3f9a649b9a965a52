#include "fit/input/smoothing.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "fit/evidence/one_sided.h"
#include "fit/refine/refine.h"
#include "model/distance/distance.h"
#include "testing/models.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

constexpr double radius = 8, height = 25;

/// A cylinder that stands on the origin, moved by `place`.
Candidate rod(const Pose& place) {
  Candidate c;
  c.object_name = "part";
  c.shape = Cylinder{Expr::of("radius"), Expr::of("height")};
  for (const auto& [name, value] : {std::pair{"radius", radius}, std::pair{"height", height}}) {
    Parameter p;
    p.name = name, p.value = value;
    c.parameters.push_back(std::move(p));
  }
  c.scan_from_part = place;
  return c;
}

/// One node for each of `places`, in the part's frame, whose face has the normal beside it.
AllPoints nodes_at(const std::vector<std::pair<Vec3, Vec3>>& places, const Pose& place, const ModelDistance& distance) {
  AllPoints all;
  for (const auto& [at, normal] : places) {
    AllPoints::Node node;
    node.begin = all.points.size(), node.end = node.begin + 1, node.place = place * at;
    all.nodes.push_back(node);
    all.points.push_back(node.place);
    all.at.value.push_back(0);
    all.at.face.push_back(distance(at - 1e-3 * normal).face);
    all.jacobian.gradients.push_back(place.rotation * normal);
  }
  return all;
}

}  // namespace

TEST_CASE(
    "smoothing: a mean of the surroundings flattens the side of a cylinder, not its ends, wherever the edge is near") {
  const Pose place{rotation_of({0.3, -0.5, 0.2}), {12, -7, 30}};
  constexpr double variance = 0.25;
  const double reach = 1.5 * std::sqrt(2 * variance);
  const Candidate candidate = rod(place);
  const ModelDistance distance(model_with(candidate.shape, candidate.parameters));
  // Distances to the edge: well within, just within, just beyond and far less than what the mean takes in.
  const std::vector<double> from_edge = {6, 1.01 * reach, 0.9 * reach, 0.1};
  std::vector<std::pair<Vec3, Vec3>> places;
  for (const double angle : {0.1, 1.3, 2.0, 4.1, 5.9})
    for (const double gap : from_edge) {
      const Vec3 out(std::cos(angle), std::sin(angle), 0);
      for (const bool top : {false, true}) {
        places.push_back({(radius - gap) * out + Vec3(0, 0, top ? height : 0), Vec3(0, 0, top ? 1 : -1)});
        places.push_back({radius * out + Vec3(0, 0, top ? height - gap : gap), out});
      }
    }
  const AllPoints all = nodes_at(places, place, distance);
  const SmoothingEffect effect = smoothing_effect(candidate, all, variance, distance, 1);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const bool side = places[k].second.z() == 0;
    const double gap = from_edge[k / 4 % from_edge.size()];
    INFO("node " << k << (side ? " of the side, " : " of an end, ") << gap << " mm from the edge");
    // The mean of a circle of this variance lies so far below the tangent plane.
    const double depth = variance / (2 * radius);
    if (!side) CHECK(effect.face[k] == Approx(0).margin(1e-9));
    if (side) CHECK((effect.face[k] <= 0 && effect.face[k] > -1.5 * depth));  // less where the edge cuts the circle
    if (side && gap > reach) CHECK(effect.face[k] == Approx(-depth).epsilon(0.02));
    if (gap > reach) CHECK(effect.rim[k] == 0);
    if (gap == 0.1) CHECK(effect.rim[k] < -0.02);
  }
}

TEST_CASE("smoothing: what would have rounded every place off, and did not, was no smoothing") {
  AllPoints all;
  constexpr std::size_t count = 400;
  std::vector<double> residuals(count);
  for (std::size_t i = 0; i < count; ++i) {
    AllPoints::Node node;
    node.begin = i, node.end = i + 1;
    all.nodes.push_back(node);
    residuals[i] = i % 2 == 0 ? 0.1 : -0.1;
  }
  all.used.assign(count, 1), all.sigma.assign(count, 0.1);
  CHECK(chance_by_rims(all, residuals, Deviation(count, -1.0), 1) == 0.0);
  CHECK_FALSE(chance_by_rims(all, residuals, Deviation(count, -0.1), 1).has_value());
  CHECK_FALSE(chance_by_rims(all, residuals, Deviation(count, 0.0), 1).has_value());
}

TEST_CASE(
    "one-sided mean: where a view's picture of a slanted face ends, not inside, and not on a face that looks at it") {
  constexpr int side = 20;
  constexpr double variance = 2.0 / 3;  // of a mean over 3 x 3 pixels of 1 mm
  for (const double slope : {0.0, 1.0}) {
    AllPoints all;
    all.by_view = true, all.group_count = 2;
    const Vec3 normal = Vec3(-slope, 0, 1).normalized();
    for (int v = 0; v < all.group_count; ++v)
      for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y) {
          const std::size_t i = all.points.size();
          all.nodes.push_back({i, i + 1, Vec3(x, y, slope * x)});
          all.points.push_back(all.nodes.back().place), all.foot.push_back(all.points.back());
          all.rays.push_back(-Vec3::UnitZ()), all.group.push_back(v);
          all.at.face.push_back(0), all.jacobian.gradients.push_back(normal);
        }
    const auto effect = one_sided_mean(all, variance, 1);
    for (std::size_t k = 0; k < effect.size(); ++k) {
      const double x = all.points[k].x(), y = all.points[k].y();
      INFO("slope " << slope << ", pixel " << x << ", " << y);
      // Of six pixels half lie one step up the slope, of which the normal sees the cosine.
      if (slope > 0 && x == 0 && y > 0 && y < side - 1) CHECK(effect[k] == Approx(0.5 * std::sqrt(0.5)));
      if (slope > 0 && x == side - 1 && y > 0 && y < side - 1) CHECK(effect[k] == Approx(-0.5 * std::sqrt(0.5)));
      if (slope == 0 || (x > 0 && x < side - 1)) CHECK(effect[k] == Approx(0).margin(1e-12));
    }
    all.by_view = false;
    CHECK(one_sided_mean(all, variance, 1) == std::vector<double>(all.nodes.size(), 0));
  }
}
