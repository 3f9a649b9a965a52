/// Distances to ellipsoids and superellipsoids against dense sampling and against known cases.
#include "geometry/surfaces/quadric_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <vector>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::geometry;

namespace {

double power(double base, double exponent) { return std::copysign(std::pow(std::abs(base), exponent), base); }

struct Body {
  double a1, a2, a3, e1, e2, kx, ky;
  Vec3 at(double eta, double omega) const {
    const double c = power(std::cos(eta), e1), z = power(std::sin(eta), e1);
    return {a1 * c * power(std::cos(omega), e2) * (kx * z + 1), a2 * c * power(std::sin(omega), e2) * (ky * z + 1),
            a3 * z};
  }
  double distance(const Vec3& p) const { return superellipsoid_distance(p, a1, a2, a3, e1, e2, kx, ky); }
  bool inside(const Vec3& p) const {
    const double z = p.z() / a3;
    if (std::abs(z) >= 1) return false;
    const double x = std::abs(p.x() / a1 / (kx * z + 1)), y = std::abs(p.y() / a2 / (ky * z + 1));
    return std::pow(std::pow(x, 2 / e2) + std::pow(y, 2 / e2), e2 / e1) + std::pow(std::abs(z), 2 / e1) < 1;
  }
  /// Coarse search over the whole surface, then ever finer grids around the best few places. The parameters are
  /// warped so that samples spread evenly for exponents far from 1.
  double sampled(const Vec3& p) const {
    const auto angle = [](double t, double e) {  // t in [-1, 1] per quarter turn
      const double d = t * pi / 4 + pi / 4, q = std::tan(std::clamp(d, 1e-12, pi / 2 - 1e-12));
      return std::atan(std::pow(q, 1 / e));
    };
    const auto place = [&](double s, double t) {  // s, t in [-2, 2] and [-4, 4]
      const double eta = std::copysign(angle(std::abs(s) - 1, e1), s);
      const double turn = std::floor(t / 2), rest = t - 2 * turn;
      return at(
          eta, turn * pi / 2 + (static_cast<long>(turn) % 2 == 0 ? angle(rest - 1, e2) : pi / 2 - angle(1 - rest, e2)));
    };
    double best = 1e300, bs = 0, bt = 0;
    std::vector<std::array<double, 3>> found;
    const int n = 96;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j < 2 * n; ++j) {
        const double s = -2 + 4.0 * i / n, t = -4 + 8.0 * j / (2 * n);
        found.push_back({(place(s, t) - p).norm(), s, t});
      }
    std::sort(found.begin(), found.end());
    for (std::size_t k = 0; k < 40; ++k) {
      double s0 = found[k][1], t0 = found[k][2], h = 4.0 / n, d0 = found[k][0];
      for (int round = 0; round < 60; ++round) {
        bool moved = false;
        for (int i = -3; i <= 3; ++i)
          for (int j = -3; j <= 3; ++j) {
            const double s = std::clamp(s0 + i * h / 3, -2.0, 2.0), t = t0 + j * h / 3;
            const double d = (place(s, t) - p).norm();
            if (d < d0) d0 = d, bs = s, bt = t, moved = true;
          }
        if (moved)
          s0 = bs, t0 = bt;
        else
          h *= 0.4;
        if (h < 1e-10) break;
      }
      best = std::min(best, d0);
    }
    return inside(p) ? -best : best;
  }
};

/// The search may stick in a narrow valley, so it bounds the truth from above; below it only by its own slack.
void no_worse_than(double distance, double sampled) {
  CHECK(std::signbit(distance) == std::signbit(sampled));
  CHECK(std::abs(distance) <= std::abs(sampled) + 1e-7);
  CHECK(std::abs(distance) >= 0.98 * std::abs(sampled) - 1e-6);
}

}  // namespace

TEST_CASE("ellipsoid distance: the foot point found by brute force is no nearer") {
  Random random(1);
  for (const Vec3& radii :
       {Vec3(30, 20, 10), Vec3(10, 10.0000001, 10), Vec3(50, 50, 0.5), Vec3(1, 60, 1), Vec3(5, 5, 5)}) {
    const Body body{radii.x(), radii.y(), radii.z(), 1, 1, 0, 0};
    for (int i = 0; i < 12; ++i) {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = radii[k] * random.uniform(-1.6, 1.6);
      if (i % 4 == 1) p[i % 3] = 0;
      INFO(radii.transpose() << "  at " << p.transpose());
      no_worse_than(ellipsoid_distance(p, radii), body.sampled(p));
    }
  }
}

