#include "fit/ring.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>

#include "core/number.h"
#include "core/statistics.h"
#include "geometry/quadric_distance.h"

namespace partscribe {
namespace {

constexpr std::size_t most_points = 600;

struct Start {
  Pose scan_from_part;
  SupertoroidOf<double> shape;
  double miss = 1e300;
};

/// The frame about `axis` with its origin in the middle of the data.
Pose frame_about(const Vec3& axis, const Vec3& first, const std::vector<Vec3>& points) {
  Pose pose;
  const Vec3 z = axis.normalized(), x = (first - first.dot(z) * z).normalized();
  pose.rotation << x, z.cross(x), z;
  Vec3 middle;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> along;
    for (const auto& p : points) along.push_back(pose.rotation.col(k).dot(p));
    middle[k] = (quantile(along, 0.02) + quantile(along, 0.98)) / 2;
  }
  pose.translation = pose.rotation * middle;
  return pose;
}

/// Where the ring reaches farthest out, four times a turn, as an angle from x.
double corner_angle(const Pose& pose, const std::vector<Vec3>& points) {
  const Pose part_from_scan = pose.inverse();
  double mean = 0;
  for (const auto& p : points) mean += (part_from_scan * p).head<2>().norm() / static_cast<double>(points.size());
  std::complex<double> sum = 0;
  for (const auto& p : points) {
    const Vec3 q = part_from_scan * p;
    sum += (q.head<2>().norm() - mean) * std::polar(1.0, 4 * std::atan2(q.y(), q.x()));
  }
  return std::arg(sum) / 4;
}

void try_exponents(const Pose& pose, const std::vector<Vec3>& points, Start& best) {
  const Pose part_from_scan = pose.inverse();
  std::vector<Vec3> local;
  std::vector<double> heights;
  for (const auto& p : points) local.push_back(part_from_scan * p), heights.push_back(std::abs(local.back().z()));
  for (const double e2 : {0.3, 0.7, 1.0}) {
    std::vector<double> rings;
    for (const auto& q : local)
      rings.push_back(std::pow(std::pow(std::abs(q.x()), 2 / e2) + std::pow(std::abs(q.y()), 2 / e2), e2 / 2));
    const double inner = quantile(rings, 0.02), outer = quantile(rings, 0.98);
    if (inner < 0.1 * outer) continue;  // no hole
    for (const double e1 : {0.3, 0.7, 1.0}) {
      const SupertoroidOf<double> shape{(inner + outer) / 2, (outer - inner) / 2, quantile(heights, 0.98), e1, e2};
      if (!(shape.half_height > 0) || !(shape.minor_radius > 0)) continue;
      std::vector<double> misses;
      for (const auto& q : local)
        misses.push_back(std::abs(supertoroid_distance(q, shape.major_radius, shape.minor_radius, shape.half_height, e1, e2)));
      const double miss = quantile(misses, 0.5);
      if (miss < best.miss) best = {pose, shape, miss};
    }
  }
}

Parameter parameter(const char* name, Quantity quantity, double value, const char* note) {
  Parameter p;
  p.name = name, p.quantity = quantity, p.value = p.fitted = value, p.note = note;
  return p;
}

}  // namespace

std::vector<Candidate> propose_rings(const FitInput& input, const std::vector<Vec3>& axes, Context& context) {
  std::vector<Candidate> result;
  const auto& cloud = input.cloud;
  if (cloud.size() < 50 || input.bounds.empty()) return result;
  std::vector<Vec3> points;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / most_points);
  for (std::size_t i = 0; i < cloud.size(); i += step) points.push_back(cloud.points[i]);

  Start best;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (context.cancelled) return result;
    const Vec3 other = axes[(k + 1) % axes.size()];
    if (other.cross(axes[k]).norm() < 0.1) continue;
    const Pose pose = frame_about(axes[k], other, points);
    // Square rings have their corners between the axes, diamonds on them: one turn serves both.
    const double turn = corner_angle(pose, points) - pi / 4;
    const Vec3 x = pose.rotation * Vec3(std::cos(turn), std::sin(turn), 0);
    try_exponents(frame_about(axes[k], x, points), points, best);
  }
  context.report("rings", 1);
  const double diagonal = input.bounds.diagonal();
  const double close = std::max({3 * input.tolerance, 3 * input.sampling.sigma, 0.015 * diagonal});
  if (!(best.miss < close)) return result;
  Candidate c;
  c.procedure = "supertoroid", c.object_name = "ring_body";
  c.shape = Supertoroid{Expr::of("ring_radius"), Expr::of("tube_half_width"), Expr::of("tube_half_height"),
                        Expr::of("exponent_1"), Expr::of("exponent_2")};
  c.parameters = {parameter("ring_radius", Quantity::length, best.shape.major_radius, "radius of the ring's centre line along x and y"),
                  parameter("tube_half_width", Quantity::length, best.shape.minor_radius, "half width of the tube"),
                  parameter("tube_half_height", Quantity::length, best.shape.half_height, "half height of the tube"),
                  parameter("exponent_1", Quantity::ratio, best.shape.e1, "the tube: 0.1 square, 1 round, 2 diamond"),
                  parameter("exponent_2", Quantity::ratio, best.shape.e2, "the ring: 0.1 square, 1 round, 2 diamond")};
  c.scan_from_part = best.scan_from_part;
  result.push_back(std::move(c));
  return result;
}

}  // namespace partscribe
