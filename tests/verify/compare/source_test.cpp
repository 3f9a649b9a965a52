/// Claims about what a scan is compared by: its noise.
#include "verify/compare/source.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "testing/meshes.h"

namespace partscribe::testing {
namespace {

Scan mesh_scan(TriangleMesh mesh) {
  Scan scan;
  scan.cloud.points = mesh.vertices;
  scan.mesh = std::move(mesh);
  return scan;
}

/// A ring of round section: its triangles are long and everywhere bent.
TriangleMesh ring() {
  std::vector<Vec2> profile = {{0, -3}};
  for (int i = 0; i <= 24; ++i) {
    const double a = -pi / 2 + pi * i / 24;
    profile.push_back({20 + 3 * std::cos(a), 3 * std::sin(a)});
  }
  profile.push_back({0, 3});
  return turned(profile, 48);
}

TEST_CASE("source: the facets of a drawn part are no noise; rough corners are") {
  Context context;
  const ScanSource drawn = prepare_source(mesh_scan(ring()), context);
  CHECK(drawn.noise == 0);
  TriangleMesh rough = ring();
  Random random(3);
  for (auto& v : rough.vertices) v += 0.05 * Vec3(random.normal(), random.normal(), random.normal());
  const ScanSource scanned = prepare_source(mesh_scan(rough), context);
  CHECK(scanned.noise > 0.01);
}

}  // namespace
}  // namespace partscribe::testing
