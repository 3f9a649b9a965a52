#include "testing/primitives.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"

namespace partscribe::testing::primitives {

namespace {

Vec3 direction(Random& random) { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); }

/// A primitive moved by the unknowns of its kind: three shifts, two tilts, radius, tube, half angle.
Primitive moved(const Primitive& p, int unknown, double by) {
  Primitive q = p;
  const Vec3 u = p.axis.unitOrthogonal(), v = p.axis.cross(u);
  if (unknown < 3) q.point[unknown] += by;
  if (unknown == 3) q.axis = (p.axis + by * u).normalized();
  if (unknown == 4) q.axis = (p.axis + by * v).normalized();
  if (unknown == 5) q.radius += by;
  if (unknown == 6) q.tube += by;
  if (unknown == 7) q.half_angle += by;
  return q;
}

bool has(PrimitiveKind kind, int unknown) {
  const bool round = kind != PrimitiveKind::plane && kind != PrimitiveKind::line;
  if (unknown < 3) return true;
  if (unknown < 5) return kind != PrimitiveKind::sphere;
  if (unknown == 5) return round;
  return unknown == 6 ? kind == PrimitiveKind::torus : kind == PrimitiveKind::cone;
}

/// The residuals of a point: one, or two for curves (across a line; outwards and upwards of a circle).
Eigen::Vector2d residuals(const Primitive& p, const Vec3& q, const Vec3& u, const Vec3& v) {
  const Vec3 d = q - p.point;
  const double h = d.dot(p.axis);
  if (p.kind == PrimitiveKind::line) return {(d - h * p.axis).dot(u), (d - h * p.axis).dot(v)};
  if (p.kind == PrimitiveKind::circle) return {(d - h * p.axis).norm() - p.radius, h};
  return {distance(p, q), 0};
}

}  // namespace

Primitive example(PrimitiveKind kind, double offset, Random& random) {
  Primitive p;
  p.kind = kind;
  p.point = offset * direction(random);
  p.axis = direction(random);
  if (kind != PrimitiveKind::plane && kind != PrimitiveKind::line) p.radius = kind == PrimitiveKind::torus ? 30 : 20;
  if (kind == PrimitiveKind::torus) p.tube = 10;
  if (kind == PrimitiveKind::cone) p.half_angle = 0.4;
  return p;
}

Scan scan(const Primitive& p, std::size_t count, double arc, double sigma, Random& random) {
  const Mat3 turn = rotation_onto_axis(p.axis);
  Scan scan;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = random.uniform(-arc / 2, arc / 2);
    const Vec3 across(std::cos(a), std::sin(a), 0), up = Vec3::UnitZ();
    Vec3 q = Vec3::Zero(), n = Vec3::Zero();
    switch (p.kind) {
      case PrimitiveKind::plane:
        q = Vec3(random.uniform(-30, 30), random.uniform(-30, 30), 0), n = up;
        break;
      case PrimitiveKind::line:
        q = random.uniform(-30, 30) * up;
        break;
      case PrimitiveKind::circle:
        q = p.radius * across;
        break;
      case PrimitiveKind::sphere: {
        const double z = std::sin(std::min(arc, pi) / 2) * random.uniform(-1, 1);
        n = std::sqrt(1 - z * z) * across + z * up;
        q = p.radius * n;
        break;
      }
      case PrimitiveKind::cylinder:
        q = p.radius * across + random.uniform(-20, 20) * up, n = across;
        break;
      case PrimitiveKind::cone: {
        const double h = random.uniform(-15, 15);
        q = (p.radius + h * std::tan(p.half_angle)) * across + h * up;
        n = std::cos(p.half_angle) * across - std::sin(p.half_angle) * up;
        break;
      }
      case PrimitiveKind::torus: {
        const double widest = p.radius < p.tube ? std::acos(-p.radius / p.tube) : pi,
                     b = random.uniform(-widest, widest);
        n = std::cos(b) * across + std::sin(b) * up;
        q = p.radius * across + p.tube * n;
        break;
      }
    }
    const Vec3 noise =
        n == Vec3::Zero() ? Vec3(random.normal(), random.normal(), random.normal()) : Vec3(random.normal() * n);
    scan.points.push_back(p.point + turn * (q + sigma * noise));
    scan.normals.push_back(turn * n);
  }
  return scan;
}

