/// Foot points on ellipsoids by one scalar equation, on superellipsoids by Newton's method on the surface.
#include "geometry/surfaces/quadric_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"

namespace partscribe::geometry {

double ellipsoid_distance(const Vec3& p, const Vec3& radii) {
  ensure(radii.minCoeff() > 0, "an ellipsoid needs half axes above zero");
  // First octant, axes sorted so that the last is the shortest.
  std::array<int, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return radii[a] != radii[b] ? radii[a] > radii[b] : a < b; });
  Vec3 e, y;
  for (int i = 0; i < 3; ++i)
    e[i] = radii[order[static_cast<std::size_t>(i)]], y[i] = std::abs(p[order[static_cast<std::size_t>(i)]]);

  // Foot point x_i = r_i y_i / (s + r_i) with r_i = (e_i / e_2)^2. The unknown is u = s + 1 > 0, so that nothing
  // cancels where s tends to -1 (points near the short axis's symmetry plane).
  Vec3 z, r, r1;  // y / e, r, r - 1
  for (int i = 0; i < 3; ++i) {
    z[i] = y[i] / e[i];
    r[i] = (e[i] / e[2]) * (e[i] / e[2]);
    r1[i] = (e[i] - e[2]) / e[2] * ((e[i] + e[2]) / e[2]);
  }
  // Each single term bounds u from below; there the sum is between 1 and 3, and as it is convex and falling,
  // Newton climbs to the root without ever passing it.
  double u = std::max({r[0] * z[0] - r1[0], r[1] * z[1] - r1[1], z[2], 0.0});
  const auto term = [&](int i, double at) { return z[i] == 0 ? 0.0 : r[i] * z[i] / (at + r1[i]); };
  if (u == 0) {
    const double f0 = term(0, 0), f1 = term(1, 0), sq = f0 * f0 + f1 * f1;
    if (sq <= 1) {  // inside the focal ellipse of the plane y_2 = 0: the foot leaves the plane
      const Vec3 d(y[0] - e[0] * f0, y[1] - e[1] * f1, e[2] * std::sqrt(1 - sq));
      return -d.norm();
    }
  }
  for (int step = 0; step < 200; ++step) {
    double g = -1, slope = 0;
    for (int i = 0; i < 3; ++i) {
      if (z[i] == 0) continue;
      const double f = r[i] * z[i] / (u + r1[i]);
      g += f * f, slope -= 2 * f * f / (u + r1[i]);
    }
    if (!(g > 0) || slope == 0) break;
    const double next = u - g / slope;
    if (!(next > u)) break;
    const bool done = next - u <= 1e-16 * next;
    u = next;
    if (done) break;
  }
  const double s = u - 1;
  Vec3 d;
  for (int i = 0; i < 3; ++i) d[i] = z[i] == 0 ? 0 : y[i] * (s / (u + r1[i]));
  return s < 0 ? -d.norm() : d.norm();
}

Vec3 bent(const Vec3& p, double curvature) {
  if (curvature == 0) return p;
  const double turn = curvature * p[2], half = std::sin(turn / 2);
  // (1 - cos) / k without cancelling where the bend is slight.
  return {2 * half * half / curvature + p[0] * std::cos(turn), p[1],
          std::sin(turn) / curvature - p[0] * std::sin(turn)};
}

namespace {

constexpr double smallest = 1e-13;  // of a normalised coordinate, so that negative powers stay finite

/// The 2-D gauge (x^p + y^p)^(1/p) of x, y >= 0, homogeneous of degree 1, with its derivatives.
struct Gauge {
  double value = 0, gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0;
};

double gauge_value(double x, double y, double p) {
  const double big = std::max(x, y), small = std::min(x, y);
  if (big <= 0) return 0;
  return big * std::pow(1 + std::pow(small / big, p), 1 / p);
}

Gauge gauge(double x, double y, double p) {
  Gauge g;
  g.value = gauge_value(x, y, p);
  const double s = std::max(g.value, smallest);
  const double ux = std::max(x / s, smallest), uy = std::max(y / s, smallest);
  const double x2 = std::pow(ux, p - 2), y2 = std::pow(uy, p - 2);
  g.gx = x2 * ux, g.gy = y2 * uy;
  const double c = (p - 1) / s;
  g.hxx = c * (x2 - g.gx * g.gx);
  g.hyy = c * (y2 - g.gy * g.gy);
  g.hxy = -c * g.gx * g.gy;
  return g;
}

/// One half (z >= 0) of a superellipsoid, folded into the octant of non-negative coordinates.
struct Octant {
  Vec3 a;         // half sizes
  double p1, p2;  // 2 / e1, 2 / e2
  double k1, k2;  // tapers seen from this half

