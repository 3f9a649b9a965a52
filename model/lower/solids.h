/// Single features as solids of the basic kinds, in the same frame.
#pragma once

#include "model/shapes.h"

namespace partscribe::model {

/// An extrusion; its concave side is an arc where both legs are equal, a quarter of an ellipse otherwise.
Extrude solid_of(const Fillet& fillet);

/// A turned profile: floors, tip, counterbore and countersink are faces of one solid.
Revolve solid_of(const Hole& hole);

Extrude solid_of(const Slot& slot);
Extrude solid_of(const Pocket& pocket);
Extrude solid_of(const Boss& boss);

/// One sketch for every loop that bounds material from outside, with the holes directly inside it.
std::vector<Sketch> without_islands(const Sketch& sketch, const Values& values);

}  // namespace partscribe::model
