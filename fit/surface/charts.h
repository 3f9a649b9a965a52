/// A mesh cut into few pieces that each lie open as seen from one direction.
#pragma once

#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::fit {

/// Cosine of the angle between two triangles from which on they meet in a crease.
inline constexpr double sharp_cosine = 0.8;

/// Where two charts meet, or where one ends at the border of the mesh: along edges of triangles, from one place where
/// three of them (or a border) meet to the next.
struct ChartBorder {
  int left = -1, right = -1;            ///< charts; right is -1 at the border of the mesh
  bool crease = false;                  ///< most of it lies where the surface bends sharply
  std::vector<std::uint32_t> vertices;  ///< as the left chart's triangles run through it; closed: the first again last
};

struct Charts {
  int count = 0;
  std::vector<int> of;  ///< chart of each triangle
  std::vector<ChartBorder> borders;
};

/// Charts grow around mean normals [Cohen-Steiner, Alliez and Desbrun 2004, the metric L2,1], more of them until none
/// turns away from its own by more than some 55 degrees, and none across a crease; then those that can be united are.
/// Charts of less than `small` mm^2 join another in any case. No chart touches itself at a vertex. `mesh` must be
/// manifold and consistently oriented.
Charts charts_of(const TriangleMesh& mesh, double small, Context& context);

/// The same with one chart cut in two across its longest direction.
Charts with_chart_split(const TriangleMesh& mesh, const Charts& charts, int chart);

}  // namespace partscribe::fit
