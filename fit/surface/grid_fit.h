/// Fits a B-spline surface to points on a grid, with as few control points as a tolerance allows, by banded solves.
#pragma once

#include <optional>
#include <vector>

#include "core/context.h"
#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// Points whose parameters are all pairs of two lists.
struct SplineGrid {
  std::vector<double> u, v;  ///< mm, ascending; distances in them roughly those on the surface
  std::vector<Vec3> points;  ///< mm, u.size() times v.size(), v running fastest
};

struct GridFitOptions {
  double tolerance = 0.1;     ///< mm, of the distance from the surface, averaged over neighbours where there is noise
  double noise = 0;           ///< mm, of a point; decides how many neighbours are averaged
  int most_controls = 20000;  ///< and never more than a third of the points
};

struct GridFit {
  NurbsSurface surface;  ///< bicubic, clamped, over the ends of both lists
  double worst = 0;      ///< mm, the largest averaged distance
};

/// Least squares at equal parameters, which stay as they are; distances are those along the normals. Knots are halved
/// in until the tolerance is kept, then taken out one by one while the others are moved. A knot that moves or goes
/// changes the net by products of a spline along u and one along v (LineBasis::share_of), so that each try costs
/// little: most are looked at in a few places of each span, and all points have the last word. Knots that crowd around
/// a line across which the data bend sharply become one multiple knot in the place that leaves least: a crease. Nothing
/// if the tolerance would need more control points than allowed, and of fewer than 4 x 4 points.
std::optional<GridFit> fit_grid(const SplineGrid& grid, const GridFitOptions& options, Context& context);

}  // namespace partscribe::fit
