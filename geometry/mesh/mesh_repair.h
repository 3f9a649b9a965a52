/// Makes an oriented 2-manifold of a triangle soup: closed where its holes may be filled, honestly open otherwise.
#pragma once

#include <string>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

struct RepairOptions {
  double weld = 0;               ///< mm; vertices equal on this grid are united; 0: only identical ones
  double min_component = 0.005;  ///< smaller floating pieces (share of the largest one's area) are dropped
  double hole_area = 0.25;       ///< a hole is filled if its filling is at most this share of the surface...
  double small_hole = 0.25;      ///< ...and it is smaller than this share of the mesh's diagonal...
  double flat_hole = 0.03;       ///< ...or plane within this share of its own size
  bool fill_all = false;         ///< fill every hole
  double separation = 0;         ///< mm by which vertices move apart where surfaces only touched
};

/// What was found and done, for the user to read.
struct RepairReport {
  TriangleMesh mesh;
  bool closed = false;                 ///< bounds a solid and faces outward
  std::size_t degenerate = 0;          ///< triangles dropped: collapsed or double
  std::size_t flipped = 0;             ///< triangles turned round
  std::size_t split_vertices = 0;      ///< copies made where surfaces touched
  std::size_t dropped_components = 0;  ///< floating pieces
  double dropped_area = 0;             ///< mm^2 of these
  std::size_t filled_holes = 0, open_holes = 0;
  double filled_area = 0;  ///< mm^2
};

/// Keeps the order of what stays; new vertices and triangles come last.
RepairReport repair(const TriangleMesh& mesh, const RepairOptions& options);

}  // namespace partscribe::geometry
