#include "fit/propose/turned_primitives.h"

#include <algorithm>
#include <cmath>

#include "core/sample_consensus.h"
#include "core/statistics.h"
#include "fit/propose/torus_piece.h"
#include "fit/sketch/length_parameter.h"
#include "fit/sketch/plane_chain.h"

namespace partscribe::fit {
namespace {

constexpr int draws = 300;

struct Line {
  Vec2 point = Vec2::Zero(), direction = Vec2(0, 1);
  std::size_t count = 0;
  double radius_at(double height) const { return point.x() + (height - point.y()) * direction.x() / direction.y(); }
};

/// The slanted or upright line that holds most points.
Line wall_of(const std::vector<PlanePoint>& points, double band, Random& random) {
  Line best;
  const auto votes = [&](const Line& line, double) {
    const Vec2 n(line.direction.y(), -line.direction.x());
    return double(std::ranges::count_if(points, [&](const PlanePoint& p) {
      return std::abs(n.dot(p.position - line.point)) < band && std::abs(n.dot(p.normal)) > 0.9;
    }));
  };
  bool by_normal = false;
  const auto through_one_or_two = [&](auto offer) {
    const PlanePoint &a = drawn_from(points, random), &b = drawn_from(points, random);
    Line line;
    line.point = a.position;
    by_normal = !by_normal;
    line.direction = by_normal ? Vec2(-a.normal.y(), a.normal.x()) : b.position - a.position;
    if (!(line.direction.norm() > (by_normal ? 0.5 : 4 * band))) return;
    line.direction.normalize();
    if (line.direction.y() < 0) line.direction = -line.direction;
    if (line.direction.y() >= 0.25) offer(line);
  };
  if (const auto found = consensus<Line>(draws, 0, through_one_or_two, votes))
    best = found->hypothesis, best.count = static_cast<std::size_t>(found->support);
  for (int round = 0; round < 6 && best.count > 10; ++round) {
    const Vec2 n(best.direction.y(), -best.direction.x());
    Vec2 mean = Vec2::Zero();
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    double count = 0;
    const auto on = [&](const PlanePoint& p) {
      return std::abs(n.dot(p.position - best.point)) < band && std::abs(n.dot(p.normal)) > 0.9;
    };
    for (const auto& p : points)
      if (on(p)) mean += p.position, count += 1;
    if (count < 10) break;
    mean /= count;
    for (const auto& p : points)
      if (on(p)) scatter += (p.position - mean) * (p.position - mean).transpose();
    const double angle = 0.5 * std::atan2(2 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
    Vec2 d(std::cos(angle), std::sin(angle));
    if (d.y() < 0) d = -d;
    if (d.y() < 0.25) break;
    best.point = mean, best.direction = d, best.count = static_cast<std::size_t>(count);
  }
  return best;
}

/// Height of the flat end near `height`: the middle of its points, or where the wall ends.
double end_height(const std::vector<PlanePoint>& points, const Line& wall, double height, double reach, bool& seen) {
  std::vector<double> level;
  for (const auto& p : points)
    if (std::abs(p.normal.y()) > 0.9 && std::abs(p.position.y() - height) < reach &&
        p.position.x() < wall.radius_at(height) + reach)
      level.push_back(p.position.y());
  seen = level.size() >= 15;
  return seen ? quantile(level, 0.5) : height;
}

struct Circle {
  Vec2 centre = Vec2::Zero();
  double radius = 0;
  std::size_t count = 0;
};

Circle tube_of(const std::vector<PlanePoint>& points, double band, double size, Random& random) {
  const auto where_two_meet = [&](auto offer) {
    const PlanePoint &a = drawn_from(points, random), &b = drawn_from(points, random);
    const auto meeting = where_normals_meet(a, b, 0.3);
    if (!meeting) return;
    const Circle c{meeting->place, 0.5 * (meeting->from_a + meeting->from_b), 0};
    if (c.radius > 3 * band && c.radius < size && c.centre.x() > 1.02 * c.radius) offer(c);
  };
  const auto points_on = [&](const Circle& c, double) {
    return double(std::ranges::count_if(points, [&](const PlanePoint& p) {
      const Vec2 q = p.position - c.centre;
      const double r = q.norm();
      return std::abs(r - c.radius) < band && std::abs(q.dot(p.normal)) > 0.9 * r;
    }));
  };
  const auto best = consensus<Circle>(draws, 0, where_two_meet, points_on);
  if (!best) return {};
  return {best->hypothesis.centre, best->hypothesis.radius, static_cast<std::size_t>(best->support)};
}

}  // namespace

std::vector<Candidate> propose_turned_primitives(const FitInput& input, const Axis& axis) {
  std::vector<Candidate> result;
  std::vector<PlanePoint> points;  // in the half plane of radius (x) and height (y)
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 d = input.cloud.points[i] - axis.point;
    const double h = d.dot(axis.direction);
    const Vec3 radial = d - h * axis.direction;
    const double rho = radial.norm();
    const Vec3& n = input.cloud.normals[i];
    const Vec2 normal(rho > 0 ? n.dot(radial) / rho : 0, n.dot(axis.direction));
    if (normal.norm() > 0.9) points.push_back({{rho, h}, normal.normalized()});
  }
  if (points.size() < 50) return result;
  const double size = input.bounds.diagonal();
  const double band = std::max(2.5 * input.sampling.sigma, 0.3 * input.tolerance);
  Random random(1);
  const auto placed = [&](Candidate& c, double origin, bool turned_over) {
    c.scan_from_part.rotation = rotation_onto_axis(turned_over ? Vec3(-axis.direction) : axis.direction);
    c.scan_from_part.translation = axis.point + axis.direction * origin;
  };

