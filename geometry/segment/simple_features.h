/// What a machinist calls the faces of a part: holes, slots, bosses, rounds, chamfers, walls, bolt circles.
#pragma once

#include <string>
#include <vector>

#include "geometry/segment/faces.h"

namespace partscribe::geometry {

/// One size of a feature.
struct FeatureSize {
  enum class Quantity { length, angle, count };
  std::string name;  ///< "diameter", "depth", "count", ...
  Quantity quantity = Quantity::length;
  double value = 0;  ///< mm, rad or a whole number
  double sigma = 0;  ///< one standard deviation; 0 of counts
};

/// Faces that belong together, with the sizes a drawing would give.
struct SimpleFeature {
  std::string name;  ///< "hole 3", unique
  /// "through hole", "blind hole", "hole" (an end was not seen), "counterbored hole", "countersunk hole", "slot",
  /// "boss", "fillet", "round", "chamfer", "wall", "bolt circle", "row of holes"
  std::string kind;
  std::vector<std::uint32_t> faces;  ///< ascending; of patterns those of all their members
  std::vector<FeatureSize> dimensions;
};

/// Features in a fixed order: by kind, then larger ones first.
std::vector<SimpleFeature> simple_features(const Faces& faces);

}  // namespace partscribe::geometry
