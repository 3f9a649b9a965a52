/// Open polylines as B-spline curves: straight lines where they are straight, cubics with few knots elsewhere.
#pragma once

#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// The line or clamped cubic over 0 .. 1 that lies within `tolerance` (mm) of the polyline through `places` and begins
/// and ends where it does; knots are inserted in the middle of failing spans. `places` need two members.
template <int D>
NurbsCurve<D> fitted_curve(const std::vector<Eigen::Matrix<double, D, 1>>& places, double tolerance);

/// The least-squares curve of given knots with its ends in the first and the last place, which have the parameters
/// `at`.
template <int D>
NurbsCurve<D> curve_through(const std::vector<Eigen::Matrix<double, D, 1>>& places, const std::vector<double>& at,
                            const KnotVector& knots);

extern template NurbsCurve<2> fitted_curve(const std::vector<Vec2>&, double);
extern template NurbsCurve<3> fitted_curve(const std::vector<Vec3>&, double);
extern template NurbsCurve<2> curve_through(const std::vector<Vec2>&, const std::vector<double>&, const KnotVector&);
extern template NurbsCurve<3> curve_through(const std::vector<Vec3>&, const std::vector<double>&, const KnotVector&);

/// The same polyline with places no farther apart than `step`, as long as that takes no more than a thousand a piece.
template <class Place>
std::vector<Place> denser(const std::vector<Place>& places, double step, bool closed = false) {
  std::vector<Place> result;
  const std::size_t pieces = closed ? places.size() : places.size() - 1;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Place d = places[(i + 1) % places.size()] - places[i];
    const int parts = d.norm() > 1000 * step ? 1000
                      : d.norm() > step      ? static_cast<int>(std::ceil(d.norm() / step))
                                             : 1;
    for (int k = 0; k < parts; ++k) result.push_back(places[i] + k * d / parts);
  }
  if (!closed) result.push_back(places.back());
  return result;
}

}  // namespace partscribe::fit
