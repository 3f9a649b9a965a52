/// Equal holes on a circle or in a line.
#pragma once

#include <vector>

#include "geometry/segment/holes.h"

namespace partscribe::geometry {

/// Bolt circles about an axis of the part first, then rows, then circles about nothing; a hole belongs to one pattern.
std::vector<SimpleFeature> hole_patterns(const std::vector<FoundHole>& holes, const std::vector<RoundPiece>& pieces,
                                         const FeatureScale& scale);

}  // namespace partscribe::geometry
