/// The four cubic basis functions that live at a place, for many places in turn.
#pragma once

#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// As basis(), for degree three alone; quick where one place lies in the span of the one before.
class CubicBasis {
 public:
  explicit CubicBasis(const KnotVector& knots) : knots_(knots) {}

  int first = 0;              ///< control point of the first of them
  double value[4], slope[4];  ///< with the derivative

  void move_to(double t) {
    const auto* k = knots_.knots.data();
    if (!(span_ >= 0 && k[span_] <= t && t < k[span_ + 1])) span_ = knots_.span(t), first = span_ - 3;
    const double a1 = t - k[span_], a2 = t - k[span_ - 1], a3 = t - k[span_ - 2];
    const double b1 = k[span_ + 1] - t, b2 = k[span_ + 2] - t, b3 = k[span_ + 3] - t;
    const double linear = 1 / (a1 + b1);
    const double p = b1 * linear / (a2 + b1), q = a1 * linear / (a1 + b2);
    const double n0 = b1 * p, n1 = a2 * p + b2 * q, n2 = a1 * q;  // quadratic
    const double x = n0 / (a3 + b1), y = n1 / (a2 + b2), z = n2 / (a1 + b3);
    value[0] = b1 * x, value[1] = a3 * x + b2 * y, value[2] = a2 * y + b3 * z, value[3] = a1 * z;
    slope[0] = -3 * x, slope[1] = 3 * (x - y), slope[2] = 3 * (y - z), slope[3] = 3 * z;
  }

 private:
  const KnotVector& knots_;
  int span_ = -1;
};

}  // namespace partscribe::geometry
