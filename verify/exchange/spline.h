/// Rational B-spline curves and surfaces evaluated with derivatives, without allocation and on any thread.
#pragma once

#include <vector>

#include "geometry/vec.h"

namespace partscribe::verify {

constexpr int most_spline_degree = 25;

/// Of one parameter: knots repeated by their multiplicity; periodic ones unrolled.
struct SplineKnots {
  int degree = 0;
  std::vector<double> knots;
  double low() const { return knots[std::size_t(degree)]; }
  double high() const { return knots[knots.size() - std::size_t(degree) - 1]; }
};

/// Poles are x w, y w, z w, w.
struct SplineCurve {
  SplineKnots t;
  std::vector<double> poles;
};

struct SplineSurface {
  SplineKnots u, v;
  std::vector<double> poles;  ///< v runs fastest
};

struct CurvePoint {
  Vec3 p, d1, d2;
};
CurvePoint evaluate(const SplineCurve& curve, double t);

struct SplinePoint {
  Vec3 p, du, dv, duu, duv, dvv;
};
SplinePoint evaluate(const SplineSurface& surface, double u, double v);

}  // namespace partscribe::verify
