/// How well a candidate explains the data, and what its description costs.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// Signed deviations of the input's points from a candidate, and the sums that decide.
struct CandidateEvidence {
  double rms = 0;             ///< mm, of residuals within 4 sigmas
  double local_max = 0;       ///< mm, largest local robust mean of the signed distance
  Vec3 worst = Vec3::Zero();  ///< where
  double misfit = 0;          ///< nats: sum of min(u^2 / 2, 12) / 2 over the points (neighbours are correlated)
  /// nats: the share of points beyond 2.5 sigmas in the misfit; noise alone puts one in eighty there
  double far_out = 0;
  std::size_t unexplained = 0;  ///< points beyond the tolerance and 4 sigmas
  double description = 0;       ///< nats: what writing the procedure down costs
  double total() const { return misfit + description; }
};

/// cost of a point that a shape does not explain: the upper bound of its misfit
constexpr double nats_per_outlier = 6;

constexpr double more_likely = 20;  ///< nats by which a longer description must fit its own points better

/// The same for another procedure: a body of another kind can fit outliers everywhere on its surface.
inline double far_more_likely(double outlier_share, std::size_t points) {
  return more_likely + 0.1 * outlier_share * double(points);
}
inline double far_more_likely(const FitInput& input) {
  return far_more_likely(input.outlier_share, input.cloud.size());
}

/// By how many points a shape must explain more than a simpler one: where there are many outliers, any shape explains
/// some.
inline double worth_a_shape(const FitInput& input) {
  const double points = double(input.cloud.size());
  return std::max(20.0, points / 200) + 0.05 * input.outlier_share * points;
}

/// Nats by which one candidate may be better than another because of outliers alone: outliers that lie on it and not on
/// the other, and, if there are many outliers, all points that are farther from the other than noise explains, because
/// curtains and clusters of outliers begin at the surface.
inline double gained_by_outliers(const CandidateEvidence& ahead, const CandidateEvidence& other,
                                 const FitInput& input) {
  const double left = nats_per_outlier * (double(other.unexplained) - double(ahead.unexplained));
  return std::max({left, among_outliers(input) ? other.far_out - ahead.far_out : 0, 0.0});
}

/// Up to 25 of the nearest points whose normals agree within 45 degrees and which lie within six times the spacing.
std::shared_ptr<const Surroundings> surroundings_of(const FitInput& input, Context& context);

/// A deviation in words, to a twentieth of the tolerance or a little finer; both in mm.
std::string millimetres(double deviation, double tolerance);

/// False for a sketch with a loop that has shrunk to a point, or with numbers that are none: it has no distances.
bool drawable(const Candidate& candidate);

/// Drawable, and a model that check() takes.
bool makes_sense(const Candidate& candidate);

/// Nats for a shape: a constant per sketch element or face, half the logarithm of the number of points per number.
double description_length(const Candidate& candidate, std::size_t points);

/// Local robust mean: median over the surroundings, then the mean of those within 2.5 median absolute deviations.
CandidateEvidence evidence_of(const Candidate& candidate, const FitInput& input, Context& context);

}  // namespace partscribe::fit
