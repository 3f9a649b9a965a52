/// Distances to bent superellipsoids against dense sampling and against known cases.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "geometry/surfaces/quadric_distance.h"

using namespace partscribe::geometry;

namespace {

struct Horn {
  double a1, a2, a3, e1, e2, kx, ky, bend;

  /// The surface by two angles, or inside and outside of it; the bend as a turn about a centre on the x axis.
  Vec3 at(double around, double up, double scale = 1) const {
    auto on = [](double e, double t) -> Vec2 {
      const double c = std::cos(t), s = std::sin(t), p = 2 / e;
      return Vec2(c, s) * std::pow(std::pow(std::abs(c), p) + std::pow(std::abs(s), p), -1 / p);
    };
    const Vec2 u = on(e2, around), v = scale * on(e1, up);
    const double x = a1 * u.x() * v.x() * (1 + kx * v.y()), y = a2 * u.y() * v.x() * (1 + ky * v.y());
    const double radius = a3 / bend, turn = bend * v.y();
    return {radius - (radius - x) * std::cos(turn), y, (radius - x) * std::sin(turn)};
  }
  BentSuperellipsoid body() const { return {a1, a2, a3, e1, e2, kx, ky, bend}; }

  /// A search over a grid, then around the best places of it in ever finer steps.
  double sampled(const Vec3& p) const {
    struct Found {
      double sq, around, up;
    };
    std::vector<Found> found;
    const int n = 128;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= n / 2; ++j) {
        const double around = -pi + 2 * pi * i / n, up = -pi / 2 + 2 * pi * j / n;
        found.push_back({(at(around, up) - p).squaredNorm(), around, up});
      }
    std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.sq < b.sq; });
    double best = 1e300;
    for (std::size_t k = 0; k < 12; ++k) {
      Found f = found[k];
      for (double step = 2 * pi / n; step > 1e-9; step *= 0.6) {
        const Found from = f;
        for (int i = -2; i <= 2; ++i)
          for (int j = -2; j <= 2; ++j) {
            const double around = from.around + i * step / 2, up = std::clamp(from.up + j * step / 2, -pi / 2, pi / 2);
            const double sq = (at(around, up) - p).squaredNorm();
            if (sq < f.sq) f = {sq, around, up};
          }
      }
      best = std::min(best, f.sq);
    }
    return std::sqrt(best);
  }
};

const std::vector<Horn> horns = {{15, 12, 20, 0.5, 0.8, 0.2, -0.1, 0.6}, {8, 12, 30, 1, 1, 0, 0, 1.5},
                                 {5, 9, 30, 0.2, 0.3, 0.3, 0.2, -1.2},   {6, 6, 40, 0.1, 0.1, 0, 0, 2.9},
                                 {6, 6, 40, 1.6, 1.4, -0.3, 0.3, 2.5},   {10, 10, 20, 1, 0.5, 0.6, 0.9, 1e-4}};

}  // namespace

TEST_CASE("bent superellipsoid: the distance agrees with dense sampling, near the surface and far from it") {
  Random random(4);
  for (const Horn& h : horns) {
    const BentSuperellipsoid body = h.body();
    for (int i = 0; i < 24; ++i) {
      Vec3 p = h.at(random.uniform(-pi, pi), random.uniform(-1.5, 1.5));
      p += (i < 12 ? 0.8 : 12.0) * Vec3(random.normal(), random.normal(), random.normal());
      const double d = std::abs(body.distance(p)), expected = h.sampled(p);
      INFO("e " << h.e1 << " " << h.e2 << " bend " << h.bend << " at " << p.transpose());
      CHECK(d < expected + 2e-4);
      CHECK(d > expected - 2e-3);  // where tips are sharp the samples, not the foot, fall short
    }
  }
}

TEST_CASE("bent superellipsoid: points of the surface have the distance 0, lie in its box, and have two sides") {
  Random random(5);
  for (const Horn& h : horns) {
    const BentSuperellipsoid body = h.body();
    for (int i = 0; i < 60; ++i) {
      const double around = random.uniform(-pi, pi), up = random.uniform(-1.5, 1.5);
      const Vec3 p = h.at(around, up);
      INFO("e " << h.e1 << " " << h.e2 << " bend " << h.bend << " at " << p.transpose());
      CHECK(std::abs(body.distance(p)) < 1e-9);
      CHECK((p.array() >= body.bounds().low.array() - 1e-9).all());
      CHECK((p.array() <= body.bounds().high.array() + 1e-9).all());
      CHECK(body.distance(h.at(around, up, 1.02)) > 0);
      CHECK(body.distance(h.at(around, up, 0.98)) < 0);
    }
  }
}

TEST_CASE(
    "bent superellipsoid: without a bend to speak of it is the straight one, and bending the other way its image") {
  Random random(6);
  const BentSuperellipsoid straight(15, 12, 20, 0.5, 0.8, 0.2, -0.1, 1e-9);
  const BentSuperellipsoid there(15, 12, 20, 0.5, 0.8, 0.2, -0.1, 0.9), back(15, 12, 20, 0.5, 0.8, 0.2, -0.1, -0.9);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(random.uniform(-40, 40), random.uniform(-30, 30), random.uniform(-40, 40));
    CHECK(straight.distance(p) == Approx(superellipsoid_distance(p, 15, 12, 20, 0.5, 0.8, 0.2, -0.1)).margin(1e-6));
    CHECK(there.distance(p) == Approx(back.distance({-p.x(), p.y(), p.z()})).margin(1e-9));
  }
}
