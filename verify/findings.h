/// Names what is wrong: connected places where artifact and scan disagree, or where nobody looked.
#pragma once

#include <cstdint>
#include <vector>

#include "verify/model_to_data.h"

namespace partscribe {

/// Everything that the comparison of one mesh with the scan has found.
struct Compared {
  const ScanSource& source;
  const TriangleMesh& mesh;
  const std::vector<Vec3>& normals;               ///< unit, of its facets
  const MeshDistance& surface;                    ///< of the mesh
  const PointField& points;
  const SurfaceField& field;
  const std::vector<FeatureVerdict>& rows;
  const std::vector<std::int32_t>& place_row;     ///< of each place, index into rows or -1
  const std::vector<std::int32_t>& sample_row;    ///< of each surface sample
  std::vector<std::uint8_t> explained;            ///< per place: 1 if a finding about a whole feature speaks of it; may be empty
};

/// Faults, the worst first (deviation times area); then what was not scanned, the largest first.
std::vector<Finding> find_places(const Compared& compared, const VerifyOptions& options, int threads);

/// The unit normal of the scanned surface at a point, of unknown sign: the scan's own, or of the plane through the
/// nearest points; zero if they form no plane.
Vec3 scanned_normal(const ScanSource& source, std::uint32_t point, std::vector<Neighbour>& near);

}  // namespace partscribe