TEST_CASE("ellipsoid distance: known places on axes, planes, centre and far away") {
  const Vec3 radii(3, 2, 1);
  CHECK(ellipsoid_distance({0, 0, 0}, radii) == Approx(-1).epsilon(1e-14));
  CHECK(ellipsoid_distance({3, 0, 0}, radii) == Approx(0).margin(1e-15));
  CHECK(ellipsoid_distance({5, 0, 0}, radii) == Approx(2).epsilon(1e-14));
  CHECK(ellipsoid_distance({0, -7, 0}, radii) == Approx(5).epsilon(1e-14));
  CHECK(ellipsoid_distance({0, 0, 0.25}, radii) == Approx(-0.75).epsilon(1e-14));
  CHECK(ellipsoid_distance({1e9, 0, 0}, radii) == Approx(1e9 - 3).epsilon(1e-15));
  // On the long axis short of the centre of curvature (at 3 - 1/3): the foot leaves the axis.
  const double x = 1.0, foot_x = 9 * x / (9 - 1), foot_z = std::sqrt(1 - foot_x * foot_x / 9);
  CHECK(ellipsoid_distance({x, 0, 0}, radii) == Approx(-std::hypot(x - foot_x, foot_z)).epsilon(1e-14));
  CHECK(ellipsoid_distance({x, 0, 1e-18}, radii) == Approx(-std::hypot(x - foot_x, foot_z)).epsilon(1e-12));
  CHECK(ellipsoid_distance({0.3, 0.4, 0}, {2, 2, 2}) == Approx(-1.5).epsilon(1e-14));
}

TEST_CASE("ellipsoid distance: points moved off the surface along the normal come back at that distance") {
  Random random(5);
  const Vec3 radii(40, 25, 7);
  for (int i = 0; i < 500; ++i) {
    const Vec3 u = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const Vec3 x = radii.cwiseProduct(u), n = u.cwiseQuotient(radii).normalized();
    for (double d : {-0.3, 1e-9, 0.01, 5.0, 1000.0})
      CHECK(ellipsoid_distance(x + d * n, radii) == Approx(d).margin(2e-13 * (1 + std::abs(d)) * 40));
  }
}

TEST_CASE("superellipsoid distance: agrees with dense sampling for every kind of exponent and taper") {
  Random random(2);
  const std::vector<Body> bodies = {{30, 20, 10, 1, 1, 0, 0},       {30, 20, 10, 0.1, 0.1, 0, 0},
                                    {20, 20, 40, 0.1, 1, 0, 0},     {20, 15, 40, 0.3, 0.5, 0, 0},
                                    {20, 25, 30, 1.6, 1.8, 0, 0},   {20, 25, 30, 2, 0.1, 0, 0},
                                    {20, 20, 30, 0.1, 1, 0.5, 0.5}, {20, 15, 30, 0.2, 0.2, 0.6, -0.2},
                                    {20, 15, 30, 1, 1, 0.3, 0.3},   {20, 15, 30, 0.7, 1.3, -0.4, 0.1}};
  for (const Body& b : bodies) {
    for (int i = 0; i < 14; ++i) {
      Vec3 p;
      if (i < 8) {  // near the surface, where fits live
        p = b.at(random.uniform(-1.5, 1.5), random.uniform(-3.1, 3.1)) +
            0.8 * Vec3(random.normal(), random.normal(), random.normal());
      } else {
        p = Vec3(b.a1, b.a2, b.a3)
                .cwiseProduct(Vec3(random.uniform(-1.6, 1.6), random.uniform(-1.6, 1.6), random.uniform(-1.6, 1.6)));
        if (i % 3 == 0) p[i % 2] = 0;
      }
      INFO("e " << b.e1 << " " << b.e2 << " taper " << b.kx << " " << b.ky << " at " << p.transpose());
      no_worse_than(b.distance(p), b.sampled(p));
    }
  }
}

TEST_CASE("superellipsoid distance: equals the ellipsoid's where both exponents are 1") {
  Random random(3);
  for (int i = 0; i < 400; ++i) {
    const Vec3 p(random.uniform(-50, 50), random.uniform(-40, 40), random.uniform(-30, 30));
    CHECK(superellipsoid_distance(p, 30, 20, 10, 1, 1, 0, 0) ==
          Approx(ellipsoid_distance(p, {30, 20, 10})).margin(1e-9));
  }
}

TEST_CASE("superellipsoid distance: points moved along the normal come back at that distance, tapered or not") {
  Random random(4);
  double worst = 0;
  for (double taper : {0.0, 0.4}) {
    for (double e : {0.1, 0.4, 1.0, 1.3}) {
      const Body b{20, 15, 30, e, e, taper, taper / 2};
      for (int i = 0; i < 200; ++i) {
        const double eta = random.uniform(0.1, 1.4), omega = random.uniform(0.1, 1.4), h = 1e-5;
        const Vec3 x = b.at(eta, omega);
        const Vec3 n = (b.at(eta, omega + h) - b.at(eta, omega - h))
                           .cross(b.at(eta + h, omega) - b.at(eta - h, omega))
                           .normalized();
        for (double d : {-0.01, 0.0, 0.02, 0.3}) worst = std::max(worst, std::abs(b.distance(x + d * n) - d));
      }
    }
  }
  CHECK(worst < 1e-8);
}

TEST_CASE("superellipsoid distance: a box-like body is nearly the box") {
  // Half sizes 10, exponents 0.1: on the face centres exact, at the corner within the rounding of the shape.
  CHECK(superellipsoid_distance({0, 0, 12}, 10, 10, 10, 0.1, 0.1, 0, 0) == Approx(2).epsilon(1e-12));
  CHECK(superellipsoid_distance({11, 3, 2}, 10, 10, 10, 0.1, 0.1, 0, 0) == Approx(1).epsilon(1e-6));
  CHECK(superellipsoid_distance({0, 0, 0}, 10, 11, 12, 0.1, 0.1, 0, 0) == Approx(-10).epsilon(1e-9));
}

