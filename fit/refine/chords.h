/// Facets of a drawn body lie below the surface they stand for; its vertices lie on it.
#pragma once

#include <vector>

#include "fit/refine/all_points.h"

namespace partscribe::fit {

/// The points are scattered over the facets of a mesh that are too large for its vertices to stand for its surface.
bool on_facets(const FitInput& input);

/// How far inside their facet corners are looked at, where their nearest face is the facet's own: with a candidate that
/// is still off by a little, and with one that is nearly exact.
constexpr double coarse_inset = 0.97, fine_inset = 0.999;

/// Of a facet's depth, how much a correction may miss: the corners are looked at a thousandth inside.
constexpr double chords_left = 0.01;

/// mm, per point: how deep the facet lies there below the true surface, that is the candidate's distance at the point
/// less what the distances at the facet's corners would give. Errors of the corners themselves cancel; flat faces give
/// nothing. The corners are taken a little inside the facet, and the mean depth is enlarged by what that cuts off.
std::vector<double> chord_deviation(const Candidate& candidate, const std::vector<Vec3>& points, const Scan& scan,
                                    double inset, int threads);

/// Of the used points of every node, weighted by their noise.
std::vector<double> mean_of_nodes(const AllPoints& all, const std::vector<double>& of_points);

/// If the corners of the facets lie far closer to the candidate than the facets between them, as in a designer's mesh
/// and not in a scanned or thinned one, the corners decide: Gauss-Newton steps on residuals from which the depth of the
/// facets is taken off. `all` then holds these residuals and the noise that is left, at least `least_sigma`, and has
/// chords_corrected set. Otherwise nothing changes.
void correct_for_chords(Candidate& candidate, AllPoints& all, const FitInput& input, const Unknowns& unknowns,
                        double least_sigma, Context& context);

}  // namespace partscribe::fit
