/// Turns an OpenCASCADE shape into triangles and measures how far they are from its surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

class TopoDS_Shape;

namespace partscribe::verify {

struct ShapeMesh {
  TriangleMesh mesh;  ///< facets share their vertices along shared edges, outward where the shape says so
  double error = 0;   ///< mm, largest distance found between the surfaces and the mesh
  std::vector<std::uint32_t> face_of;  ///< of each triangle, counted as TopExp_Explorer goes through the faces
};

/// Meshes at tolerance / 10, measures at centroids and edge midpoints, and refines once if the error is above
/// tolerance / 5: the deflection that the mesher is asked for is no bound.
ShapeMesh mesh_shape(const TopoDS_Shape& shape, double tolerance);

}  // namespace partscribe::verify
