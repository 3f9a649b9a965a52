#include "codegen/alpha1/alpha1_superellipsoid.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "geometry/surfaces/nurbs.h"
#include "geometry/surfaces/quadric_distance.h"
#include "model/distance/distance.h"

namespace partscribe::codegen {
namespace {

/// A point of the unit superellipse |x|^(2/e) + |y|^(2/e) = 1 in direction `angle`.
Vec2 on_unit(double e, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double r = std::pow(std::pow(std::abs(c), 2 / e) + std::pow(std::abs(s), 2 / e), -e / 2);
  return {r * c, r * s};
}

/// Points of a quarter of the superellipse, from the first axis to the second, close together where it bends; the
/// answer for `fraction` in 0..1 is a direction.
class Quarter {
 public:
  Quarter(double e, double size_x, double size_y) {
    constexpr int steps = 4000;
    const double size = std::max(size_x, size_y);
    std::vector<Vec2> p;
    for (int i = 0; i <= steps; ++i) {
      // Denser towards both axes, where exponents above 1 make tips.
      const double t = double(i) / steps, angle = pi / 2 * (t - std::sin(2 * pi * t) / (2 * pi));
      const Vec2 u = on_unit(e, angle);
      angles_.push_back(angle);
      p.push_back({size_x * u.x(), size_y * u.y()});
    }
    sums_.assign(1, 0);
    for (int i = 1; i <= steps; ++i) {
      const Vec2 way = p[std::size_t(i)] - p[std::size_t(i) - 1];
      double turn = 0;
      if (i < steps) {
        const Vec2 next = p[std::size_t(i) + 1] - p[std::size_t(i)];
        turn = std::abs(std::atan2(way.x() * next.y() - way.y() * next.x(), way.dot(next)));
      }
      // Chord error falls with the square of the step: density as the root of the curvature.
      const double length = way.norm();
      sums_.push_back(sums_.back() + 0.6 * length / size + std::sqrt(turn * length / size));
    }
  }
  double direction(double fraction) const {
    const double wanted = std::clamp(fraction, 0.0, 1.0) * sums_.back();
    const auto above = std::upper_bound(sums_.begin(), sums_.end(), wanted);
    if (above == sums_.end()) return angles_.back();
    const auto i = static_cast<std::size_t>(above - sums_.begin());
    const double t = (wanted - sums_[i - 1]) / (sums_[i] - sums_[i - 1]);
    return angles_[i - 1] + t * (angles_[i] - angles_[i - 1]);
  }

 private:
  std::vector<double> angles_, sums_;
};

/// Cubic, on clamped uniform knots 0 .. count - 3.
KnotVector uniform_knots(int count) {
  std::vector<double> breaks;
  for (int i = 0; i <= count - 3; ++i) breaks.push_back(i);
  return clamped(3, breaks);
}

struct Samples {
  const Quarter& latitude;
  const Quarter& longitude;
  double e1, e2;