  Vec3 untapered(const Vec3& x) const {
    const double z = x[2] / a[2], t = std::min(z, 1.0);
    return {x[0] / (a[0] * (1 + k1 * t)), x[1] / (a[1] * (1 + k2 * t)), z};
  }
  Vec3 tapered(const Vec3& w) const {
    return {a[0] * w[0] * (1 + k1 * w[2]), a[1] * w[1] * (1 + k2 * w[2]), a[2] * w[2]};
  }
  double norm(const Vec3& w) const { return gauge_value(gauge_value(w[0], w[1], p2), w[2], p1); }
  /// The surface point of the ray through normalised coordinates `w`.
  Vec3 onto(const Vec3& w) const {
    const Vec3 v = w.cwiseMax(smallest);
    return tapered(v / norm(v));
  }

  /// Gradient and Hessian (mm) of the gauge at a surface point.
  void derivatives(const Vec3& x, Vec3& gradient, Mat3& hessian) const {
    const Vec3 w = untapered(x);
    const Gauge in = gauge(w[0], w[1], p2), out = gauge(in.value, w[2], p1);
    const Vec3 g(out.gx * in.gx, out.gx * in.gy, out.gy);
    Mat3 h;
    h(0, 0) = out.hxx * in.gx * in.gx + out.gx * in.hxx;
    h(1, 1) = out.hxx * in.gy * in.gy + out.gx * in.hyy;
    h(0, 1) = h(1, 0) = out.hxx * in.gx * in.gy + out.gx * in.hxy;
    h(0, 2) = h(2, 0) = out.hxy * in.gx;
    h(1, 2) = h(2, 1) = out.hxy * in.gy;
    h(2, 2) = out.hyy;
    const double h1 = 1 + k1 * w[2], h2 = 1 + k2 * w[2];
    const double s1 = k1 / (a[2] * h1), s2 = k2 / (a[2] * h2);  // relative growth of the section, 1/mm
    Mat3 jacobian = Mat3::Zero();
    jacobian(0, 0) = 1 / (a[0] * h1), jacobian(1, 1) = 1 / (a[1] * h2), jacobian(2, 2) = 1 / a[2];
    jacobian(0, 2) = -w[0] * s1, jacobian(1, 2) = -w[1] * s2;
    gradient = jacobian.transpose() * g;
    hessian = jacobian.transpose() * h * jacobian;
    const double c0 = -s1 * jacobian(0, 0) * g[0], c1 = -s2 * jacobian(1, 1) * g[1];
    hessian(0, 2) += c0, hessian(2, 0) += c0;
    hessian(1, 2) += c1, hessian(2, 1) += c1;
    hessian(2, 2) += 2 * w[0] * s1 * s1 * g[0] + 2 * w[1] * s2 * s2 * g[1];
  }
};

/// The same bent: `x` stays what it is before bending.
struct BentOctant : Octant {
  double curvature;