TEST_CASE("superellipsoid distance: takes some microseconds", "[.][speed]") {
  Random random(6);
  for (const Body& b : {Body{20, 15, 30, 1, 1, 0, 0}, Body{20, 15, 30, 0.1, 0.1, 0, 0},
                        Body{20, 15, 30, 0.1, 1, 0.3, 0.3}, Body{20, 15, 30, 1.7, 1.8, 0, 0}}) {
    std::vector<Vec3> points;
    for (int i = 0; i < 20000; ++i)
      points.push_back(b.at(random.uniform(-1.5, 1.5), random.uniform(-3, 3)) +
                       Vec3(0.1 * random.normal(), 0.1 * random.normal(), 0.1 * random.normal()));
    const auto start = std::chrono::steady_clock::now();
    double sum = 0;
    for (const Vec3& p : points) sum += b.distance(p);
    const double us =
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count() / 20000;
    WARN("exponents " << b.e1 << " " << b.e2 << " taper " << b.kx << ": " << us << " us" << (sum == 1e99 ? " " : ""));
  }
}

namespace {

/// Compares distances from `tried` places about each of five rings with the nearest of many samples.
void compare_supertoroids(int tried) {
  struct Ring {
    double major, minor, height, e1, e2;
  };
  for (const Ring& r :
       {Ring{20, 6, 5, 1, 1}, {20, 6, 5, 0.6, 0.7}, {20, 9, 3, 0.2, 0.3}, {20, 4, 8, 1.6, 1}, {20, 6, 6, 1, 1.7}}) {
    auto at = [&](double eta, double omega) {
      const double c = power(std::cos(eta), r.e1), s = power(std::sin(eta), r.e1), radius = r.major + r.minor * c;
      return Vec3(radius * power(std::cos(omega), r.e2), radius * power(std::sin(omega), r.e2), r.height * s);
    };
    // The coarse minimum of many samples, then ever finer grids about it.
    auto sampled = [&](const Vec3& p) {
      constexpr int n = 160;
      struct Found {
        double d, eta, omega;
      };
      std::vector<Found> found;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          auto warped = [](double t, double e) {
            const double c = std::cos(t), s = std::sin(t);
            return std::atan2(power(s, 1 / e), power(c, 1 / e));
          };
          const double eta = warped(2 * pi * i / n, r.e1), omega = warped(2 * pi * j / n, r.e2);
          found.push_back({(at(eta, omega) - p).norm(), eta, omega});
        }
      std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.d < b.d; });
      double best = found[0].d;
      for (std::size_t k = 0; k < 12; ++k) {
        auto [d, eta, omega] = found[k];
        for (double h = 0.2; h > 1e-10;) {
          bool moved = false;
          for (const auto& [a, b] : {std::pair{h, 0.0}, {-h, 0.0}, {0.0, h}, {0.0, -h}}) {
            const double trial = (at(eta + a, omega + b) - p).norm();
            if (trial < d) d = trial, eta += a, omega += b, moved = true;
          }
          if (!moved) h /= 2;
        }
        best = std::min(best, d);
      }
      return best;
    };
    Random random(5);
    int close = 0, near_close = 0, never_less = 0;
    for (int i = 0; i < tried; ++i) {
      const Vec3 far(random.uniform(-35, 35), random.uniform(-35, 35), random.uniform(-15, 15));
      const double d = std::abs(supertoroid_distance(far, r.major, r.minor, r.height, r.e1, r.e2)),
                   truth = sampled(far);
      close += d < truth + 1e-4 * std::max(1.0, truth);
      never_less += d > truth - 1e-4;
      const Vec3 near = at(random.uniform(0, 2 * pi), random.uniform(0, 2 * pi)) +
                        0.2 * Vec3(random.normal(), random.normal(), random.normal());
      near_close += std::abs(supertoroid_distance(near, r.major, r.minor, r.height, r.e1, r.e2)) < sampled(near) + 1e-5;
    }
    INFO("exponents " << r.e1 << ", " << r.e2);
    CHECK(never_less == tried);
    CHECK(close >= tried * 97 / 100);
    CHECK(near_close >= tried * 99 / 100);
  }
}

}  // namespace

TEST_CASE("supertoroid: the distance is that of the nearest of many samples, square rings and sharp tubes included") {
  compare_supertoroids(20);
}

TEST_CASE("supertoroid: so it is from many places", "[.statistics]") { compare_supertoroids(150); }

TEST_CASE("supertoroid: a round one is a torus, inside as outside") {
  Random random(6);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p(random.uniform(-30, 30), random.uniform(-30, 30), random.uniform(-10, 10));
    const double torus = std::hypot(std::hypot(p.x(), p.y()) - 20, p.z()) - 6;
    CHECK(supertoroid_distance(p, 20, 6, 6, 1, 1) == Approx(torus).margin(1e-7));
  }
}
