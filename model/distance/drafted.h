/// The exact distance to an extrusion whose walls lean.
#pragma once

#include "model/distance/solids.h"

namespace partscribe::model {

/// Faces as those of an upright extrusion: one for each piece of the outline, "bottom", "top".
std::unique_ptr<Solid> drafted_solid(const ExtrudeOf<double>& shape);

}  // namespace partscribe::model
