/// A rigid body as the files that simulators of mechanisms read: URDF and MJCF. SI units, as both want them.
#pragma once

#include <string>

#include "codegen/analysis/mass.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::codegen {

/// One body; its link's frame is the frame of the mesh.
struct SimulatedBody {
  std::string name;     ///< of the link; any text
  std::string mesh;     ///< a file beside the one that is written, in metres; any name
  MassProperties mass;  ///< mm, of density 1
  double density = 0;   ///< kg/m^3
};

/// A robot of one link: inertial, visual and collision. Simulators take the convex hull of a collision mesh, or all of
/// its triangles.
std::string urdf_text(const SimulatedBody& body);

/// A model of MuJoCo with one free body.
std::string mjcf_text(const SimulatedBody& body);

/// The mesh in metres, as binary STL.
std::string mesh_in_metres(const TriangleMesh& mesh);

}  // namespace partscribe::codegen
