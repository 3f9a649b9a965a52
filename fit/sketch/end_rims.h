/// The rims of an extrusion's end faces: where a wall was not seen, the face that ends there tells its outline.
#pragma once

#include <vector>

#include "fit/sketch/plane_chain.h"

namespace partscribe::fit {

/// Points of one end face, in its plane -> the points on its rim, moved out to the line that their neighbours do not
/// pass, with the direction out of the face. A point is on the rim if none of its 20 nearest neighbours lies within a
/// sector of 132 degrees. The rim of a shadow looks the same. In the order of `face`.
std::vector<PlanePoint> rim_of(const std::vector<Vec2>& face);

}  // namespace partscribe::fit
