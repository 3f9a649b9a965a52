/// Queries that move a little from round to round, asked of NearestAgain and of the tree.
#pragma once

#include <catch2/catch.hpp>
#include <vector>

#include "core/random.h"
#include "geometry/points/nearest_again.h"

namespace partscribe::testing {

using namespace geometry;

/// The queries jump for ten rounds and then creep for thirty, within either limit (mm, the narrower every third round).
inline void answers_stay_those_of(const KdTree& tree, NearestAgain& again, std::vector<Vec3> places, double narrow,
                                  double wide, Random& random) {
  for (int round = 0; round < 40; ++round) {
    const double limit = round % 3 == 0 ? narrow : wide, step = round < 10 ? 0.3 : 0.002;
    for (std::size_t k = 0; k < places.size(); ++k) {
      places[k] += step * Vec3(random.normal(), random.normal(), random.normal());
      const Neighbour truth = tree.nearest_one(places[k]);
      CHECK(again.nearest(k, places[k], limit) ==
            (truth.sq_distance <= limit * limit ? truth.index : NearestAgain::nobody));
    }
  }
}

}  // namespace partscribe::testing
