#include "tests/scan/register_cases.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "scan/register_pair.h"

namespace partscribe::registration_cases {

Surface convex(const std::vector<Side>& sides, double reach) {
  Surface surface;
  surface.bounds.add(Vec3::Constant(-reach)), surface.bounds.add(Vec3::Constant(reach));
  surface.first_hit = [sides](const Vec3& origin, const Vec3& direction) -> std::optional<SurfaceHit> {
    double in = -1e30, out = 1e30;
    Vec3 normal = Vec3::Zero();
    for (const Side& s : sides) {
      const double rate = s.normal.dot(direction), gap = s.offset - s.normal.dot(origin);
      if (rate < 0 && gap / rate > in) in = gap / rate, normal = s.normal;
      else if (rate > 0) out = std::min(out, gap / rate);
      else if (rate == 0 && gap < 0) return {};
    }
    if (in >= out || in < 0) return {};
    return SurfaceHit{in, normal};
  };
  return surface;
}

namespace {

std::vector<Side> block_sides() {
  std::vector<Side> sides;
  for (int k = 0; k < 3; ++k)
    for (const double s : {1.0, -1.0}) sides.push_back({s * Vec3::Unit(k), 14.0 + 3 * k});
  return sides;
}

}  // namespace

Surface plain_block() {
  std::vector<Side> sides = block_sides();
  sides.push_back({Vec3(1, 0.8, 0).normalized(), 14}), sides.push_back({Vec3(0, -1, 0.7).normalized(), 18}), sides.push_back({Vec3(-1, 1, 1).normalized(), 18});
  return convex(sides, 22);
}

Surface cut_block() {
  std::vector<Side> sides = block_sides();
  const auto cut = [&](const Vec3& n, double d) { sides.push_back({n.normalized(), d}); };
  cut({1, 1, 1}, 20), cut({1, -1, 0.6}, 19), cut({-1, 0.7, 1}, 22), cut({-0.6, -1, 1}, 18);
  cut({1, 0.5, -1}, 21), cut({-1, -1, -0.8}, 20.5), cut({0.4, -1, -1}, 23), cut({-1, 1, -0.5}, 19.5);
  return convex(sides, 22);
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
  return union_of({{{0, 0, 0}, 12}, {{11, 2, 3}, 8}, {{-8, 7, 4}, 9}, {{1, -11, 5}, 7}, {{3, 4, -12}, 6.5}, {{-6, -6, -9}, 6}, {{2, 8, 11}, 5}}, 20);
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
      if (t > 0 && t < best && d.z() * s < 0 && (o + t * d).head<2>().norm() <= 10) best = t, normal = s * Vec3::UnitZ();
    }
    if (best > 1e29) return {};
    return SurfaceHit{best, normal};
  };
  return surface;
}

Surface drum_with(const std::vector<Ball>& bumps, const Vec3& reach) {
  Surface surface;
  surface.bounds.add(-reach), surface.bounds.add(reach);
  surface.first_hit = [drum = cylinder().first_hit, bump = union_of(bumps, reach.maxCoeff()).first_hit](const Vec3& o, const Vec3& d) {
    const auto on_drum = drum(o, d), on_bump = bump(o, d);
    return on_bump && (!on_drum || on_bump->distance < on_drum->distance) ? on_bump : on_drum;
  };
  return surface;
}

Case scan_of(const Surface& surface, SimulateOptions options, double angle, double shift) {
  options.pose_noise_angle = angle, options.pose_noise_shift = shift;
  Context context;
  context.threads = 2;
  const SimulatedScan scan = simulate(surface, options, context);
  Case result{views_of(scan.merged), {}};
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    result.truth.push_back(scan.views[v].image.world_from_view);
    result.views[v].guess = scan.views[v].initial_guess;
  }
  return result;
}

SimulateOptions small() {
  SimulateOptions options;
  options.views = "cube", options.resolution = 72, options.sigma = 0.02, options.bit_error = 0.002;
  return options;
}

Registration run(const std::vector<RegisterView>& views, const RegisterOptions& options, int threads) {
  Context context;
  context.threads = threads;
  const auto result = register_views(views, options, context);
  REQUIRE(result.ok());
  return *result;
}

Off off_truth(const Registration& found, const std::vector<Pose>& truth) {
  std::size_t reference = 0;
  while (found.views[reference].status != ViewStatus::reference) ++reference;
  const Pose back = truth[reference] * found.views[reference].world_from_view.inverse();
  Off worst;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (found.views[v].status == ViewStatus::refused) continue;
    const Pose d = back * found.views[v].world_from_view * truth[v].inverse();
    worst.angle = std::max(worst.angle, rotation_vector(d.rotation).norm());
    worst.shift = std::max(worst.shift, (d * Vec3(0, 0, 0)).norm());
  }
  return worst;
}

Registration run_from_nothing(Case scan) {
  RegisterOptions unknown;
  unknown.arrangement = Arrangement::unknown;
  for (auto& view : scan.views) view.guess.reset();
  return run(scan.views, unknown);
}

int count(const Registration& registration, ViewStatus status) {
  return static_cast<int>(std::count_if(registration.views.begin(), registration.views.end(), [&](const auto& v) { return v.status == status; }));
}

}  // namespace partscribe::registration_cases
