/// The features of an artifact as rows of the verdict: how well each agrees with its own points.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "verify/compare/model_to_data.h"
#include "verify/features/features.h"

namespace partscribe::verify {

/// The faces that get rows of their own, and how to tell to which of them a place on the mesh belongs.
struct FaceNames {
  std::vector<std::string> names;
  std::function<int(const Vec3& point, std::uint32_t triangle)> face_of;  ///< index into names, or -1
};

/// Names of the features themselves, for artifacts without a model. `features` must outlive it.
FaceNames names_of(const MeshFeatures& features);

/// To which row of the verdict everything belongs: indices into its objects, or -1.
struct RowOf {
  std::vector<std::int32_t> point;          ///< of each point of the source
  std::vector<std::int32_t> place, sample;  ///< of each place and surface sample
  std::vector<std::int32_t> feature;        ///< of each row, the mesh feature that makes up most of it
};

/// Fills objects, point_object and triangle_object of the verdict: a row per face that has data or area.
RowOf fill_rows(const ScanSource& source, const FaceNames& faces, const MeshFeatures& features,
                const PointField& points, const SurfaceField& field, const VerifyOptions& options,
                ArtifactVerdict& verdict, int threads);

}  // namespace partscribe::verify
