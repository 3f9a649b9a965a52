/// Names what is wrong: connected places where artifact and scan disagree, or where nobody looked.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "verify/compare/model_to_data.h"
#include "verify/features/features.h"

namespace partscribe::verify {

/// Everything that the comparison of one mesh with the scan has found.
struct Compared {
  const ScanSource& source;
  const TriangleMesh& mesh;
  const std::vector<Vec3>& normals;  ///< unit, of its triangles
  const MeshDistance& surface;       ///< of the mesh
  const PointField& points;
  const SurfaceField& field;
  const MeshFeatures& features;
  const std::vector<FeatureVerdict>& rows;
  const std::vector<std::int32_t>& feature_of_row;  ///< index into features or -1
  const std::vector<std::int32_t>& place_row;       ///< of each place, index into rows or -1
  const std::vector<std::int32_t>& sample_row;      ///< of each surface sample
  std::string file;                                 ///< name of the artifact
  std::vector<std::uint8_t> explained_point;        ///< of the source; 1: a finding about a whole feature speaks of it
  std::vector<std::uint8_t> explained_row;
  std::vector<std::uint8_t> explained_sample;
};

/// `whole`, the findings about displaced features, and all others. First what is said of whole features: displaced, of
/// the wrong size, missing, invented; then patches; in either the worst first, by size of the fault and area. Last what
/// was not scanned, the largest first.
std::vector<Finding> all_findings(const Compared& compared, const std::vector<Finding>& whole,
                                  const VerifyOptions& options, int threads);

/// The unit normal of the scanned surface at a point, of unknown sign: the scan's own, or of the plane through the
/// nearest points; zero if they form no plane.
Vec3 scanned_normal(const ScanSource& source, std::uint32_t point, std::vector<Neighbour>& near);

}  // namespace partscribe::verify
