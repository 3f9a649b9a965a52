/// Triangulates what was seen from one side: Delaunay insertion in the image plane, coarse to fine, up to a bound.
#pragma once

#include <optional>

#include "core/context.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/normals/normals.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::fit {

struct HeightFieldOptions {
  double max_error = 0.15;      ///< mm along the normal, between the surface and the averaged points
  double noise_share = 0.4;     ///< of max_error that noise may keep after averaging; smaller averages more points
  double steepest = 1.36;       ///< rad (78 degrees) from the line of sight's normal plane; steeper is a step of depth
  double longest_edge = 4;      ///< typical edges; where data are missing over more than that, the surface ends
  double max_hidden = 0.01;     ///< share of points behind others: with more of them it is no height field
  double max_uncovered = 0.03;  ///< share of points that no triangle may touch: with more, neither
  bool oriented = false;        ///< the normals' side is known, and faces the sensor
};

struct HeightField {
  TriangleMesh mesh;                    ///< manifold, open, one piece per continuous surface, facing the sensor
  Vec3 towards_sensor = Vec3::UnitZ();  ///< from the middle of the part
  double uncovered = 0;                 ///< share of usable points outside of all triangles
};

/// Nothing if the points cannot have been seen from one place or one direction. That place is a view's sensor, where
/// the rays meet, or the frame's origin; else a direction is looked for. `cloud` needs normals, of any sign; rejected
/// points are left out. Does not depend on the order of the points.
std::optional<HeightField> triangulated_height_field(const PointCloud& cloud, const std::vector<View>& views,
                                                     const SamplingSummary& sampling, const HeightFieldOptions& options,
                                                     Context& context);

}  // namespace partscribe::fit
