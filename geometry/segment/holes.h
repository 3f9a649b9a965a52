/// Round holes: bores on one axis, with their steps, countersinks and bottoms.
#pragma once

#include <vector>

#include "geometry/segment/round_pieces.h"
#include "geometry/segment/simple_features.h"

namespace partscribe::geometry {

struct FoundHole {
  SimpleFeature feature;  ///< without its name; the first size is the diameter of its narrowest bore
  Vec3 point = Vec3::Zero(), axis = Vec3::UnitZ();  ///< out of the mouth
  double sigma_point = 0, sigma_axis = 0;           ///< mm across the axis; rad
  Vec3 mouth = Vec3::Zero();                        ///< where its axis leaves the part, at the wide or open end
  RimState far_end = RimState::unknown;             ///< closed: it has a bottom

  double diameter() const { return feature.dimensions.front().value; }
  double sigma_diameter() const { return feature.dimensions.front().sigma; }
};

/// A small chamfer at the rim of a hole is no part of it; a cavity closed at both ends is no hole.
std::vector<FoundHole> holes_of(const Faces& faces, const std::vector<RoundPiece>& pieces, const FeatureScale& scale);

FeatureSize length_of(std::string name, double value, double sigma);
FeatureSize angle_of(std::string name, double value, double sigma);
FeatureSize count_of(std::string name, std::size_t count);

}  // namespace partscribe::geometry
