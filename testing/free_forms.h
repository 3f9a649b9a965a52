/// Meshes of free form for tests: a closed pebble, a sheet with a window, a ring with a wave.
#pragma once

#include <cmath>

#include "core/number.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::testing {

/// A mesh as a scan: its corners are the points.
inline geometry::Scan scan_of(const geometry::TriangleMesh& mesh) {
  geometry::Scan scan;
  scan.mesh = mesh;
  scan.cloud.points = mesh.vertices;
  return scan;
}

/// Closed over a net of (columns x rows) cells of two angles, `at` saying where each corner lies; its triangles face
/// the side that u x v does.
template <class Place>
geometry::TriangleMesh woven(int columns, int rows, const Place& at) {
  geometry::TriangleMesh mesh;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) mesh.vertices.push_back(at(2 * core::pi * i / columns, 2 * core::pi * j / rows));
  const auto corner = [&](int i, int j) { return static_cast<std::uint32_t>((j % rows) * columns + i % columns); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      mesh.triangles.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
      mesh.triangles.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  return mesh;
}

/// Closed about the origin: a corner lies `radius(n)` away in the direction n, then stretched along the axes.
template <class Radius>
geometry::TriangleMesh star_shaped(int rings, const geometry::Vec3& stretch, const Radius& radius) {
  geometry::TriangleMesh mesh;
  const int columns = 2 * rings;
  const auto place = [&](double azimuth, double polar) {
    const geometry::Vec3 n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
    const double r = radius(n);
    return geometry::Vec3(stretch.x() * r * n.x(), stretch.y() * r * n.y(), stretch.z() * r * n.z());
  };
  mesh.vertices = {place(0, 0), place(0, core::pi)};
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < columns; ++i) mesh.vertices.push_back(place(2 * core::pi * i / columns, core::pi * j / rings));
  const auto corner = [&](int i, int j) {
    if (j == 0) return 0u;
    if (j == rings) return 1u;
    return static_cast<std::uint32_t>(2 + (j - 1) * columns + i % columns);
  };
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < columns; ++i) {
      if (j > 0) mesh.triangles.push_back({corner(i, j), corner(i, j + 1), corner(i + 1, j)});
      if (j + 1 < rings) mesh.triangles.push_back({corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)});
    }
  return mesh;
}

/// A lump of some 45 x 40 x 35 mm that no procedure describes.
inline geometry::TriangleMesh pebble(int rings) {
  return star_shaped(rings, {1.1, 1, 0.85}, [](const geometry::Vec3& n) {
    return 20 + 1.8 * std::sin(2.2 * n.x() + 1) + 2.2 * n.x() * n.y() - 1.5 * std::cos(2.6 * n.z() + n.x());
  });
}

/// The same with hills and hollows all over, so that it lies on itself in one way only.
inline geometry::TriangleMesh sculpture(int rings) {
  return star_shaped(rings, {1, 1, 1}, [](const geometry::Vec3& n) {
    return 17 + 2.5 * std::sin(4 * n.x() + 1) * std::cos(3.1 * n.y() - 0.4) + 2 * std::cos(5 * n.z() + 2 * n.x()) +
           1.2 * std::sin(6 * n.y() + 3 * n.z());
  });
}

/// A ring of radius 30 whose tube is 8 thick, more or less.
inline geometry::TriangleMesh wavy_ring(int columns) {
  return woven(columns, columns / 3, [](double u, double v) {
    const double tube = 8 + 0.9 * std::sin(3 * u) + 0.5 * std::cos(2 * v + u), out = 30 + tube * std::cos(v);
    return geometry::Vec3(out * std::cos(u), out * std::sin(u), tube * std::sin(v) + 1.5 * std::sin(2 * u));
  });
}

/// A sheet over 60 x 40 with a window of 14 x 12, in cells of 1 mm.
inline geometry::TriangleMesh hood() {
  geometry::TriangleMesh mesh;
  const int columns = 60, rows = 40;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) mesh.vertices.emplace_back(i, j, 5 * std::sin(i / 11.0) * std::cos(j / 14.0));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      if (i >= 20 && i < 34 && j >= 12 && j < 24) continue;
      const auto a = std::uint32_t(j * (columns + 1) + i), b = a + 1, c = a + std::uint32_t(columns) + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return welded(mesh, 0);
}

}  // namespace partscribe::testing
