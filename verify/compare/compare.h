/// Compares one evaluated mesh with the scan, in both directions and face by face.
#pragma once

#include "verify/features/rows.h"
#include "verify/verify.h"

namespace partscribe::verify {

/// Fills data_to_model, model_to_data, objects, findings, point_deviation, reasons and the verdict of `verdict`, whose
/// mesh is the evaluated one. `names`: of the rows; null: the features that are found on the mesh. A verdict that has
/// already failed stays failed.
void compare(const ScanSource& source, const FaceNames* names, const VerifyOptions& options, ArtifactVerdict& verdict,
             Context& context);

/// Largest distance between two meshes, measured from corners and centres of either to the other; from an open one to a
/// closed one only.
double distance_between(const TriangleMesh& a, const TriangleMesh& b, int threads);

}  // namespace partscribe::verify
