/// Groups of flat facets of a mesh that lie on one analytic surface, found by growing.
#pragma once

#include <optional>
#include <vector>

#include "geometry/segment/faces.h"
#include "geometry/segment/facets.h"
#include "geometry/surfaces/primitive_fit.h"

namespace partscribe::geometry {

/// Facets of one surface; connected, but for the crumbs.
struct MeshPatch {
  std::vector<std::uint32_t> facets;
  std::optional<Primitive> surface;  ///< none: free form, or crumbs
  bool hollow = false;               ///< of round kinds: the material is outside
  bool crumbs = false;               ///< what is too small to be a face, from all over the mesh
};

struct MeshPatches {
  std::vector<MeshPatch> patches;
  double corner_error = 0;  ///< mm that corners may lie off their surface
};

/// All facets in patches, with the tolerance that the options state.
MeshPatches mesh_patches(const TriangleMesh& mesh, const Facets& facets, const FaceOptions& options);

}  // namespace partscribe::geometry
