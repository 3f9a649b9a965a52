/// Knots that crowd around a line across which the data bend sharply, as one multiple knot in its place.
#pragma once

#include <optional>
#include <span>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

struct CreaseData {
  std::span<const Vec3> points;     ///< mm
  std::span<const Vec2> places;     ///< of the points in the domain, mm
  std::span<const double> weights;  ///< may be empty for 1 each
  double noise = 0;                 ///< mm, of a point
  double fairness = 1e-6;           ///< of the bending energy (NetEquations)
};

/// The knots of one direction of a bicubic net, with one knot of multiplicity three in place of a group that
/// crowds in spans much shorter than the mean: in the place where least squares over the strip around them leave least,
/// if that is no more than the group leaves. Nothing where no group can be replaced.
std::optional<KnotVector> crease_knots(const CreaseData& data, const KnotVector& u, const KnotVector& v, bool along_u);

/// Spans between inner knots that are no longer than those beside them and than 0.4 of the mean, as the indices
/// of their first breaks.
std::vector<std::size_t> narrow_spans(const std::vector<double>& breaks);

/// Where a function is largest between `low` and `high`: among 13 places, then by golden section to a hundredth of
/// their distance or `shares` of it.
template <class Function>
double highest_place(const Function& at, double low, double high, double shares = 0.01) {
  constexpr int places = 12;
  const double step = (high - low) / places;
  double middle = low, most = at(low);
  for (int i = 1; i <= places; ++i)
    if (const double value = at(low + i * step); value > most) most = value, middle = low + i * step;
  constexpr double ratio = 0.6180339887498949;
  double a = middle - step < low ? low : middle - step, b = middle + step > high ? high : middle + step;
  double x = b - ratio * (b - a), y = a + ratio * (b - a), of_x = at(x), of_y = at(y);
  while (b - a > shares * step)
    if (of_x > of_y)
      b = y, y = x, of_y = of_x, x = b - ratio * (b - a), of_x = at(x);
    else
      a = x, x = y, of_x = of_y, y = a + ratio * (b - a), of_y = at(y);
  return 0.5 * (a + b);
}

}  // namespace partscribe::fit