  const Line wall = wall_of(points, band, random);
  if (5 * wall.count > points.size()) {
    const Vec2 n(wall.direction.y(), -wall.direction.x());
    std::vector<double> heights, radii;
    for (const auto& p : points)
      if (std::abs(n.dot(p.position - wall.point)) < band && std::abs(n.dot(p.normal)) > 0.9)
        heights.push_back(p.position.y()), radii.push_back(p.position.x());
    // The outermost may be outliers in the wall's continuation.
    double low = quantile(heights, 0.003), high = quantile(heights, 0.997);
    const double reach = std::max(0.06 * size, 2 * band);
    bool low_seen = false, high_seen = false;
    low = end_height(points, wall, low, reach, low_seen), high = end_height(points, wall, high, reach, high_seen);
    const std::string open = low_seen && high_seen ? "" : "; an end was not scanned, the data end there";
    const double at_low = wall.radius_at(low), at_high = wall.radius_at(high);
    if (high - low > 2 * band) {
      Candidate rod;
      rod.procedure = "cylinder", rod.object_name = "rod";
      rod.shape = Cylinder{Expr::of("radius"), Expr::of("height")};
      rod.parameters = {length_parameter("radius", quantile(radii, 0.5), "radius of the cylinder"),
                        length_parameter("height", high - low, "height of the cylinder" + open)};
      placed(rod, low, false);
      if (std::abs(at_low - at_high) < 4 * band) result.push_back(rod);

      // The wide end is the bottom.
      const bool over = at_high > at_low;
      const double wide = over ? at_high : at_low, narrow = over ? at_low : at_high;
      const double slope = (wide - narrow) / (high - low);
      if (narrow > 0 && wide > 0) {
        Candidate frustum;
        frustum.procedure = "frustum of a cone", frustum.object_name = "frustum";
        frustum.shape = Cone{Expr::of("bottom_radius"), Expr::of("top_radius"), Expr::of("height")};
        frustum.parameters = {length_parameter("bottom_radius", wide, "radius at the bottom"),
                              length_parameter("top_radius", narrow, "radius at the top"),
                              length_parameter("height", high - low, "height" + open)};
        placed(frustum, over ? high : low, over);
        result.push_back(frustum);
      }
      const bool top_seen = over ? low_seen : high_seen;
      if (slope > 0.05 && !top_seen && narrow < 0.35 * wide) {
        Candidate cone;
        cone.procedure = cone.object_name = "cone";
        cone.shape = Cone{Expr::of("bottom_radius"), Expr(0), Expr::of("height")};
        cone.parameters = {length_parameter("bottom_radius", wide, "radius of the base"),
                           length_parameter("height", wide / slope, "height of the tip above the base")};
        placed(cone, over ? high : low, over);
        result.push_back(cone);
      }
    }
  }
  const Circle tube = tube_of(points, band, size, random);
  if (10 * tube.count > 7 * points.size()) {
    Candidate ring = torus_candidate(tube.centre.x(), tube.radius, {});
    placed(ring, tube.centre.y(), false);
    result.push_back(ring);
  }
  return result;
}

}  // namespace partscribe::fit
