/// A superellipsoid with linear taper somewhere in space: its gauge at a point, and how that changes with its numbers.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fit/propose/superquadric_mixture.h"

namespace partscribe::fit {

/// Equation (5) of the 1993 paper in its own frame; sizes in the unit of the points.
struct SuperellipsoidBody {
  Mat3 rotation = Mat3::Identity();  ///< data_from_shape
  Vec3 centre = Vec3::Zero();
  Vec3 a = Vec3::Ones();
  double e1 = 1, e2 = 1, k1 = 0, k2 = 0;  ///< exponents of latitude and longitude; tapers of x and y along z
};

inline constexpr int superellipsoid_unknowns = 13;  ///< shift 3, turn 3, ln size 3, exponents 2, tapers 2
using SuperellipsoidGradient = Eigen::Matrix<double, superellipsoid_unknowns, 1>;

/// Signed distance to first order, (N - 1) / |grad N| with the gauge N = F^(1/2) of equation (5), which is finite even
/// at the centre; the radial distance overrates what lies beside elongated bodies. `gradient`: of N, divided by
/// |grad N| as well; `steepness`: |grad N|. Both may be null.
inline double first_order_distance(const SuperellipsoidBody& s, const Vec3& point, SuperellipsoidGradient* gradient,
                                   double* steepness = nullptr) {
  const Vec3 q = s.rotation.transpose() * (point - s.centre);
  const double z = q[2] / s.a[2], t = std::clamp(z, -1.0, 1.0);
  const double h1 = 1 + s.k1 * t, h2 = 1 + s.k2 * t;
  const double x = q[0] / (s.a[0] * h1), y = q[1] / (s.a[1] * h2);
  const double p1 = 2 / s.e1, p2 = 2 / s.e2;
  const SuperellipseGauge in = superellipse_gauge(std::abs(x), std::abs(y), p2);
  const SuperellipseGauge out = superellipse_gauge(in.value, std::abs(z), p1);
  const double nx = std::copysign(out.gx * in.gx, x), ny = std::copysign(out.gx * in.gy, y);
  const double nz = std::copysign(out.gy, z);
  const double grow1 = t == z ? s.k1 / (s.a[2] * h1) : 0, grow2 = t == z ? s.k2 / (s.a[2] * h2) : 0;
  const Vec3 slope(nx / (s.a[0] * h1), ny / (s.a[1] * h2), nz / s.a[2] - nx * x * grow1 - ny * y * grow2);
  const double steep = std::max(slope.norm(), 1e-9), d = (out.value - 1) / steep;
  if (steepness) *steepness = steep;
  if (gradient) {
    SuperellipsoidGradient& g = *gradient;
    const Vec3 n = slope / steep;
    g.segment<3>(0) = -n;
    g.segment<3>(3) = -q.cross(n);
    g[6] = -nx * x / steep;
    g[7] = -ny * y / steep;
    g[8] = -q[2] * n[2];
    g[9] = out.gp / steep * (-2 / (s.e1 * s.e1));
    g[10] = out.gx * in.gp / steep * (-2 / (s.e2 * s.e2));
    g[11] = -nx * x * t / h1 / steep;
    g[12] = -ny * y * t / h2 / steep;
  }
  return d;
}

/// After a step of its unknowns; shift and turn are in its own frame. Exponents stay within 0.1 .. 2.
inline SuperellipsoidBody body_after(const SuperellipsoidBody& s, const SuperellipsoidGradient& step) {
  SuperellipsoidBody n = s;
  n.centre += s.rotation * step.segment<3>(0);
  n.rotation = s.rotation * rotation_of(step.segment<3>(3));
  for (int k = 0; k < 3; ++k) n.a[k] = std::clamp(s.a[k] * std::exp(std::clamp(step[6 + k], -0.7, 0.7)), 0.01, 8.0);
  n.e1 = std::clamp(s.e1 + std::clamp(step[9], -0.4, 0.4), 0.1, 2.0);
  n.e2 = std::clamp(s.e2 + std::clamp(step[10], -0.4, 0.4), 0.1, 2.0);
  n.k1 = std::clamp(s.k1 + std::clamp(step[11], -0.3, 0.3), -0.95, 0.95);
  n.k2 = std::clamp(s.k2 + std::clamp(step[12], -0.3, 0.3), -0.95, 0.95);
  return n;
}

/// Is unknown k at its bound, and `push` beyond it?
inline bool at_bound(const SuperellipsoidBody& s, int k, double push) {
  if (k < 9) return false;
  const double value = k == 9 ? s.e1 : k == 10 ? s.e2 : k == 11 ? s.k1 : s.k2;
  const double low = k < 11 ? 0.1 : -0.95, high = k < 11 ? 2.0 : 0.95;
  return (value <= low && push < 0) || (value >= high && push > 0);
}

}  // namespace partscribe::fit
