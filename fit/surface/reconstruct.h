/// A surface from oriented noisy points: sharp where the points are, closed where they nearly bound a solid.
#pragma once

#include "core/context.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/normals/normals.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::fit {

struct ReconstructOptions {
  double cell = 0;  ///< mm, edge of the grid's cells; 0: from the sampling, the noise, the size and thin walls
  double unseen_share = 0.3;  ///< more surface than this without data: the points are a sheet, not a solid
  double unseen_share_with_rays = 0.4;
  std::size_t max_nodes = 9000000;  ///< of the grid; coarser cells beyond
};

struct Reconstruction {
  TriangleMesh mesh;  ///< manifold and oriented; the normals' side is outside
  bool closed = false;
  double cell = 0;          ///< mm
  double unseen_share = 0;  ///< share of the closed surface that no data support
  std::size_t dropped_pieces = 0;
};

/// Dual contouring [Ju et al. 2002] of the signed distance from averaged points. Vertices go to the least-squares
/// intersection of the planes around them, so that edges and corners stay sharp. Where there are no points the sign is
/// continued harmonically [Davis et al. 2002], except that everything a viewing ray passed through is outside [Curless
/// & Levoy 1996]. Points whose surface no other points continue are taken for outliers. The result does not depend on
/// the order of the points. `cloud` needs normals; rejected points are left out. Fewer than some dozen usable points
/// give an empty mesh.
Reconstruction reconstruct(const PointCloud& cloud, const SamplingSummary& sampling, const ReconstructOptions& options,
                           Context& context);

}  // namespace partscribe::fit
