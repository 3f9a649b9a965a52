// A drawn body's facets lie below its round faces: its corners tell the true sizes, to the last place of the file.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "fit/build.h"
#include "scan/read/read.h"

using namespace partscribe::scan;
using namespace partscribe::fit;

namespace {

/// A plate 50 x 40 x 12 with one corner rounded by 8, in facets of 5 degrees, in single precision like an STL file.
/// `noise` moves every corner.
Scan rounded_plate(double noise) {
  std::vector<Vec2> outline = {{0, 0}, {50, 0}, {50, 40}};
  for (int k = 0; k <= 18; ++k) {
    const double angle = pi / 2 + pi / 2 * k / 18;
    outline.push_back({8 + 8 * std::cos(angle), 32 + 8 * std::sin(angle)});
  }
  Scan scan;
  Random random(4);
  TriangleMesh& mesh = scan.mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double z : {0.0, 12.0})
    for (const Vec2& p : outline) {
      const Vec3 moved = Vec3(p.x(), p.y(), z) + noise * Vec3(random.normal(), random.normal(), random.normal());
      mesh.vertices.push_back(moved.cast<float>().cast<double>());
    }
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t next = (k + 1) % n;
    mesh.triangles.push_back({k, next, n + next});
    mesh.triangles.push_back({k, n + next, n + k});
    if (k > 0 && next > 0) mesh.triangles.push_back({0, next, k}), mesh.triangles.push_back({n, n + k, n + next});
  }
  scan.files = {"plate.stl"};
  scan.cloud.points = mesh.vertices;
  scan.cloud.normals = vertex_normals(mesh);
  const SurfaceSamples samples = sample_coarse_mesh(mesh);
  scan.cloud.points.insert(scan.cloud.points.end(), samples.points.begin(), samples.points.end());
  scan.cloud.normals.insert(scan.cloud.normals.end(), samples.normals.begin(), samples.normals.end());
  return scan;
}

std::vector<Parameter> numbers_of(Scan scan) {
  Context context;
  const auto model = build_model(scan, {.tolerance = 0.1, .nominal = false}, context);
  REQUIRE(model.ok());
  REQUIRE_FALSE((*model)->fallback);
  return (*model)->parameters;
}

const Parameter& nearest(const std::vector<Parameter>& all, double truth) {
  return *std::min_element(all.begin(), all.end(), [&](const Parameter& a, const Parameter& b) {
    return std::abs(a.fitted - truth) < std::abs(b.fitted - truth);
  });
}

}  // namespace

TEST_CASE("mesh: sizes of a drawn plate are exact, and nothing of a closed mesh is unseen") {
  const auto numbers = numbers_of(rounded_plate(0));
  for (const double truth : {50.0, 40.0, 12.0, 8.0}) {
    const Parameter& p = nearest(numbers, truth);
    INFO(p.name << " " << p.fitted << " +- " << p.sigma << ", " << p.note);
    CHECK(std::abs(p.fitted - truth) < 2e-5);
    CHECK(std::abs(p.fitted - truth) < 3 * p.sigma);
    CHECK(p.sigma < 3e-4);  // a hundredth of what the facets do
    CHECK(p.sigma > 1e-6);  // half the last place of 50 in single precision
    CHECK(p.note.find("not scanned") == std::string::npos);
  }
}

TEST_CASE("mesh: corners that are off themselves do not decide") {
  const auto numbers = numbers_of(rounded_plate(0.01));
  for (const double truth : {50.0, 40.0, 12.0}) {
    const Parameter& p = nearest(numbers, truth);
    INFO(p.name << " " << p.fitted << " +- " << p.sigma);
    CHECK(std::abs(p.fitted - truth) < 0.02);
    CHECK(p.sigma > 1e-4);
  }
}
