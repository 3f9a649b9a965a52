/// The rims of an extrusion's end faces: where a wall was not seen, the face that ends there tells its outline.
#pragma once

#include <vector>

#include "fit/sketch/plane_chain.h"

namespace partscribe::fit {

/// The points on the rim of an end face, given its points in their plane; in the order of `face`. Each is moved
/// outwards to the line that none of its neighbours passes, and has the direction out of the face. A point is on the
/// rim if there is a sector of 132 degrees about it without any of its 20 nearest neighbours. The rim of a shadow looks
/// the same.
std::vector<PlanePoint> rim_of(const std::vector<Vec2>& face);

}  // namespace partscribe::fit