  /// `pull`: from the place of x towards p, seen before bending; `stretch`: what bending adds to the second derivative
  /// of half the squared distance.
  void pulled(const Vec3& p, const Vec3& x, Vec3& pull, Mat3& stretch) const {
    const Vec3 r = p - bent(x, curvature);
    const double c = std::cos(curvature * x[2]), s = std::sin(curvature * x[2]), rho = 1 - curvature * x[0];
    const double along = r[2] * c + r[0] * s, across = r[0] * c - r[2] * s;
    pull = {across, r[1], rho * along};
    stretch.setZero();
    stretch(0, 2) = stretch(2, 0) = curvature * along;
    stretch(2, 2) = rho * rho - 1 - curvature * rho * across;
  }
};

template <class Surface>
Vec3 place_of(const Surface& shape, const Vec3& x) {
  if constexpr (requires { shape.curvature; })
    return bent(x, shape.curvature);
  else
    return x;
}

/// Walks from surface point `x` to the foot of `p`: Newton on the Lagrangian in the tangent plane, drawn back onto
/// the surface along rays. A coordinate shrinks to no less than a fiftieth per step, because exponents above 1 make
/// the curvature unbounded at the symmetry planes. Returns the squared distance.
template <class Surface>
double walk_to_foot(const Surface& shape, const Vec3& p, Vec3 x) {
  const double size = shape.a.maxCoeff();
  constexpr bool bends = requires { shape.curvature; };
  double sq = (p - place_of(shape, x)).squaredNorm();
  for (int step = 0; step < 60; ++step) {
    Vec3 gradient, r = p - x;
    Mat3 hessian, stretch;
    shape.derivatives(x, gradient, hessian);
    if constexpr (bends) shape.pulled(p, x, r, stretch);
    const Vec3 n = gradient.normalized();
    const double lambda = r.dot(gradient) / gradient.squaredNorm();
    const Vec3 t1 = (std::abs(n[0]) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)).cross(n).normalized();
    const Vec3 t2 = n.cross(t1);
    const double b1 = t1.dot(r), b2 = t2.dot(r);
    const Vec3 ht1 = hessian * t1, ht2 = hessian * t2;
    double m11 = 1 + lambda * t1.dot(ht1), m22 = 1 + lambda * t2.dot(ht2);
    double m12 = lambda * t1.dot(ht2);
    if constexpr (bends) m11 += t1.dot(stretch * t1), m22 += t2.dot(stretch * t2), m12 += t1.dot(stretch * t2);
    const double lowest = 0.5 * (m11 + m22) - std::hypot(0.5 * (m11 - m22), m12);
    if (lowest < 0.05) m11 += 0.05 - lowest, m22 += 0.05 - lowest;  // inside, beyond the centre of curvature
    const double det = m11 * m22 - m12 * m12;
    const Vec3 move = t1 * ((b1 * m22 - b2 * m12) / det) + t2 * ((b2 * m11 - b1 * m12) / det);
    if (!(move.norm() > 1e-13 * size)) break;

    Vec3 next = x;
    double next_sq = sq;
    const auto try_steps = [&](const Vec3& step_vector) {
      double share = 1;
      for (int attempt = 0; attempt < 12; ++attempt, share *= 0.4) {
        const Vec3 trial =
            shape.onto(shape.untapered((x + share * step_vector).cwiseMax(0.02 * x).cwiseMax(smallest * shape.a)));
        const double trial_sq = (p - place_of(shape, trial)).squaredNorm();
        if (trial_sq >= sq) continue;
        if (trial_sq < next_sq) next = trial, next_sq = trial_sq;
        return;
      }
    };
    try_steps(move);
    // Near a sharp edge in a symmetry plane the foot slides along the edge.
    for (int i = 0; i < 3; ++i) {
      if (x[i] + move[i] >= 0.02 * x[i] || x[i] > 1e-3 * shape.a[i]) continue;
      const Vec3 along = n.cross(Vec3::Unit(i)).normalized();
      const double slope = along.dot(r);
      double bend = 1 + lambda * along.dot(hessian * along);
      if constexpr (bends) bend += along.dot(stretch * along);
      if (std::abs(slope) > 1e-13 * size) try_steps(along * (slope / std::max(bend, 0.05)));
    }
    if (!(next_sq < sq)) break;
    const double moved = (next - x).norm();
    x = next, sq = next_sq;
    if (moved <= 1e-12 * size) break;
  }
  return sq;
}

/// The octant of non-negative coordinates of a supertoroid.
struct RingOctant {
  Vec3 a;  // half sizes of the whole
  double major, minor, height;
  double p1, p2;  // 2 / e1, 2 / e2

  Vec3 untapered(const Vec3& x) const { return x; }
  double across(const Vec3& x) const { return (gauge_value(x[0], x[1], p2) - major) / minor; }
  double norm(const Vec3& x) const { return gauge_value(std::abs(across(x)), x[2] / height, p1); }
  /// The surface point on the ray from the tube's centre line through x, at x's own azimuth.
  Vec3 onto(const Vec3& x) const {
    const Vec3 v = x.cwiseMax(smallest * a);
    const double ring = gauge_value(v[0], v[1], p2);
    double r = (ring - major) / minor, z = v[2] / height;
    const double n = gauge_value(std::abs(r), z, p1);
    if (n > 0)
      r /= n, z /= n;
    else
      r = 1;
    const double grown = (major + minor * r) / ring;
    return {v[0] * grown, v[1] * grown, height * z};
  }

