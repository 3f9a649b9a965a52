/// Solids of boxes, rods and turned bodies, put together exactly.
#pragma once

#include <optional>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::testing {

using namespace geometry;

/// Nothing where rounding spoils an intersection.
std::optional<TriangleMesh> united_if_possible(const TriangleMesh& a, const TriangleMesh& b);
TriangleMesh united(const TriangleMesh& a, const TriangleMesh& b);
TriangleMesh without(const TriangleMesh& a, const TriangleMesh& b);

/// Sides x, y, z about the origin of its frame.
TriangleMesh block(const Vec3& size, const Pose& world_from_block);
/// From `foot` along the unit vector `axis`.
TriangleMesh rod(const Vec3& foot, const Vec3& axis, double length, double radius, int sectors = 48);

}  // namespace partscribe::testing
