#include "fit/strays.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe;

namespace {

struct Wall {
  std::vector<Vec3> points, rays;
  std::size_t surface = 0;  ///< the first so many are no strays

  /// A wall in the plane z = 0, seen from both sides, and strays around it.
  Wall(double thickness, double sigma, std::size_t count, std::size_t strays, std::uint64_t seed) : surface(count) {
    Random random(seed);
    for (std::size_t i = 0; i < count + strays; ++i) {
      const double side = random.uniform() < 0.5 ? -1 : 1;
      const double height = i < count ? side * thickness / 2 + sigma * random.normal() : random.uniform(-10, 10);
      points.emplace_back(random.uniform(-20, 20), random.uniform(-20, 20), height);
      rays.push_back(Vec3(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), -side).normalized());
    }
  }
};

std::size_t strays_in(const SurfacePoints& found, std::size_t begin, std::size_t end) {
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) count += found.stray[i];
  return count;
}

}  // namespace

TEST_CASE("strays: a wall thinner than its points are apart, seen from both sides, is two surfaces") {
  Context context;
  context.threads = 2;
  const Wall wall(0.6, 0.03, 3200, 160, 4);  // 1 mm apart
  const SurfacePoints found = surface_points_of(wall.points, wall.rays, 0.03, context);
  CHECK(strays_in(found, 0, wall.surface) < 64);
  CHECK(strays_in(found, wall.surface, wall.points.size()) > 120);
}
