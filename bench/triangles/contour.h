/// The surface of a solid that a function describes, as a fine triangle mesh.
#pragma once

#include <functional>

#include "geometry/mesh/triangle_mesh.h"

namespace bench {

using namespace partscribe::geometry;

/// The surface `solid` = 0 in cubic cells of `pitch` mm, facing where the function grows; it is negative inside, about
/// a distance, and positive at the border of `box`. One vertex a cell, where the planes that the surface has at the
/// cell's edges meet best, so that sharp edges and corners stay sharp (dual contouring, Ju et al. 2002).
TriangleMesh contoured(const std::function<double(const Vec3&)>& solid, const Box3& box, double pitch);

}  // namespace bench
