#include "fit/propose/supertoroid.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/propose/superquadric_mixture.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t most_points = 800, screen_points = 300;
constexpr int unknowns = 11;  // shift 3, turn 3, ring, tube, half height, exponents 2
constexpr double least_exponent = 0.1, most_exponent = 2;
using RingGradient = Eigen::Matrix<double, unknowns, 1>;

/// Place, shape and mixture, on data of unit size.
struct Ring : MixtureState {
  Mat3 rotation = Mat3::Identity();  // data_from_shape
  Vec3 centre = Vec3::Zero();
  double major = 1, minor = 0.3, half = 0.3, e1 = 1, e2 = 1;
};

double residual(const Ring& s, const Vec3& point, RingGradient* gradient) {
  const Vec3 q = s.rotation.transpose() * (point - s.centre);
  const SuperellipseGauge in = superellipse_gauge(std::abs(q.x()), std::abs(q.y()), 2 / s.e2);
  const double u = (in.value - s.major) / s.minor, z = q.z() / s.half;
  const SuperellipseGauge out = superellipse_gauge(std::abs(u), std::abs(z), 2 / s.e1);
  const double by_u = std::copysign(out.gx, u) / s.minor, by_z = std::copysign(out.gy, z) / s.half;
  const Vec3 slope(by_u * std::copysign(in.gx, q.x()), by_u * std::copysign(in.gy, q.y()), by_z);
  const double steep = std::max(slope.norm(), 1e-9);
  if (gradient) {
    RingGradient& g = *gradient;
    g.segment<3>(0) = -slope;
    g.segment<3>(3) = -q.cross(slope);
    g[6] = -by_u;
    g[7] = -by_u * u;
    g[8] = -by_z * z;
    g[9] = out.gp * (-2 / (s.e1 * s.e1));
    g[10] = by_u * in.gp * (-2 / (s.e2 * s.e2));
    g /= steep;
  }
  return (out.value - 1) / steep;
}

Ring stepped(const Ring& s, const RingGradient& step) {
  Ring n = s;
  n.centre += s.rotation * step.segment<3>(0);
  n.rotation = s.rotation * rotation_of(step.segment<3>(3));
  const auto scaled = [](double size, double by) { return size * std::exp(std::clamp(by / size, -0.5, 0.5)); };
  n.major = std::clamp(scaled(s.major, step[6]), 0.05, 8.0);
  n.minor = std::clamp(scaled(s.minor, step[7]), 0.01, 0.97 * n.major);
  n.half = std::clamp(scaled(s.half, step[8]), 0.01, 4.0);
  n.e1 = std::clamp(s.e1 + std::clamp(step[9], -0.3, 0.3), least_exponent, most_exponent);
  n.e2 = std::clamp(s.e2 + std::clamp(step[10], -0.3, 0.3), least_exponent, most_exponent);
  return n;
}

/// To a few per cent; of two rings through the same points the smaller one explains them better.
double rough_area(const Ring& s) {
  const auto around = [](double e) { return 8 - (8 - 2 * pi) * std::min(e, 1.0); };  // of the unit superellipse
  return around(s.e2) * s.major * around(s.e1) * 0.5 * (s.minor + s.half);
}

/// An exponent at its bound and pushed outward.
bool held(const Ring& s, int k, double push) {
  if (k < 9) return false;
  const double value = k == 9 ? s.e1 : s.e2;
  return (value <= least_exponent && push < 0) || (value >= most_exponent && push > 0);
}

void improve(Ring& s, const std::vector<Vec3>& points, std::size_t count, double volume, int rounds) {
  constexpr double floor = 1e-5;
  improve_mixture<unknowns>(s, points, count, volume, floor, rounds);
}

