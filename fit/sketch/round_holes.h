/// Round holes of an extrusion, from what little was seen of their walls and from the end faces around them. In the
/// plane across the sweep, mm; `band` is half the thickness that noise gives a wall.
#pragma once

#include <vector>

#include "fit/sketch/plane_chain.h"
#include "fit/sketch/plane_circle.h"

namespace partscribe::fit {

/// Holes of which at least 70 degrees of wall were seen, in one piece or several, those with most points first. The
/// centre is where the normals of two wall points meet. End faces must lie around a hole, and not in it.
std::vector<PlaneCircle> partly_seen_holes(std::vector<PlanePoint> walls, const std::vector<Vec2>& ends, double band,
                                           double size);

/// The same without normals, which sparse points do not have: from the points `between` the planes of both end faces,
/// with at least 50 degrees of wall. Where the wall hardly determines how large a hole is, the gap in the end faces
/// does. `by_walls`: the wall alone does, because a hole would grow to fill a shadow in the end faces.
std::vector<PlaneCircle> hardly_seen_holes(std::vector<Vec2> between, const std::vector<Vec2>& ends, double band,
                                           double size, bool by_walls = false);

/// Equal holes about known centres: the radius, below `most`, for which walls and what the end faces leave free speak
/// most; none where walls are few, or end faces fill the place.
std::vector<PlaneCircle> holes_about(const std::vector<Vec2>& centres, double most, const std::vector<Vec2>& between,
                                     const std::vector<Vec2>& ends, double band);

}  // namespace partscribe::fit