  void derivatives(const Vec3& x, Vec3& gradient, Mat3& hessian) const {
    const double unit = major + minor;
    const Gauge in = gauge(x[0] / unit, x[1] / unit, p2);  // its Hessian is per unit
    const double r = (in.value * unit - major) / minor, side = r < 0 ? -1 : 1;
    const Gauge out = gauge(std::abs(r), x[2] / height, p1);
    const double c = side / minor;
    gradient = {out.gx * c * in.gx, out.gx * c * in.gy, out.gy / height};
    const double hxx = out.hxx * c * c, bend = out.gx * c / unit;
    hessian(0, 0) = hxx * in.gx * in.gx + bend * in.hxx;
    hessian(1, 1) = hxx * in.gy * in.gy + bend * in.hyy;
    hessian(0, 1) = hessian(1, 0) = hxx * in.gx * in.gy + bend * in.hxy;
    hessian(0, 2) = hessian(2, 0) = out.hxy * c / height * in.gx;
    hessian(1, 2) = hessian(2, 1) = out.hxy * c / height * in.gy;
    hessian(2, 2) = out.hyy / (height * height);
  }
};

/// Starts for the half that `shape` describes; `p` is folded into x, y >= 0. Returns the smallest squared distance.
double half_distance(const Octant& shape, const Vec3& p, bool inside) {
  struct Start {
    double sq;
    Vec3 x;
  };
  std::array<Start, 5> starts;
  std::size_t count = 0;
  const auto add = [&](const Vec3& w) {
    // A start inside leaves the symmetry planes: on them the walk would be balanced on a ridge.
    const Vec3 x = shape.onto(inside ? Vec3(w.cwiseMax(1e-3)) : w);
    starts[count++] = {(p - x).squaredNorm(), x};
  };
  const Vec3 w = shape.untapered(p.cwiseMax(0));
  add(w.maxCoeff() > 0 ? w : Vec3(1e-3, 1e-3, 1));
  if (inside) {  // straight to the walls as well
    add({2, w[1], w[2]}), add({w[0], 2, w[2]}), add({w[0], w[1], 2});
    for (std::size_t i = 1; i < 4; ++i) {  // onto() scales; find the true wall point by sliding one coordinate
      const int axis = static_cast<int>(i) - 1;
      Vec3 v = w;
      const double rest = axis == 2 ? gauge_value(w[0], w[1], shape.p2) : gauge_value(w[1 - axis], 0, shape.p2);
      if (axis == 2) {
        v[2] = std::pow(std::max(0.0, 1 - std::pow(rest, shape.p1)), 1 / shape.p1);
      } else {
        const double s = std::pow(std::max(0.0, 1 - std::pow(w[2], shape.p1)), shape.p2 / shape.p1);
        v[axis] = std::pow(std::max(0.0, s - std::pow(rest, shape.p2)), 1 / shape.p2);
      }
      count = i;
      add(v);
    }
  } else {
    add(w.cwiseMin(1));
    if (p[2] < 0) add({std::min(1.0, w[0]), std::min(1.0, w[1]), 1e-3});
  }
  std::stable_sort(starts.begin(), starts.begin() + static_cast<std::ptrdiff_t>(count),
                   [](const Start& a, const Start& b) { return a.sq < b.sq; });
  double best = walk_to_foot(shape, p, starts[0].x);
  // Outside, or just under the surface of a convex body, there is one foot only.
  const double depth = std::sqrt(best), reach = 0.03 * shape.a.minCoeff();
  if ((inside && depth > reach) || shape.k1 != 0 || shape.k2 != 0)
    for (std::size_t i = 1; i < count; ++i)
      if (starts[i].sq < 4 * best + reach * reach) best = std::min(best, walk_to_foot(shape, p, starts[i].x));
  return best;
}

}  // namespace

double superellipsoid_distance(const Vec3& p, double a1, double a2, double a3, double e1, double e2, double taper_x,
                               double taper_y) {
  ensure(a1 > 0 && a2 > 0 && a3 > 0 && e1 > 0 && e2 > 0, "a superellipsoid needs sizes and exponents above zero");
  const bool straight = taper_x == 0 && taper_y == 0;
  const double side = p[2] < 0 ? -1 : 1;
  Octant shape{{a1, a2, a3}, 2 / e1, 2 / e2, side * taper_x, side * taper_y};
  Vec3 q = p.cwiseAbs();
  const bool inside = q[2] <= a3 && shape.norm(shape.untapered(q)) <= 1;
  double sq = half_distance(shape, q, inside);
  if (!straight && sq > q[2] * q[2]) {  // the other half begins at z = 0, so it can only then be nearer
    shape.k1 = -shape.k1, shape.k2 = -shape.k2, q[2] = -q[2];
    sq = std::min(sq, half_distance(shape, q, inside));
  }
  return inside ? -std::sqrt(sq) : std::sqrt(sq);
}