  /// All round, `turn` in 0..1.
  Vec2 around(double turn) const {
    const double quarters = 4 * (turn - std::floor(turn));
    const int q = std::min(3, static_cast<int>(quarters));
    const double fraction = quarters - q;
    // Mirrored in every other quarter, so that the samples are symmetric to both axes.
    const double direction = longitude.direction(q % 2 == 0 ? fraction : 1 - fraction);
    const Vec2 u = on_unit(e2, direction);
    switch (q) {
      case 0:
        return u;
      case 1:
        return {-u.x(), u.y()};
      case 2:
        return {-u.x(), -u.y()};
      default:
        return {u.x(), -u.y()};
    }
  }
  /// From the lower pole to the upper, `way` in 0..1: radius and height.
  Vec2 along(double way) const {
    const double fraction = std::abs(2 * way - 1);
    if (fraction == 1) return {0, way < 0.5 ? -1 : 1};
    const Vec2 u = on_unit(e1, latitude.direction(fraction));
    return {u.x(), way < 0.5 ? -u.y() : u.y()};
  }
};

/// Control points of the closed uniform cubic through evenly spaced samples.
std::vector<SuperellipsoidNet::Around> through(const std::vector<Vec2>& samples) {
  const auto count = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(count, count), b(count, 2);
  for (Eigen::Index j = 0; j < count; ++j) {
    A(j, (j + count - 1) % count) = A(j, (j + 1) % count) = 1.0 / 6;
    A(j, j) = 4.0 / 6;
    b.row(j) = samples[static_cast<std::size_t>(j)].transpose();
  }
  const Eigen::MatrixXd control = A.partialPivLu().solve(b);
  std::vector<SuperellipsoidNet::Around> net;
  for (Eigen::Index j = 0; j < count; ++j) net.push_back({snapped(control(j, 0), 1e-9), snapped(control(j, 1), 1e-9)});
  return net;
}

/// A place on a closed net at `t`, counted in its control points.
Vec2 closed_at(const std::vector<SuperellipsoidNet::Around>& net, int order, double t) {
  const int n = static_cast<int>(net.size()), j = static_cast<int>(std::floor(t));
  const double f = t - j;
  auto p = [&](int k) {
    const auto& a = net[static_cast<std::size_t>((j + k + n) % n)];
    return Vec2(a.c, a.s);
  };
  if (order == 2) return (1 - f) * p(0) + f * p(1);
  return (std::pow(1 - f, 3) * p(-1) + (3 * f * f * f - 6 * f * f + 4) * p(0) +
          (-3 * f * f * f + 3 * f * f + 3 * f + 1) * p(1) + f * f * f * p(2)) /
         6;
}

/// What bending adds to a place along the net: radius and height of its straight place are u.
Eigen::Matrix<double, 6, 1> bent_along(const Vec2& u, double bend) {
  const double c = std::cos(bend * u.y()), s = std::sin(bend * u.y());
  const Vec3 axis = bent({0, 0, u.y()}, bend);
  Eigen::Matrix<double, 6, 1> v;
  v << u.x() * c, u.x() * u.y() * c, u.x() * s, u.x() * u.y() * s, axis.x(), axis.z();
  return v;
}

/// `added` is a row of the six numbers, in the order of bent_along.
template <class Row>
void set_bent(SuperellipsoidNet::Along& a, const Row& added) {
  a.rc = snapped(added(0), 1e-9), a.qc = snapped(added(1), 1e-9), a.rs = snapped(added(2), 1e-9);
  a.qs = snapped(added(3), 1e-9), a.u = snapped(added(4), 1e-9), a.w = snapped(added(5), 1e-9);
}

SuperellipsoidNet net_of(const Samples& samples, int order, int around, int along, double bend) {
  SuperellipsoidNet net;
  net.order = order;
  auto tidy = [](double v) { return snapped(v, 1e-9); };
  if (order == 2) {
    for (int j = 0; j < around; ++j) {
      const Vec2 u = samples.around(double(j) / around);
      net.around.push_back({tidy(u.x()), tidy(u.y())});
    }
    for (int i = 0; i < along; ++i) {
      const Vec2 u = samples.along(double(i) / (along - 1));
      net.along.push_back({tidy(u.x()), tidy(u.x() * u.y()), tidy(u.y())});
      if (bend != 0) set_bent(net.along.back(), bent_along(u, bend));
    }
    return net;
  }
  std::vector<Vec2> ring;
  for (int j = 0; j < around; ++j) ring.push_back(samples.around(double(j) / around));
  net.around = through(ring);

  Eigen::MatrixXd B(along, along), d(along, 3), added(along, 6);
  const KnotVector knots = uniform_knots(along);
  B.setZero();
  for (int i = 0; i < along; ++i) {
    const auto at = knots.knots.begin() + i;
    const double t = (at[1] + at[2] + at[3]) / 3;
    BasisValues n;
    basis(knots, t, 0, n);
    for (int k = 0; k <= 3; ++k) B(i, n.first + k) = n.value[0][k];
    const Vec2 u = samples.along(t / (along - 3));
    d.row(i) << u.x(), u.x() * u.y(), u.y();
    if (bend != 0) added.row(i) = bent_along(u, bend);
  }
  const Eigen::PartialPivLU<Eigen::MatrixXd> solver = B.partialPivLu();
  const Eigen::MatrixXd up = solver.solve(d);
  for (int i = 0; i < along; ++i) net.along.push_back({tidy(up(i, 0)), tidy(up(i, 1)), tidy(up(i, 2))});
  if (bend != 0) {
    const Eigen::MatrixXd bent = solver.solve(added);
    for (int i = 0; i < along; ++i) set_bent(net.along[static_cast<std::size_t>(i)], bent.row(i));
  }
  for (const double tip : {-1.0, 1.0}) {
    auto& a = tip < 0 ? net.along.front() : net.along.back();
    a = {0, 0, tip};
    if (bend != 0) set_bent(a, bent_along({0, tip}, bend));
  }
  return net;
}

/// The largest distance found between the surface of the net and the superellipsoid.
double deviation_of(const SuperellipsoidNet& net, const SuperellipsoidOf<double>& s, const ModelDistance& distance) {
  const int n = static_cast<int>(net.around.size()), m = static_cast<int>(net.along.size());
  using Row = Eigen::Matrix<double, 9, 1>;
  const KnotVector knots = net.order == 2 ? KnotVector{} : uniform_knots(m);
  auto along_at = [&](double t) -> Row {
    Row sum = Row::Zero();
    auto p = [&](int k) {
      const auto& a = net.along[static_cast<std::size_t>(k)];
      Row row;
      row << a.r, a.q, a.z, a.rc, a.qc, a.rs, a.qs, a.u, a.w;
      return row;
    };
    if (net.order == 2) {
      const int i = std::min(m - 2, static_cast<int>(t));
      return (i + 1 - t) * p(i) + (t - i) * p(i + 1);
    }
    BasisValues n;
    basis(knots, t, 0, n);
    for (int k = 0; k <= 3; ++k) sum += n.value[0][k] * p(n.first + k);
    return sum;
  };
  // One quarter is enough, or half of a bent one: all is symmetric to y = 0, and to x = 0 before it is bent.
  const int per_span = 3, quarters = s.bend == 0 ? 1 : 2;
  const double last = net.order == 2 ? m - 1 : m - 3;
  std::vector<Row> up;
  for (int i = 0; i <= per_span * static_cast<int>(last); ++i) up.push_back(along_at(double(i) / per_span));
  double worst = 0;
  for (int j = 0; j <= per_span * quarters * (n / 4); ++j) {
    const Vec2 u = closed_at(net.around, net.order, double(j) / per_span);
    for (const Row& v : up) {
      const Vec3 p(s.a3 * v[7] + s.a1 * u.x() * (v[3] + s.taper_x * v[4]), s.a2 * u.y() * (v[0] + s.taper_y * v[1]),
                   s.a3 * v[8] - s.a1 * u.x() * (v[5] + s.taper_x * v[6]));
      worst = std::max(worst, std::abs(distance(p).distance));
    }
  }
  return worst;
}

/// A model of this one shape.
ModelDistance distance_to(Shape shape) {
  Model model;
  Object object;
  object.name = "part";
  object.shape = std::move(shape);
  model.objects.push_back(object);
  return ModelDistance(model);
}

}  // namespace

SuperellipsoidNet superellipsoid_net(const SuperellipsoidOf<double>& s, double deviation) {
  const ModelDistance distance =
      distance_to(Superellipsoid{s.a1, s.a2, s.a3, s.e1, s.e2, s.taper_x, s.taper_y, s.bend});
  const double wide = std::max(s.a1, s.a2);
  const Quarter latitude(s.e1, wide, s.a3), longitude(s.e2, s.a1, s.a2);
  const Samples samples{latitude, longitude, s.e1, s.e2};
  struct Size {
    int order, around, along;
  };
  SuperellipsoidNet best;
  best.deviation = 1e300;
  for (const auto& [order, around, along] :
       {Size{4, 16, 11}, Size{4, 24, 15}, Size{4, 32, 21}, Size{4, 48, 31}, Size{4, 64, 41}, Size{4, 96, 61},
        Size{2, 128, 65}, Size{2, 192, 97}, Size{2, 256, 129}}) {
    auto net = net_of(samples, order, around, along, s.bend);
    net.deviation = deviation_of(net, s, distance);
    if (net.deviation < best.deviation) best = std::move(net);
    if (best.deviation <= deviation) break;
  }
  return best;
}

SupertoroidNet supertoroid_net(const SupertoroidOf<double>& s, double deviation) {
  const ModelDistance distance = distance_to(Supertoroid{s.major_radius, s.minor_radius, s.half_height, s.e1, s.e2});
  const double reach = s.major_radius + s.minor_radius;
  const Quarter tube(s.e1, s.minor_radius, s.half_height), ring(s.e2, reach, reach);
  // The samples all round of a superellipse are those of a superellipsoid's equator.
  const Samples tube_samples{tube, tube, s.e1, s.e1}, ring_samples{ring, ring, s.e2, s.e2};
  struct Size {
    int order, around, tube;
  };
  SupertoroidNet best;
  best.deviation = 1e300;
  for (const auto& [order, around, tube_count] :
       {Size{4, 16, 12}, Size{4, 24, 16}, Size{4, 32, 24}, Size{4, 48, 32}, Size{4, 64, 48}, Size{4, 96, 64},
        Size{2, 128, 64}, Size{2, 192, 96}, Size{2, 256, 128}}) {
    SupertoroidNet net;
    net.order = order;
    auto closed = [order = order](const Samples& samples, int count) {
      std::vector<Vec2> points;
      for (int j = 0; j < count; ++j) points.push_back(samples.around(double(j) / count));
      if (order == 4) return through(points);
      std::vector<SuperellipsoidNet::Around> corners;
      for (const auto& p : points) corners.push_back({snapped(p.x(), 1e-9), snapped(p.y(), 1e-9)});
      return corners;
    };
    net.around = closed(ring_samples, around), net.tube = closed(tube_samples, tube_count);
    constexpr int per_span = 3;
    for (int i = 0; i < per_span * tube_count; ++i) {
      const Vec2 t = closed_at(net.tube, order, double(i) / per_span);
      // One quarter is enough: everything is symmetric to x = 0 and y = 0.
      for (int j = 0; j <= per_span * (around / 4); ++j) {
        const Vec2 u = closed_at(net.around, order, double(j) / per_span);
        const double r = s.major_radius + s.minor_radius * t.x();
        const Vec3 p(r * u.x(), r * u.y(), s.half_height * t.y());
        net.deviation = std::max(net.deviation, std::abs(distance(p).distance));
      }
    }
    if (net.deviation < best.deviation) best = std::move(net);
    if (best.deviation <= deviation) break;
  }
  return best;
}

}  // namespace partscribe::codegen
