/// Walls thinner than the noise, where no ray tells from which side a point was seen: the point counts for both sides,
/// weighted by their probabilities.
#pragma once

#include "fit/refine/all_points.h"
#include "model/distance/distance.h"

namespace partscribe::fit {

/// What lies beside a place of a surface within reach of noise.
enum class Beside {
  nothing,
  edge,  ///< another face of which noise may bring points as well
  wall   ///< only the far side of a wall, which looks the other way
};

/// `reach`: mm, along the normal to either side of `foot`, a place of `face`. All in the scan's frame.
Beside beside(const ModelDistance& distance, const Pose& part_from_scan, const Vec3& foot, const Vec3& normal,
              double reach, int face);

/// Every listed point is also assigned to the far side of its wall, behind its foot: a second entry of `all`, after all
/// others, and a pair that refers to both.
void add_far_sides(AllPoints& all, const std::vector<std::size_t>& points, double reach_sigmas,
                   const Candidate& candidate, const Unknowns& unknowns, const ModelDistance& distance, int threads);

/// Distances of paired entries, each from its own face, into `value`.
void measure_pairs(const AllPoints& all, const Candidate& candidate, std::vector<double>& value, int threads);

/// The probability of each entry of a pair, by EM: Gaussians about both faces, whose shares are estimated from the
/// points of that pair of faces, and outliers. Into all.say.
void share_out_pairs(AllPoints& all);

/// The negative log likelihood of a pair.
double pair_loss(const AllPoints& all, std::size_t pair, const std::vector<double>& value);

/// Drops the second entries; their points are left out.
void drop_pairs(AllPoints& all);

}  // namespace partscribe::fit