double supertoroid_distance(const Vec3& p, double major, double minor, double half_height, double e1, double e2) {
  ensure(minor > 0 && half_height > 0 && e1 > 0 && e2 > 0, "a supertoroid needs sizes and exponents above zero");
  const double reach = major + minor;
  const RingOctant shape{{reach, reach, half_height}, major, minor, half_height, 2 / e1, 2 / e2};
  const Vec3 q = p.cwiseAbs().cwiseMax(smallest * shape.a);
  const bool inside = shape.norm(q) <= 1;
  struct Start {
    double sq;
    Vec3 x;
  };
  std::array<Start, 12> starts;
  std::size_t count = 0;
  const auto add = [&](const Vec3& x) {
    // A little off the symmetry planes, or the walk would be balanced on a ridge.
    const Vec3 s = shape.onto(inside || shape.across(q) < 0 ? Vec3(x.cwiseMax(1e-3 * shape.a)) : x);
    starts[count++] = {(q - s).squaredNorm(), s};
  };
  add(q);
  const double ring = gauge_value(q[0], q[1], shape.p2), z = q[2] / half_height;
  const double r = std::abs(shape.across(q));
  if (r < 1) add({q[0], q[1], half_height * std::pow(1 - std::pow(r, shape.p1), 1 / shape.p1)});
  // The walls at this height, or the crest above it, in the direction of the ring's centre, of x and of y.
  const double width = z < 1 ? minor * std::pow(1 - std::pow(z, shape.p1), 1 / shape.p1) : 0;
  const double height = std::min(q[2], half_height);
  for (const double wall : {major + width, major - width}) {
    if (ring > 0) add({q[0] * wall / ring, q[1] * wall / ring, height});
    for (const int axis : {0, 1}) {
      const double other = q[1 - axis] / wall;
      if (other >= 1) continue;
      Vec3 x = q;
      x[axis] = wall * std::pow(1 - std::pow(other, shape.p2), 1 / shape.p2), x[2] = height;
      add(x);
    }
    if (width == 0) break;
  }
  std::stable_sort(starts.begin(), starts.begin() + static_cast<std::ptrdiff_t>(count),
                   [](const Start& a, const Start& b) { return a.sq < b.sq; });
  double best = walk_to_foot(shape, q, starts[0].x);
  // Just above or below the surface there is one foot only.
  const double near = 0.03 * std::min(minor, half_height);
  if (best > near * near)
    for (std::size_t i = 1; i < std::min<std::size_t>(count, 4); ++i)
      best = std::min(best, walk_to_foot(shape, q, starts[i].x));
  return inside ? -std::sqrt(best) : std::sqrt(best);
}

namespace {

constexpr int bent_steps = 16;  // of the grid, each way in an octant

/// The octant of a side: 1 where x is below 0, 2 where z is.
BentOctant octant_of(const Vec3& half, const Vec3& exponents, const Vec3& tapers, double curvature, std::size_t side) {
  const double x = side & 1 ? -1 : 1, z = side & 2 ? -1 : 1;
  return {{half, exponents[0], exponents[1], z * tapers[0], z * tapers[1]}, x * curvature};
}

Vec3 folded(const Vec3& p, std::size_t side) {
  return {side & 1 ? -p[0] : p[0], std::abs(p[1]), side & 2 ? -p[2] : p[2]};
}

/// Where a bent place was before from its side of the bend: for points within half a turn.
Vec3 unbent(const Vec3& p, double curvature) {
  const double radius = 1 / curvature, r = std::hypot(radius - p[0], p[2]);
  const double turn = std::atan2(p[2], radius - p[0]);
  return {(p[0] * (2 * radius - p[0]) - p[2] * p[2]) / (radius + r), p[1], turn * radius};
}

}  // namespace

