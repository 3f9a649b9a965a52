/// Proposes blocks, wedges and convex polyhedra for parts whose faces are all plane.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe {

/// A plane face of a convex body.
struct ConvexFace {
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  double offset = 0;           ///< normal . p = offset, scan's frame
  std::size_t points = 0;      ///< that lie on it; 0: not scanned, the plane closes the body at the end of the data
};

/// The faces of the convex body that explains the points, largest first; empty if the points are not those of a
/// convex body with plane faces. A face that was not scanned is closed where the data of its neighbours end at one
/// plane.
std::vector<ConvexFace> convex_faces(const FitInput& input, Context& context);

/// Box, Wedge and HalfSpaces, the simplest first, as far as the faces of the body allow; empty for other parts.
std::vector<Candidate> propose_polyhedra(const FitInput& input, Context& context);

}  // namespace partscribe
