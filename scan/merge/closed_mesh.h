/// Integration from a model down: an icosahedron around the data is drawn onto it, and divided where it is too coarse.
///
/// Koivunen, Vezien and Bajcsy 1993, section 2.1.3: "model driven, where more elaborate model surfaces are employed and
/// the surface parameters are adjusted to fit to the data", "where initial triangulated ellipsoid or icosahedron is
/// refined to approximate the bounding surface". merge_views() integrates from the data up, whatever their topology.
#pragma once

#include <cstddef>
#include <vector>

#include "core/context.h"
#include "core/result.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::scan {

struct ClosedMeshOptions {
  double tolerance = 0.2;              ///< mm; a triangle is divided if one of its points is farther off. Above four
                                       ///< times the noise, or triangles as small as itself follow single points
  std::size_t most_triangles = 50000;  ///< where it ends at the latest
  double least_stiffness = 1e-3;  ///< of bending against data at the end; less follows creases and noise more closely
};

/// A closed surface and how far the points are from it.
struct ClosedMesh {
  TriangleMesh mesh;            ///< one piece, closed, facing outward
  double worst = 0, rms = 0;    ///< mm, of all points
  double within = 0;            ///< share of the points within the tolerance
  std::size_t crossings = 0;    ///< pairs of triangles that pass through each other; 0 for a sound surface
  std::size_t start_count = 0;  ///< triangles that it began with
};

/// Begins with an icosahedron, divided into 320 triangles and stretched to the ellipsoid about the points. Every point
/// pulls at the nearest place of the surface, which bends stiffly at first and ever less so; where points stay farther
/// off than the tolerance their triangles are divided in four, and neighbours so that no gap opens. It ends when all
/// points are within the tolerance, or nothing is left to be divided: triangles smaller than the tolerance are not.
///
/// For points all around one body without handles and without outliers, which it would reach for: filter, or merge, the
/// views before. Where nobody looked the surface spans straight on. Of a ring it closes the hole, which `within` or
/// `crossings` tell. Fails below 20 points, and where these lie in a plane.
Result<ClosedMesh> closed_mesh_around(const std::vector<Vec3>& points, const ClosedMeshOptions& options,
                                      Context& context);

}  // namespace partscribe::scan
