/// Thickening: the back of a sheet follows its front and never folds where that can be had.
#include "codegen/thicken.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "geometry/mesh/self_intersection.h"
#include "geometry/mesh/triangle_mesh.h"

using namespace partscribe::codegen;

namespace {

struct Sheet {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// An egg box in z, 20 x 20 cells of 0.5 mm, turned by `rotation`.
Sheet egg_box(double height, double wave, const Mat3& rotation = Mat3::Identity()) {
  Sheet sheet;
  const std::uint32_t n = 21;
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const double x = 0.5 * i, y = 0.5 * j;
      const Vec3 p = rotation * Vec3(x, y, height * std::sin(wave * x) * std::cos(wave * y));
      sheet.vertices.push_back({p.x(), p.y(), p.z()});
    }
  for (std::uint32_t j = 0; j + 1 < n; ++j)
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      sheet.triangles.push_back({a, b, d});
      sheet.triangles.push_back({a, d, c});
    }
  return sheet;
}

TriangleMesh thickened(const Sheet& sheet, double thickness) {
  TriangleMesh mesh;
  for (const auto& v : sheet.vertices) mesh.vertices.emplace_back(v[0], v[1], v[2]);
  const auto normals = sheet_normals(sheet.vertices, sheet.triangles, thickness);
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t v = 0; v < n; ++v) mesh.vertices.push_back(mesh.vertices[v] - thickness * normals[v]);
  for (const auto& t : sheet.triangles) {
    mesh.triangles.push_back(t);
    mesh.triangles.push_back({t[2] + n, t[1] + n, t[0] + n});
  }
  for (const auto& [from, to] : sheet_rim(sheet.triangles)) {
    mesh.triangles.push_back({to, from, from + n});
    mesh.triangles.push_back({to, from + n, to + n});
  }
  return mesh;
}

}  // namespace

TEST_CASE("thicken: a rough sheet's back is its front once more, behind it, and crosses nothing") {
  const Mat3 rotation = rotation_of({0.5, -1, 0.3});
  const Sheet sheet = egg_box(0.6, 2.5, rotation);
  const auto normals = sheet_normals(sheet.vertices, sheet.triangles, 2);
  for (const Vec3& n : normals) {
    CHECK((n - normals[0]).norm() == 0);
    CHECK(n.norm() == Approx(1));
    CHECK(n.dot(rotation * Vec3::UnitZ()) > 0.9);
  }
  const TriangleMesh solid = thickened(sheet, 2);
  CHECK(topology(solid).closed());
  // Without the walls, whose neighbours lie in one plane but for the last bit.
  TriangleMesh both = solid;
  both.triangles.resize(2 * sheet.triangles.size());
  CHECK(self_intersections(both).empty());
  CHECK(volume(solid) == Approx(200 * normals[0].dot(rotation * Vec3::UnitZ())).epsilon(0.05));
}

TEST_CASE("thicken: a gently bent sheet keeps its thickness square to the surface") {
  const Sheet sheet = egg_box(0.5, 0.3);
  const TriangleMesh solid = thickened(sheet, 1);
  double front = 0;
  for (const auto& t : sheet.triangles) {
    const auto corner = [&](int k) {
      return Vec3(sheet.vertices[t[k]][0], sheet.vertices[t[k]][1], sheet.vertices[t[k]][2]);
    };
    front += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
  }
  CHECK(topology(solid).closed());
  CHECK(volume(solid) == Approx(front).epsilon(0.01));
}
