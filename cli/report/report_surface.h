/// The evaluated surface as a report draws it: cut so fine that every place bears its deviation, support and feature.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/points/point_cloud.h"
#include "verify/verify.h"

namespace partscribe::cli {

/// A mesh whose vertices are doubled along creases and between features, so that each has one normal and one feature.
struct DeviationSurface {
  std::vector<Vec3> points;           ///< mm, in the scan's frame
  std::vector<Vec3> normals;          ///< unit, outward
  std::vector<float> deviation;       ///< mm, positive where the scan lies outside; 0 where nothing was scanned
  std::vector<std::uint8_t> support;  ///< 0 supported, 1 not scanned, 2 contradicted
  std::vector<std::int32_t> feature;  ///< row of the artifact's features, or -1
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< creases and borders: the lines of a technical drawing
  double error = 0;                                 ///< mm, how far the drawn surface may lie from the evaluated one

  bool empty() const { return triangles.empty(); }
};

struct SurfaceOptions {
  std::size_t most_vertices = 36000;  ///< more show finer detail and make the page larger; at most 65,535
  double max_error = 0.1;             ///< mm that thinning a large mesh may move its surface by
};

/// `deviations` holds one value per point of the cloud, NaN for points that were set aside (see pictures.h). Empty if
/// the artifact has no geometry.
DeviationSurface deviation_surface(const ArtifactVerdict& artifact, const PointCloud& cloud,
                                   const std::vector<float>& deviations, const SurfaceOptions& options,
                                   Context& context);

/// Per point of the cloud the feature it belongs to; -1 for points that were set aside or belong to none.
std::vector<std::int32_t> features_of(const PointCloud& cloud, const ArtifactVerdict& artifact);

}  // namespace partscribe::cli
