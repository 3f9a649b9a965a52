/// Least-squares B-splines as published in 1993 (Koivunen, Vezien & Bajcsy, section 3.2): parameters chosen beforehand,
/// errors at equal parameters, knots where the errors are largest.
///
/// fit_spline() is the better way to a tolerance: it corrects parameters and measures true distances. These fits say
/// what the published ones would, and are the quickest for data on a grid.
#pragma once

#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// How places along a line get their parameters, always from 0 to 1.
enum class Parameters {
  uniform,       ///< equal steps
  chord_length,  ///< steps as the distances between places (the paper's choice)
  centripetal    ///< steps as their square roots (Lee 1989)
};

std::vector<double> parameters_of(const std::vector<Vec3>& places, Parameters kind);

/// Clamped over 0 .. 1, `controls` control points with equal spans; `order` is the degree + 1.
KnotVector equal_spans(int controls, int order = 4);

/// With as many more knots at `at` as make its multiplicity the order: the curve may jump there.
KnotVector with_gap(KnotVector knots, double at);

struct PublishedCurve {
  NurbsCurve<3> curve;
  std::vector<double> parameters;  ///< of the places
  std::vector<double> errors;      ///< mm, of each place from the curve at its parameter
  double worst = 0;                ///< the largest of them
};

/// Equation (4), B = (C^T C)^-1 C^T S, with C the basis functions at the parameters. Spans without data keep straight.
PublishedCurve published_curve(const std::vector<Vec3>& places, const std::vector<double>& parameters,
                               const KnotVector& knots);

/// Knots are added at the local maxima of the error as long as it exceeds `tolerance` (mm) and the data allow it: each
/// in the middle of the span around it, or of the one beside it where that holds fewer than four places.
PublishedCurve refined_curve(const std::vector<Vec3>& places, const std::vector<double>& parameters,
                             const KnotVector& start, double tolerance);

/// Places on a net, columns running fastest.
struct PlaceGrid {
  int columns = 0, rows = 0;
  std::vector<Vec3> places;  ///< mm
  const Vec3& at(int column, int row) const {
    return places[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
  }
};

struct PublishedSurface {
  NurbsSurface surface;        ///< u along the columns of a row, v along the rows
  std::vector<double> u, v;    ///< of the columns and rows
  std::vector<double> errors;  ///< mm, as the grid's places, at equal (u, v)
  double worst = 0;
};

/// Rows are fitted, then their control points across: two banded systems. A grid has one parameter for each column and
/// row, the mean over the lines.
PublishedSurface published_surface(const PlaceGrid& grid, const KnotVector& u, const KnotVector& v, Parameters kind);

/// As refined_curve, in both directions: a knot each for the column and the row of a local maximum.
PublishedSurface refined_surface(const PlaceGrid& grid, const KnotVector& u, const KnotVector& v, Parameters kind,
                                 double tolerance, int most_controls = 20000);

}  // namespace partscribe::fit