BentSuperellipsoid::BentSuperellipsoid(double a1, double a2, double a3, double e1, double e2, double taper_x,
                                       double taper_y, double bend)
    : half_(a1, a2, a3), exponents_(2 / e1, 2 / e2, 0), tapers_(taper_x, taper_y, 0), curvature_(bend / a3) {
  ensure(a1 > 0 && a2 > 0 && a3 > 0 && e1 > 0 && e2 > 0, "a superellipsoid needs sizes and exponents above zero");
  ensure(bend != 0 && std::abs(bend) < pi, "a bent superellipsoid is bent, by less than half a turn");
  for (std::size_t side = 0; side < 4; ++side) {
    const BentOctant octant = octant_of(half_, exponents_, tapers_, curvature_, side);
    for (int j = 0; j <= bent_steps; ++j)
      for (int i = 0; i <= bent_steps; ++i) {
        // A little off the symmetry planes, or the walk would be balanced on a ridge.
        const auto angle = [](int k) { return std::clamp(pi / 2 * k / bent_steps, 1e-3, pi / 2 - 1e-3); };
        const double around = angle(i), up = angle(j);
        const Vec3 x = octant.onto({std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up)});
        grids_[side].push_back({x, bent(x, octant.curvature)});
      }
  }
  // The straight box between two radii about the centre of the bend, over the angles up to the bend.
  const double radius = a3 / std::abs(bend), wide = a1 * (1 + std::abs(taper_x)), turn = std::abs(bend);
  const double far = radius - std::cos(turn) * (turn < pi / 2 ? radius - wide : radius + wide);
  const double high = (radius + wide) * (turn < pi / 2 ? std::sin(turn) : 1.0), deep = a2 * (1 + std::abs(taper_y));
  bounds_.add({bend > 0 ? -wide : -far, -deep, -high}), bounds_.add({bend > 0 ? far : wide, deep, high});
}

bool BentSuperellipsoid::inside(const Vec3& p) const {
  const double side = curvature_ < 0 ? -1 : 1;
  const Vec3 x = unbent({side * p[0], p[1], p[2]}, side * curvature_);
  const BentOctant octant = octant_of(half_, exponents_, tapers_, curvature_, (x[0] < 0) + 2 * (x[2] < 0));
  return std::abs(x[2]) <= half_[2] && octant.norm(octant.untapered(x.cwiseAbs())) <= 1;
}

double BentSuperellipsoid::distance(const Vec3& p) const {
  struct Start {
    double sq, spacing;
    std::size_t side;
    const Vec3* x;
  };
  std::vector<Start> starts;
  constexpr int n = bent_steps + 1;
  std::array<double, n * n> sq;
  for (std::size_t side = 0; side < 4; ++side) {
    const Vec3 q = folded(p, side);
    const auto& grid = grids_[side];
    for (std::size_t k = 0; k < grid.size(); ++k) sq[k] = (q - grid[k].bent).squaredNorm();
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto k = static_cast<std::size_t>(j * n + i);
        bool least = true;
        double spacing = 0;
        for (int v = std::max(j - 1, 0); v <= std::min(j + 1, n - 1) && least; ++v)
          for (int u = std::max(i - 1, 0); u <= std::min(i + 1, n - 1) && least; ++u) {
            const auto m = static_cast<std::size_t>(v * n + u);
            least = sq[k] <= sq[m];
            spacing = std::max(spacing, (grid[k].bent - grid[m].bent).squaredNorm());
          }
        if (least) starts.push_back({sq[k], std::sqrt(spacing), side, &grid[k].straight});
      }
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.sq < b.sq; });
  double best = 1e300;
  for (const Start& s : starts)
    if (std::sqrt(s.sq) - s.spacing < std::sqrt(best))
      best = std::min(best,
                      walk_to_foot(octant_of(half_, exponents_, tapers_, curvature_, s.side), folded(p, s.side), *s.x));
  return inside(p) ? -std::sqrt(best) : std::sqrt(best);
}

double superellipsoid_radial_distance(const Vec3& p, double a1, double a2, double a3, double e1, double e2,
                                      double taper_x, double taper_y) {
  const double side = p[2] < 0 ? -1 : 1;
  const Octant shape{{a1, a2, a3}, 2 / e1, 2 / e2, side * taper_x, side * taper_y};
  const Vec3 w = shape.untapered(p.cwiseAbs());
  const double n = shape.norm(w);
  if (!(n > 0)) return -std::min({a1, a2, a3});
  const Vec3 straight(a1 * w[0], a2 * w[1], a3 * w[2]);
  return straight.norm() * (1 - 1 / n);
}

}  // namespace partscribe::geometry
