/// Round holes of an extrusion, from what little was seen of their walls and from the end faces around them. In the
/// plane across the sweep, mm; `band` is half the thickness that noise gives a wall.
#pragma once

#include <vector>

#include "fit/sketch/plane_chain.h"
#include "fit/sketch/plane_circle.h"

namespace partscribe::fit {

/// Of which at least 70 degrees of wall were seen, in one piece or several: circles on which the normals of two walls
/// meet, those with most points first. End faces must lie around them, and not in them.
std::vector<PlaneCircle> partly_seen_holes(std::vector<PlanePoint> walls, const std::vector<Vec2>& ends, double band,
                                           double size);

/// The same without normals, which few points do not have: from the points `between` the planes of both end faces. At
/// least 50 degrees; what the end faces leave free says how large a hole is where its wall hardly does. `by_walls`: it
/// does not, because a shadow in the end faces would be filled.
std::vector<PlaneCircle> hardly_seen_holes(std::vector<Vec2> between, const std::vector<Vec2>& ends, double band,
                                           double size, bool by_walls = false);

/// Equal holes about known centres: the radius, below `most`, for which walls and what the end faces leave free speak
/// most; none where walls are few, or end faces fill the place.
std::vector<PlaneCircle> holes_about(const std::vector<Vec2>& centres, double most, const std::vector<Vec2>& between,
                                     const std::vector<Vec2>& ends, double band);

}  // namespace partscribe::fit
