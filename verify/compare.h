/// Compares one evaluated mesh with the scan, in both directions and face by face.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "verify/source.h"
#include "verify/verify.h"

namespace partscribe {

/// The faces that get rows of their own, and how to tell to which of them a place on the mesh belongs.
struct FaceNames {
  std::vector<std::string> names;
  std::function<int(const Vec3& point, std::uint32_t triangle)> face_of;  ///< index into names, or -1
};

/// Groups of triangles that meet at less than 20 degrees: "face 1", "face 2", ... by decreasing area, at most 40, the
/// small rest together.
FaceNames smooth_faces(const TriangleMesh& mesh);

/// Fills data_to_model, model_to_data, objects, point_deviation, reasons and the verdict of `verdict`, whose mesh is
/// the evaluated one. Verdicts that are red already stay red.
void compare(const ScanSource& source, const FaceNames& faces, const VerifyOptions& options, ArtifactVerdict& verdict,
             Context& context);

/// Largest distance between two meshes, measured from corners and centres of either to the other; from an open one to a
/// closed one only.
double distance_between(const TriangleMesh& a, const TriangleMesh& b, int threads);

}  // namespace partscribe
