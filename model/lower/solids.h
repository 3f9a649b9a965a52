/// Single features as solids of the basic kinds, in the same frame.
#pragma once

#include "model/shapes.h"

namespace partscribe::model {

/// An extrusion; its concave side is an arc where both legs are equal, a quarter of an ellipse otherwise.
Extrude solid_of(const Fillet& fillet);

/// A turned profile: floors, tip, counterbore and countersink are faces of one solid.
Revolve solid_of(const Hole& hole);

Extrude solid_of(const Slot& slot);
template <class N>
ExtrudeOf<N> solid_of(const PocketOf<N>& s) {
  return {s.sketch, s.overshoot, s.through ? s.depth + s.overshoot : s.depth, -s.draft};
}
template <class N>
ExtrudeOf<N> solid_of(const BossOf<N>& s) {
  return {s.sketch, s.height, s.root, s.draft};
}

/// Six patches: the surface, its image where it ends up, and four ruled sides between their borders.
SurfaceSetOf<double> solid_of(const SweptSurfaceOf<double>& swept);
SurfaceSet solid_of(const SweptSurface& swept);

/// A shape that a simpler solid says.
template <class S>
concept SaidSimpler = requires(const S& s) {
  solid_of(s);
};

/// One sketch for every loop that bounds material from outside, with the holes directly inside it.
std::vector<Sketch> without_islands(const Sketch& sketch, const Values& values);

}  // namespace partscribe::model
