/// Which part of the evaluated surface the scan supports, never saw, or contradicts.
#pragma once

#include <cstdint>
#include <vector>

#include "verify/compare/data_to_model.h"
#include "verify/compare/passages.h"
#include "verify/compare/samples.h"

namespace partscribe::verify {

enum class Support : std::uint8_t { supported, not_scanned, contradicted };

/// Samples of the evaluated surface, each standing for the same area.
struct SurfaceField {
  std::vector<SurfaceSample> samples;
  std::vector<Support> support;
  ModelToData summary;
  Vec3 worst = Vec3::Zero();         ///< middle of the contradicted samples nearest to one another; a place to look
  double allowed_contradiction = 0;  ///< mm^2
  Passages passages;                 ///< scanned points that it would have hidden
  std::vector<std::uint32_t> in_plain_view;  ///< contradicted samples that the scan must have shown, in ascending order
};

SurfaceField model_to_data(const ScanSource& source, const PointField& points, const TriangleMesh& mesh,
                           const MeshDistance& surface, const std::vector<Vec3>& normals, const VerifyOptions& options,
                           Context& context);

/// mm^2 of bodies that lie inside another body of the mesh: duplicates, sheets in the material. They bound nothing.
double surface_inside_bodies(const TriangleMesh& mesh, const MeshDistance& surface, const std::vector<Vec3>& normals,
                             const SurfaceField& field, int threads);

}  // namespace partscribe::verify
