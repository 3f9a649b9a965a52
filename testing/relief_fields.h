/// Reliefs whose truth is a formula: a face mask, a hand, rolling hills.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"
#include "scan/simulate/reliefs.h"

namespace partscribe::testing {

using scan::face_mask_height;
using scan::hand_height;

/// Rolling hills over 100 x 100 mm about the origin, some 15 mm high. Smooth.
inline double hills_height(double x, double y) {
  const auto hill = [&](double cx, double cy, double sx, double sy, double height, double turn = 0) {
    const double u = (x - cx) * std::cos(turn) + (y - cy) * std::sin(turn);
    const double v = (y - cy) * std::cos(turn) - (x - cx) * std::sin(turn);
    return height * std::exp(-0.5 * (u * u / (sx * sx) + v * v / (sy * sy)));
  };
  double z = 3 * std::sin(0.11 * x + 0.4) * std::cos(0.09 * y - 0.2) + 1.2 * std::sin(0.23 * x - 0.17 * y);
  z += hill(-22, 18, 13, 9, 9, 0.5) + hill(25, 25, 8, 8, 7) + hill(15, -20, 16, 7, 10, -0.6);
  z += hill(-25, -25, 6, 6, -6) + hill(2, 3, 5, 5, -4) + hill(-38, -5, 5, 12, 5, 0.2);
  return z + hill(38, -5, 4, 4, 4) + hill(-5, 40, 10, 4, 4) + hill(35, -38, 6, 6, -5);
}

/// `height(x, y)` over a net of columns x rows cells; cells with a corner outside are left out, or halved where it is
/// one corner. Triangles face +z.
template <class Height>
geometry::TriangleMesh relief_mesh(const Height& height, const geometry::Vec2& low, const geometry::Vec2& high,
                                   int columns, int rows) {
  geometry::TriangleMesh mesh;
  constexpr std::uint32_t none = ~0u;
  std::vector<std::uint32_t> index;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double x = low.x() + (high.x() - low.x()) * i / columns, y = low.y() + (high.y() - low.y()) * j / rows;
      const double z = height(x, y);
      index.push_back(std::isfinite(z) ? static_cast<std::uint32_t>(mesh.vertices.size()) : none);
      if (std::isfinite(z)) mesh.vertices.emplace_back(x, y, z);
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const std::size_t at = std::size_t(j) * std::size_t(columns + 1) + std::size_t(i);
      const std::array<std::uint32_t, 4> round = {index[at], index[at + 1], index[at + std::size_t(columns) + 2],
                                                  index[at + std::size_t(columns) + 1]};
      const auto missing = std::count(round.begin(), round.end(), none);
      if (missing > 1) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        // Whole cells are cut one way and the other in turn, so that no direction is preferred.
        const std::array<std::uint32_t, 3> t = {round[k], round[(k + 1) % 4], round[(k + 2) % 4]};
        const bool wanted = missing == 1 ? round[(k + 3) % 4] == none : int(k % 2) == (i + j) % 2;
        if (wanted) mesh.triangles.push_back(t);
      }
    }
  return geometry::welded(mesh, 0);
}

}  // namespace partscribe::testing
