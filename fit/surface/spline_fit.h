/// Fits a B-spline surface to scattered points, with as few control points as a tolerance allows.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "core/context.h"
#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// How many points the mean of which noise (mm, of a point) moves by an eighth of the tolerance.
inline double enough_to_average(double noise, double tolerance) { return std::pow(noise / (0.12 * tolerance), 2); }

/// Points and where each is to lie in the plane of the parameters, mm both.
struct SplineData {
  std::vector<Vec3> points;
  std::vector<Vec2> places;     ///< (u, v), distances in it roughly those on the surface
  std::vector<double> weights;  ///< of the points; those beyond its end count once
  /// How many of the last points are to be met closely: each by itself, within `held_tolerance`.
  std::size_t held = 0;
};

struct SplineFitOptions {
  double tolerance = 0.1;                        ///< mm, of the distance from the surface, averaged over neighbours
  double noise = 0;                              ///< mm, of a point; decides how many neighbours are averaged
  Vec2 low = Vec2::Zero(), high = Vec2::Ones();  ///< the domain; must hold all places
  int most_controls = 20000;
  double held_tolerance = 0.01;  ///< mm, of each held point
};

struct SplineFit {
  NurbsSurface surface;      ///< bicubic, clamped
  std::vector<Vec2> places;  ///< of the points: their feet
  double worst = 0;          ///< mm, the largest averaged distance
};

/// Least squares over a net of control points that is refined where the averaged distance exceeds the tolerance: knots
/// are inserted in the middle of failing spans, across the direction in which the residuals vary, and the parameters of
/// the points corrected to their feet (Koivunen et al. 1993, section 3.2; Piegl and Tiller, sections 9.4 and 9.5). Then
/// as few knots as will do are chosen anew (fewest_knots). A small part of the bending energy makes the net fair where
/// there are no points. Nothing if the tolerance would need more control points than allowed, or than a third of the
/// points.
std::optional<SplineFit> fit_spline(const SplineData& data, const SplineFitOptions& options, Context& context);

/// The same beginning with the knots of a surface that was fitted before; where more are needed, others may go.
std::optional<SplineFit> fit_spline_again(const SplineData& data, const NurbsSurface& before,
                                          const SplineFitOptions& options, Context& context);

}  // namespace partscribe::fit
