/// The faces that a CAD file states, and a mesh whose triangles know their face.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/files.h"
#include "core/result.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/segment/faces.h"

class TopoDS_Shape;

namespace bench {

using namespace partscribe::core;
using namespace partscribe::geometry;

/// One face of the file. Splines that are planes, cylinders, ... to a micrometre are that.
struct TrueFace {
  FaceKind kind = FaceKind::free_form;
  Primitive surface;    ///< as in Face; nothing of it holds for free form
  bool hollow = false;  ///< of round kinds
  double area = 0;      ///< mm^2, of its triangles
  Vec3 middle = Vec3::Zero();
  std::vector<std::uint32_t> triangles;
};

struct Truth {
  std::vector<TrueFace> faces;
  TriangleMesh mesh;                   ///< corners as an STL file holds them (float), shared
  std::vector<std::uint32_t> face_of;  ///< of each triangle
  double area = 0, error = 0;          ///< mm^2; mm between the mesh and the surfaces
};

/// `deflection`: mm, what chords may leave between them and the surfaces; 0: 1/2000 of the diagonal.
Result<Truth> read_truth(const Path& step, double deflection);

/// The same of a shape.
Truth truth_of(const TopoDS_Shape& shape, double deflection);

}  // namespace bench
