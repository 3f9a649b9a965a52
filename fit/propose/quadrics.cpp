/// Starts for sphere, ellipsoid and superellipsoid that survive outliers and data from one side.
#include "fit/propose/quadrics.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/propose/ball.h"
#include "fit/search/equal_choices.h"
#include "geometry/least_squares.h"
#include "geometry/surfaces/quadric_distance.h"

namespace partscribe::fit {

namespace {

constexpr std::size_t quadric_points = 4000;

double median_distance(const std::vector<Vec3>& points, const std::function<double(const Vec3&)>& distance) {
  std::vector<double> d;
  for (const Vec3& p : points) d.push_back(std::abs(distance(p)));
  return median(std::move(d));
}

struct EllipsoidStart {
  Pose scan_from_part;
  Vec3 radii = Vec3::Ones();
  double distance(const Vec3& p) const {
    return ellipsoid_distance(scan_from_part.rotation.transpose() * (p - scan_from_part.translation), radii);
  }
};

/// Longest axis along x, shortest along z, both as near to the scan's as their senses let them.
EllipsoidStart tidied(const EllipsoidStart& e) {
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return e.radii[a] > e.radii[b]; });
  EllipsoidStart t = e;
  for (int k = 0; k < 3; ++k) {
    t.radii[k] = e.radii[order[static_cast<std::size_t>(k)]];
  }
  const auto axis = [&](std::size_t k) { return Vec3(e.scan_from_part.rotation.col(order[k])); };
  const Vec3 x = nearest_sense(axis(0), {0, 1, 2}), z = nearest_sense(axis(2));
  t.scan_from_part.rotation << x, z.cross(x), z;
  return t;
}

/// The quadric through the points by reweighted least squares with trace 3; nothing if it is no ellipsoid.
std::optional<EllipsoidStart> ellipsoid_through(const std::vector<Vec3>& points, const Vec3& origin, double unit,
                                                double reach) {
  EllipsoidStart e;
  const auto fit = [&](const std::vector<double>& weights) {
    NormalSums<9> sums;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 q = (points[i] - origin) / unit;
      const double x = q.x(), y = q.y(), z = q.z();
      NormalSums<9>::Row row;
      row << x * x + y * y - 2 * z * z, x * x + z * z - 2 * y * y, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z,
          1;
      sums.add(row, q.squaredNorm(), weights[i]);
    }
    const NormalSums<9>::Row u = sums.solution(1e-10 * sums.h.trace());
    Mat3 m;  // q^T m q - 2 v.q = u8
    m << 1 - u[0] - u[1], -u[2], -u[3], -u[2], 1 - u[0] + 2 * u[1], -u[4], -u[3], -u[4], 1 + 2 * u[0] - u[1];
    const Vec3 v(u[5], u[6], u[7]);
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(m);
    if (!(eigen.eigenvalues()[0] > 1e-3)) return false;
    const Vec3 centre = solve_ldlt(m, v);
    const double level = u[8] + centre.dot(v);
    if (!(level > 0)) return false;
    e.scan_from_part = {eigen.eigenvectors(), origin + unit * centre};
    for (int k = 0; k < 3; ++k) e.radii[k] = unit * std::sqrt(level / eigen.eigenvalues()[k]);
    return true;
  };
  const auto off = [&](std::size_t i) { return e.distance(points[i]); };
  return reweighted(points.size(), {12, 2, reach, 0.8}, fit, off) ? std::optional(e) : std::nullopt;
}

Parameter parameter(const std::string& name, Quantity quantity, double value, const std::string& note) {
  Parameter p;
  p.name = name, p.quantity = quantity, p.value = p.fitted = value, p.note = note;
  return p;
}

/// Neighbours in the cloud lie near each other; a step through its order is even enough and always the same.
std::vector<Vec3> even_selection(const std::vector<Vec3>& all) {
  std::vector<Vec3> selected;
  const std::size_t step = std::max<std::size_t>(1, all.size() / quadric_points);
  for (std::size_t i = 0; i < all.size(); i += step) selected.push_back(all[i]);
  return selected;
}

/// mm: of the data; within which a point counts; within which a start may be refined.
struct Scale {
  double diagonal = 0, reach = 0, close = 0;
};

Scale scale_of(const FitInput& input) {
  const double diagonal = input.bounds.empty() ? 0 : input.bounds.diagonal(), noise = 3 * input.sampling.sigma;
  return {diagonal, std::max({noise, input.tolerance, 1e-6 * diagonal}), std::max(3 * input.tolerance, noise)};
}

}  // namespace