Primitive start(const Primitive& truth, double angle, double share, Random& random) {
  Primitive p = truth;
  p.axis = rotation_of(angle * direction(random).cross(truth.axis).normalized()) * truth.axis;
  const auto scaled = [&](double value) { return value * (random.uniform() < 0.5 ? 1 - share : 1 + share); };
  p.radius = scaled(p.radius), p.tube = scaled(p.tube), p.half_angle = scaled(p.half_angle);
  p.point += share * std::max(truth.radius, 10.0) * direction(random);
  return p;
}

double number(const Primitive& p, const Primitive& truth) {
  switch (p.kind) {
    case PrimitiveKind::plane:
      return p.axis.dot(truth.axis) < 0 ? distance(p, truth.point) : -distance(p, truth.point);
    case PrimitiveKind::line: {
      const Vec3 d = p.point - truth.point;
      return (d - d.dot(p.axis) * p.axis).dot(truth.axis.unitOrthogonal());
    }
    case PrimitiveKind::cone:
      return p.half_angle;
    case PrimitiveKind::torus:
      return p.tube;
    default:
      return p.radius;
  }
}

double number_sigma(const PrimitiveFit& fit) {
  switch (fit.primitive.kind) {
    case PrimitiveKind::plane:
    case PrimitiveKind::line:
      return fit.sigma_point;
    case PrimitiveKind::cone:
      return fit.sigma_half_angle;
    case PrimitiveKind::torus:
      return fit.sigma_tube;
    default:
      return fit.sigma_radius;
  }
}

double bound(const Primitive& truth, const std::vector<Vec3>& points, double sigma) {
  // In a frame of its own and of size 1, so that one step suits all differences.
  Primitive p = truth;
  p.point.setZero();
  constexpr double step = 1e-4;
  const Vec3 u = p.axis.unitOrthogonal(), v = p.axis.cross(u);
  Eigen::Matrix<double, 8, 8> H = Eigen::Matrix<double, 8, 8>::Zero();
  for (const Vec3& at : points) {
    const Vec3 q = at - truth.point;
    Eigen::Matrix<double, 8, 2> J = Eigen::Matrix<double, 8, 2>::Zero();
    for (int i = 0; i < 8; ++i)
      if (has(p.kind, i))
        J.row(i) =
            (residuals(moved(p, i, step), q, u, v) - residuals(moved(p, i, -step), q, u, v)).transpose() / (2 * step);
    H += J * J.transpose();
  }
  Eigen::Matrix<double, 8, 1> g = Eigen::Matrix<double, 8, 1>::Zero(), scale;
  for (int i = 0; i < 8; ++i) {
    if (has(p.kind, i)) g[i] = (number(moved(p, i, step), p) - number(moved(p, i, -step), p)) / (2 * step);
    scale[i] = H(i, i) > 0 ? 1 / std::sqrt(H(i, i)) : 0;
  }
  // What the points leave open (a shift along an axis) has eigenvalue 0 and no share in the number.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> solver(scale.asDiagonal() * H * scale.asDiagonal());
  const Eigen::Matrix<double, 8, 1> turned = solver.eigenvectors().transpose() * (scale.asDiagonal() * g);
  double variance = 0;
  for (int i = 0; i < 8; ++i)
    if (solver.eigenvalues()[i] > 1e-9) variance += turned[i] * turned[i] / solver.eigenvalues()[i];
  return sigma * std::sqrt(variance);
}

double rms(const Primitive& p, const std::vector<Vec3>& points) {
  double sum = 0;
  for (const Vec3& q : points) sum += distance(p, q) * distance(p, q);
  return std::sqrt(sum / static_cast<double>(points.size()));
}

}  // namespace partscribe::testing::primitives
