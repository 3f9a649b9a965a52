#include "testing/registration/parts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/number.h"

namespace partscribe::testing::registration {

Surface convex(const std::vector<Side>& sides, double reach) {
  Surface surface;
  surface.bounds.add(Vec3::Constant(-reach)), surface.bounds.add(Vec3::Constant(reach));
  surface.first_hit = [sides](const Vec3& origin, const Vec3& direction) -> std::optional<SurfaceHit> {
    double in = -1e30, out = 1e30;
    Vec3 normal = Vec3::Zero();
    for (const Side& s : sides) {
      const double rate = s.normal.dot(direction), gap = s.offset - s.normal.dot(origin);
      if (rate < 0 && gap / rate > in)
        in = gap / rate, normal = s.normal;
      else if (rate > 0)
        out = std::min(out, gap / rate);
      else if (rate == 0 && gap < 0)
        return {};
    }
    if (in >= out || in < 0) return {};
    return SurfaceHit{in, normal};
  };
  return surface;
}

std::vector<Side> block_sides(const Vec3& half) {
  std::vector<Side> sides;
  for (int k = 0; k < 3; ++k)
    for (const double s : {1.0, -1.0}) sides.push_back({s * Vec3::Unit(k), half[k]});
  return sides;
}

FirstHit nearer_of(FirstHit a, FirstHit b) {
  return [a = std::move(a), b = std::move(b)](const Vec3& o, const Vec3& d) {
    const auto on_a = a(o, d), on_b = b(o, d);
    return on_b && (!on_a || on_b->distance < on_a->distance) ? on_b : on_a;
  };
}

Surface plain_block() {
  std::vector<Side> sides = block_sides({14, 17, 20});
  sides.push_back({Vec3(1, 0.8, 0).normalized(), 14}), sides.push_back({Vec3(0, -1, 0.7).normalized(), 18}),
      sides.push_back({Vec3(-1, 1, 1).normalized(), 18});
  return convex(sides, 22);
}

Surface cut_block() {
  std::vector<Side> sides = block_sides({14, 17, 20});
  const auto cut = [&](const Vec3& n, double d) { sides.push_back({n.normalized(), d}); };
  cut({1, 1, 1}, 20), cut({1, -1, 0.6}, 19), cut({-1, 0.7, 1}, 22), cut({-0.6, -1, 1}, 18);
  cut({1, 0.5, -1}, 21), cut({-1, -1, -0.8}, 20.5), cut({0.4, -1, -1}, 23), cut({-1, 1, -0.5}, 19.5);
  return convex(sides, 22);
}

Surface block_alike_from_two_sides(double difference) {
  std::vector<Side> sides = block_sides({12, 16, 20});
  const auto cut_twice = [&](const Vec3& n, double d, double less) {
    sides.push_back({n.normalized(), d}), sides.push_back({Vec3(-n.x(), -n.y(), n.z()).normalized(), d + less});
  };
  cut_twice({1, 0.8, 0.9}, 19, difference), cut_twice({1, -0.9, 0.5}, 17.5, 0), cut_twice({0.7, 1, -1}, 20, 0);
  cut_twice({1, -0.6, -0.8}, 18, 0), cut_twice({0.2, 1, 0.5}, 19, 0);
  return convex(sides, 24);
}

Surface prism_alike_from_sides(int count, double difference) {
  std::vector<Side> sides{{Vec3::UnitZ(), 16}, {-Vec3::UnitZ(), 16}};
  const auto around = [](double angle, double z) { return Vec3(std::cos(angle), std::sin(angle), z).normalized(); };
  for (int k = 0; k < count; ++k) {
    const double face = 2 * pi * k / count, edge = face + pi / count;
    sides.push_back({around(face, 0), 15});
    sides.push_back({around(edge, 1), k == 0 ? 18 + difference : 18});
    sides.push_back({around(edge + 0.2, -0.8), 19.5});
  }
  return convex(sides, 24);
}

Surface posed(const Surface& part, const Pose& pose) {
  Surface moved;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p = part.bounds.low;
    for (int k = 0; k < 3; ++k)
      if (corner >> k & 1) p[k] = part.bounds.high[k];
    moved.bounds.add(pose * p);
  }
  moved.first_hit = [hit = part.first_hit, pose](const Vec3& o, const Vec3& d) {
    auto found = hit(pose.inverse() * o, pose.rotation.transpose() * d);
    if (found) found->normal = pose.rotation * found->normal;
    return found;
  };
  return moved;
}

Surface union_of(const std::vector<Ball>& parts, double reach) {
  Surface surface;
  surface.bounds.add(Vec3::Constant(-reach)), surface.bounds.add(Vec3::Constant(reach));
  surface.first_hit = [parts](const Vec3& o, const Vec3& d) -> std::optional<SurfaceHit> {
    std::optional<SurfaceHit> best;
    for (const auto& [center, radius] : parts) {
      const double along = (center - o).dot(d), sq = radius * radius - (o + along * d - center).squaredNorm();
      if (sq <= 0) continue;
      const double t = along - std::sqrt(sq);
      if (t > 0 && (!best || t < best->distance)) best = SurfaceHit{t, (o + t * d - center) / radius};
    }
    return best;
  };
  return surface;
}

Surface balls() {
  return union_of({{{0, 0, 0}, 12},
                   {{11, 2, 3}, 8},
                   {{-8, 7, 4}, 9},
                   {{1, -11, 5}, 7},
                   {{3, 4, -12}, 6.5},
                   {{-6, -6, -9}, 6},
                   {{2, 8, 11}, 5}},
                  20);
}

Surface ball(double radius) { return union_of({{Vec3(0, 0, 0), radius}}, radius); }

Surface cylinder() {
  Surface surface;
  surface.bounds.add(Vec3(-10, -10, -15)), surface.bounds.add(Vec3(10, 10, 15));
  surface.first_hit = [](const Vec3& o, const Vec3& d) -> std::optional<SurfaceHit> {
    const double a = d.head<2>().squaredNorm(), b = o.head<2>().dot(d.head<2>()), c = o.head<2>().squaredNorm() - 100;
    double best = 1e30;
    Vec3 normal = Vec3::Zero();
    if (b * b > a * c) {
      const double t = (-b - std::sqrt(b * b - a * c)) / a;
      const Vec3 p = o + t * d;
      if (t > 0 && std::abs(p.z()) <= 15) best = t, normal = Vec3(p.x(), p.y(), 0) / 10;
    }
    for (const double s : {1.0, -1.0}) {
      const double t = (15 * s - o.z()) / d.z();
      if (t > 0 && t < best && d.z() * s < 0 && (o + t * d).head<2>().norm() <= 10)
        best = t, normal = s * Vec3::UnitZ();
    }
    if (best > 1e29) return {};
    return SurfaceHit{best, normal};
  };
  return surface;
}

Surface drum_with(const std::vector<Ball>& bumps, const Vec3& reach) {
  Surface surface;
  surface.bounds.add(-reach), surface.bounds.add(reach);
  surface.first_hit = nearer_of(cylinder().first_hit, union_of(bumps, reach.maxCoeff()).first_hit);
  return surface;
}

}  // namespace partscribe::testing::registration
