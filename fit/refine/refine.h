/// Makes a candidate exact: all its parameters and its place at once, by orthogonal distance, with covariance.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

struct RefineOptions {
  std::size_t points = 20000;  ///< of the search, at most; the last steps take all points of the scan
  int iterations = 40;
  /// residuals beyond some 2 * welsch sigmas get no weight; the last steps take 3 unless it is narrower
  double welsch = 2.5;
  bool near = false;  ///< true: every face starts near its place; false: faces that start far off are found too, but
                      ///< may be attracted by outliers hardly seen
  bool uncertainty = true;         ///< false: skip the last steps on all points, and sigma
  std::vector<std::string> fixed;  ///< parameters that keep their value
};

/// What a refinement found besides the candidate's new values.
struct RefineReport {
  double rms = 0;           ///< mm, of the residuals that count
  double inlier_share = 0;  ///< residuals within 4 sigmas
  int iterations = 0;
  bool converged = false;
  double points_per_independent = 1;   ///< above 1 where the errors of neighbouring points are correlated
  std::vector<std::string> unlimited;  ///< lengths without an upper limit: the data end there
};

/// fewer points do not determine a number: they may be outliers or noise
constexpr std::size_t hardly_any_points = 10;

/// Levenberg-Marquardt on Welsch-weighted signed distances of thinned points (reference equations: orthogonal distance
/// regression, Forbes 1989, Ahn 2004), then Gauss-Newton on all points (all_points.h). Directions that the data leave
/// free (symmetries) are removed from the normal matrix.
///
/// Fills value, fitted, points and sigma of every Parameter. sigma has a noise part and a systematic part: disagreement
/// between views, facets, filters, and a least value (uncertainty.h). Of a length that the data leave open, it says how
/// well they determine its end (open_ends.h).
RefineReport refine(Candidate& candidate, const FitInput& input, const RefineOptions& options, Context& context);

/// A model with just this candidate in it, for distances; in the part's own frame.
Model bare_model(const Candidate& candidate);

/// What its parameters are worth now.
Values values_of(const Candidate& candidate);

}  // namespace partscribe::fit