std::vector<Candidate> propose_quadrics(const FitInput& input, const SuperellipsoidFit& hypothesis, Context& context) {
  std::vector<Candidate> result;
  const auto& cloud = input.cloud;
  if (cloud.size() < 50) return result;
  const std::vector<Vec3> points = even_selection(cloud.points);
  const std::vector<Vec3> normals = cloud.normals.size() == cloud.size()
                                        ? even_selection(cloud.normals)
                                        : std::vector<Vec3>(points.size(), Vec3::Zero());
  const auto [diagonal, reach, close] = scale_of(input);
  if (!(diagonal > 0)) return result;
  const Vec3 origin = input.bounds.center();
  const double unit = 0.5 * diagonal;

  // A ball: from the points, and from the normals; a quarter of a ball with outliers defeats the first.
  std::vector<Ball> balls = {ball_through(points, origin, unit)};
  if (!cloud.normals.empty()) balls.push_back(ball_of_normals(points, normals, origin, unit));
  Ball ball;
  double ball_miss = 1e300;
  for (Ball& b : balls) {
    polish_ball(b, points, reach);
    const double miss = median_distance(points, [&](const Vec3& p) { return (p - b.centre).norm() - b.radius; });
    if (b.centre.allFinite() && b.radius > 0 && miss < ball_miss) ball_miss = miss, ball = b;
  }
  if (ball_miss < close + 0.003 * diagonal && ball.radius < 3 * diagonal) {  // flatter than that is a plane
    Candidate c;
    c.procedure = "sphere", c.object_name = "ball";
    c.shape = Sphere{Expr::of("radius")};
    c.parameters = {parameter("radius", Quantity::length, ball.radius, "radius of the ball")};
    c.scan_from_part.translation = ball.centre;
    result.push_back(c);
  }
  context.report("quadrics", 0.4);

  std::vector<EllipsoidStart> starts;
  if (auto e = ellipsoid_through(points, origin, unit, reach)) starts.push_back(*e);
  const Hypothesis& h = hypothesis.hypothesis;
  const bool hypothetical = h.a1 > 0 && h.a2 > 0 && h.a3 > 0;
  if (hypothetical) starts.push_back({hypothesis.scan_from_shape, Vec3(h.a1, h.a2, h.a3)});
  double miss = 1e300;
  EllipsoidStart best;
  for (const EllipsoidStart& e : starts) {
    if (!(e.radii.maxCoeff() < 1.5 * diagonal) || !e.radii.allFinite()) continue;
    const double m = median_distance(points, [&](const Vec3& p) { return e.distance(p); });
    if (m < miss) miss = m, best = e;
  }
  if (miss < close + 0.005 * diagonal) {
    best = tidied(best);
    Candidate c;
    c.procedure = "ellipsoid", c.object_name = "ellipsoid_body";
    c.shape = Ellipsoid{Expr::of("radius_x"), Expr::of("radius_y"), Expr::of("radius_z")};
    c.parameters = {parameter("radius_x", Quantity::length, best.radii.x(), "longest half axis"),
                    parameter("radius_y", Quantity::length, best.radii.y(), "middle half axis"),
                    parameter("radius_z", Quantity::length, best.radii.z(), "shortest half axis")};
    c.scan_from_part = best.scan_from_part;
    result.push_back(c);
  }
  context.report("quadrics", 1);
  return result;
}

namespace {

Candidate superellipsoid_of(const Hypothesis& h, const Pose& scan_from_shape) {
  Candidate c;
  c.procedure = "superellipsoid", c.object_name = "superellipsoid_body";
  Superellipsoid s{Expr::of("half_size_1"),
                   Expr::of("half_size_2"),
                   Expr::of("half_size_3"),
                   Expr::of("exponent_1"),
                   Expr::of("exponent_2"),
                   0,
                   0};
  c.parameters = {parameter("half_size_1", Quantity::length, h.a1, "half size along x"),
                  parameter("half_size_2", Quantity::length, h.a2, "half size along y"),
                  parameter("half_size_3", Quantity::length, h.a3, "half size along z"),
                  parameter("exponent_1", Quantity::ratio, h.e1, "seen from the side: 0.1 square, 1 round, 2 diamond"),
                  parameter("exponent_2", Quantity::ratio, h.e2, "seen from the top: 0.1 square, 1 round, 2 diamond")};
  if (h.taper_x != 0 || h.taper_y != 0) {
    s.taper_x = Expr::of("taper_x"), s.taper_y = Expr::of("taper_y");
    c.parameters.push_back(parameter("taper_x", Quantity::ratio, h.taper_x, "growth of x from the middle to the top"));
    c.parameters.push_back(parameter("taper_y", Quantity::ratio, h.taper_y, "growth of y from the middle to the top"));
  }
  c.shape = s;
  c.scan_from_part = scan_from_shape;
  return c;
}

/// A section that is nearly a diamond as the rounded square that it nearly is as well, an eighth of a turn on.
Candidate as_rounded_square(Hypothesis h, Pose scan_from_shape) {
  h.a1 = h.a2 = std::sqrt(h.a1 * h.a2) * std::pow(2, 0.5 * (1 - h.e2));
  h.e2 = 2 - h.e2, h.taper_x = h.taper_y = 0;
  scan_from_shape.rotation = scan_from_shape.rotation * rotation_of(Vec3(0, 0, pi / 4));
  return superellipsoid_of(h, scan_from_shape);
}

}  // namespace

std::vector<Candidate> propose_superellipsoids(const FitInput& input, const SuperellipsoidFit& hypothesis) {
  constexpr double diamond = 1.1, least_exponent = 0.1;
  const Hypothesis& h = hypothesis.hypothesis;
  const Scale scale = scale_of(input);
  if (input.cloud.size() < 50 || !(h.a1 > 0 && h.a2 > 0 && h.a3 > 0) || !(scale.diagonal > 0)) return {};
  const Pose part_from_scan = hypothesis.scan_from_shape.inverse();
  const double off = median_distance(even_selection(input.cloud.points), [&](const Vec3& p) {
    return superellipsoid_distance(part_from_scan * p, h.a1, h.a2, h.a3, h.e1, h.e2, h.taper_x, h.taper_y);
  });
  if (!(off < scale.close + 0.005 * scale.diagonal)) return {};
  std::vector<Candidate> result = {superellipsoid_of(h, hypothesis.scan_from_shape)};
  if (h.e2 > diamond && h.e2 < 2 - least_exponent) result.push_back(as_rounded_square(h, hypothesis.scan_from_shape));
  return result;
}

}  // namespace partscribe::fit
