/// The inspection table: what each feature of the artifact should measure, and what the scan of that feature says.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verify/features/features.h"
#include "verify/report/findings.h"

namespace partscribe::verify {

/// One feature measured by its own points.
struct Inspection {
  std::vector<FeatureDimension> dimensions;
  std::optional<Finding> finding;  ///< if the whole feature is displaced, has the wrong size, is tilted or too coarse
  Primitive measured;              ///< if there are dimensions
  double close = 0;                ///< mm, points nearer than this lie on it
  double reach = 0;                ///< mm, how far its points extend from the feature's middle
  double shift = 0;                ///< mm, by which it is off the nominal surface
};

/// `points`: of the source, whose nearest place on the artifact is on the feature. Nothing is measured if they are too
/// few or leave it open.
Inspection inspect(const Compared& compared, const MeshFeature& feature, const FeatureVerdict& row,
                   const std::vector<std::uint32_t>& points, const VerifyOptions& options);

/// The same for a round feature whose points are nearer to its neighbours than to itself, because its radius is quite
/// another one. `points`: connected ones that neither the feature nor its neighbours explain.
Inspection inspect_anew(const Compared& compared, const MeshFeature& feature, const FeatureVerdict& row,
                        const std::vector<std::uint32_t>& points, const VerifyOptions& options);

/// How a person calls it: "hole 3 (diameter 6.6)", "face +z at 10".
std::string with_size(const std::string& name, const MeshFeature& feature, double tolerance);

}  // namespace partscribe::verify
