/// Runs an artifact by its own program and returns the geometry that really came out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::verify {

class BrepDistance;

struct EvaluateOptions {
  double tolerance = 0.1;  ///< mm; surfaces are meshed to a tenth of it
  double seconds = 600;    ///< limit for one program
  double memory_mb = 8192;
  double scanned_size = 0;  ///< mm, diagonal of what was scanned; STEP and IGES shapes more than fifty times as large,
                            ///< wrong in their unit, are meshed by as much more coarsely; 0: unknown
  Path reader = {};         ///< the program partscribe, which reads STEP and IGES apart; empty: this one, or the one
                            ///< beside this one, or on PATH
};

/// A STEP or IGES file that contradicts itself by more than this share of the tolerance cannot be decided.
inline constexpr double share_of_gap = 0.2;

/// Where curves and faces of a STEP or IGES body that should meet are farthest apart.
struct BrepGap {
  double width = 0;  ///< mm
  std::string kind;  ///< "vertex", "edge", "seam"
  Vec3 place = Vec3::Zero();
};

/// The evaluated geometry of one artifact.
struct Evaluation {
  std::string backend;                        ///< "openscad", "alpha1", "iges", "step", "mesh"
  std::string program, version;               ///< what ran: "openscad", "2021.01"
  TriangleMesh mesh;                          ///< mm, outward
  bool solid = false;                         ///< closed and oriented, positive volume
  double error = 0;                           ///< mm, measured bound between `mesh` and the exact geometry
  BrepGap gap;                                ///< how far a STEP or IGES file contradicts itself
  std::shared_ptr<const BrepDistance> exact;  ///< of a STEP or IGES solid whose surfaces the mesh only approaches
  double seconds = 0;
  bool failed = false;                  ///< the program ran and refused or warned: out of tolerance, never passed
  std::vector<std::string> complaints;  ///< what it said, one line each
};

/// Whether a file of this suffix is an artifact and no scan: what CAD programs read, meshes left out. Case is of no
/// matter.
bool is_cad_file(const Path& path);

/// By suffix: .scad .scl .igs .iges .step .stp and mesh files (.stl .off .obj .3mf .ply). Errors: missing_program,
/// bad_input, stopped. A program that ran and complained is no error but `failed`.
Result<Evaluation> evaluate_artifact(const Path& path, const EvaluateOptions& options, Context& context);

/// How to draw the circles of an artifact with `sides` sides, by its suffix: "raise $fn to 24". Empty where a file has
/// exact circles.
std::string how_to_draw_finer(const Path& path, int sides);

}  // namespace partscribe::verify
