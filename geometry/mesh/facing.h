/// The direction that a sheet faces.
#pragma once

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// A unit direction, and how much of the sheet does not face it.
struct Facing {
  Vec3 direction = Vec3::UnitZ();
  /// Share of the area whose normal has a smaller cosine with the direction.
  double turned_away = 1;
};

/// The direction whose largest angle to a triangle's normal is smallest [Badoiu & Clarkson 2003], or the mean normal,
/// whichever leaves less area with a cosine below `least_cosine`.
Facing facing(const TriangleMesh& mesh, double least_cosine);

}  // namespace partscribe::geometry
