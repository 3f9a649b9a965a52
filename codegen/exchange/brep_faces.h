/// The boundary of a body whose faces are planes, cylinders, cones, spheres and tori, from a triangulation that says
/// where they meet.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"
#include "geometry/surfaces/primitive_fit.h"

class TopoDS_Shape;

namespace partscribe::codegen {

/// One face of the body.
struct AnalyticFace {
  std::optional<Primitive> surface;  ///< none: its triangles are flat faces
  bool hollow = false;               ///< of round kinds: the material is outside of the surface
  bool flat = false;                 ///< a triangle of a free form: its plane is not meant
};

struct FacedBody {
  TriangleMesh mesh;                   ///< closed, facing outward; corners between faces lie on their surfaces
  std::vector<std::uint32_t> face_of;  ///< of each triangle
  std::vector<AnalyticFace> faces;
};

/// A solid, or a compound of several: faces trimmed by the curves in which neighbours meet, which pass through the
/// corners of the triangulation. A face that cannot be trimmed so is made of its triangles, and `faces` says so
/// afterwards. `tolerance`: mm that a curve may leave the surfaces. A null shape if nothing closed comes out.
TopoDS_Shape brep_of_faces(FacedBody& body, double tolerance);

}  // namespace partscribe::codegen
