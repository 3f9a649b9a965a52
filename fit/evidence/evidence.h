/// How well a candidate explains the data, and what its description costs.
#pragma once

#include <cmath>
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
  /// nats: minus the logarithm of a Student distribution's density (of two degrees of freedom, over that of no
  /// deviation), a ninth of it per sample because neighbours are correlated and outliers come in clusters (nats_of).
  /// More than deciding_samples count as so many.
  double misfit = 0;
  double far_out = 0;      ///< nats: the share of points beyond the tolerance and 4 sigmas in the misfit
  double roughness = 0;    ///< misfit per sample over that of Gaussian noise
  double description = 0;  ///< nats: what writing the procedure down costs
  double total() const { return misfit + description; }
};

/// Of a deviation of so many sigmas.
inline double nats_of(double sigmas) { return std::log1p(sigmas * sigmas / 2) / 6; }

/// Nats between two descriptions of which only the better one may be true: odds of five hundred million in theory, of a
/// few hundred on scans with curtains and clusters of outliers.
constexpr double told_apart = 20;

/// As many samples decide between kinds of parts; more tell the sizes, but share the errors of the scan.
constexpr std::size_t deciding_samples = 4000;

/// How much each of so many samples counts.
inline double weight_of_samples(std::size_t samples) {
  return samples > deciding_samples ? double(deciding_samples) / double(samples) : 1;
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