/// The frame about an axis, x where the ring reaches farthest out or half a corner beside it, radii from quantiles.
/// `on_axis`: the middle lies on the axis, which partial data do not tell; else in the middle of the data.
void add_starts(const Axis& axis, bool on_axis, const std::vector<Vec3>& points, std::vector<Ring>& starts) {
  Ring s;
  s.rotation = rotation_onto_axis(axis.direction);
  const auto between = [&](const Vec3& direction, double share) {
    std::vector<double> along;
    for (const Vec3& p : points) along.push_back(p.dot(direction));
    return std::pair{quantile(along, share), quantile(along, 1 - share)};
  };
  s.centre = axis.point - axis.direction * axis.direction.dot(axis.point);
  const auto [low, high] = between(axis.direction, 0.03);
  s.centre += axis.direction * (low + high) / 2;
  s.half = std::max((high - low) / 2, 0.03);
  if (!on_axis)
    for (int k = 0; k < 2; ++k) {
      const Vec3 side = s.rotation.col(k);
      const auto [left, right] = between(side, 0.03);
      s.centre += side * ((left + right) / 2 - side.dot(s.centre));
    }
  double mean = 0;
  std::complex<double> corner = 0;
  std::vector<Vec2> flat;
  for (const Vec3& p : points) {
    flat.push_back((s.rotation.transpose() * (p - s.centre)).head<2>());
    mean += flat.back().norm() / double(points.size());
  }
  for (const Vec2& q : flat)
    if (q.norm() > mean) corner += (q.norm() - mean) * std::polar(1.0, 4 * std::atan2(q.y(), q.x()));
  const double turn = std::arg(corner) / 4 - pi / 4;  // corners of a square ring lie between its axes
  for (const double extra : {0.0, pi / 4}) {
    Ring turned = s;
    turned.rotation = s.rotation * rotation_of({0, 0, turn + extra});
    for (const double e2 : {0.5, 0.9}) {
      std::vector<double> rings;
      for (const Vec3& p : points) {
        const Vec3 q = turned.rotation.transpose() * (p - s.centre);
        rings.push_back(superellipse_gauge(std::abs(q.x()), std::abs(q.y()), 2 / e2).value);
      }
      const double inner = quantile(rings, 0.05), outer = quantile(rings, 0.95);
      if (inner < 0.1 * outer) continue;  // no hole
      for (const double e1 : {0.4, 0.9}) {
        Ring start = turned;
        start.major = (inner + outer) / 2, start.minor = std::max((outer - inner) / 2, 0.03), start.e1 = e1,
        start.e2 = e2;
        starts.push_back(start);
      }
    }
  }
}

}  // namespace

SupertoroidFit recover_supertoroid(const std::vector<Vec3>& all, const std::vector<Axis>& axes, Context& context) {
  SupertoroidFit fit;
  std::vector<Vec3> points;
  // Every third of the selection comes first: screening looks at these alone.
  const std::size_t step = std::max<std::size_t>(1, all.size() / most_points);
  for (std::size_t first = 0; first < 3; ++first)
    for (std::size_t i = first * step; i < all.size(); i += 3 * step) points.push_back(all[i]);
  if (points.size() < 50) return fit;
  const std::size_t few = std::min(screen_points, points.size());
  Vec3 origin;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> along;
    for (const Vec3& p : points) along.push_back(p[k]);
    origin[k] = 0.5 * (quantile(along, 0.05) + quantile(along, 0.95));
  }
  std::vector<double> radii;
  for (const Vec3& p : points) radii.push_back((p - origin).norm());
  const double unit = quantile(radii, 0.5);
  if (!(unit > 0)) return fit;
  Box3 box;
  for (Vec3& p : points) p = (p - origin) / unit, box.add(p);
  const double volume = std::max(0.5, box.size().cwiseMax(0.2).prod());

  std::vector<Ring> starts;
  for (Axis axis : axes) {
    axis.point = (axis.point - origin) / unit;
    add_starts(axis, true, points, starts);
    add_starts(axis, false, points, starts);
  }
  for (Ring& s : starts) {
    if (context.cancelled) return fit;
    s.sigma = start_sigma(s, points, few), s.outliers = 0.15;
    improve(s, points, few, volume, 20);
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Ring& a, const Ring& b) { return a.cost < b.cost; });
  if (starts.size() > 4) starts.resize(4);
  Ring best;
  best.cost = 1e300;
  for (Ring& s : starts) {
    improve(s, points, points.size(), volume, 60);
    if (s.cost < best.cost) best = s;
  }
  if (starts.empty()) return fit;
  std::vector<double> misses;
  for (const Vec3& p : points) misses.push_back(unit * std::abs(residual(best, p, nullptr)));
  fit.shape = {unit * best.major, unit * best.minor, unit * best.half, best.e1, best.e2};
  fit.scan_from_shape = {best.rotation, origin + unit * best.centre};
  fit.miss = quantile(misses, 0.5);
  return fit;
}

}  // namespace partscribe::fit
