#include "geometry/images/window_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace partscribe::geometry {
namespace {

/// The middle's residual against the prediction of the others; a fit that hangs on the middle predicts nothing.
bool agrees(const WindowFacet& facet) { return facet.value * facet.value <= 9 * (1 - facet.variance); }

/// Without gaps the terms, x^2 and y^2 less 2, are orthogonal.
WindowFit whole_quadric(const Window& heights) {
  double u = 0, x1 = 0, y1 = 0, xx = 0, xy = 0, yy = 0, squares = 0;
  for (std::size_t k = 0; k < 25; ++k) {
    const double x = static_cast<double>(k % 5) - 2, y = static_cast<double>(k / 5) - 2, h = heights[k];
    u += h, x1 += h * x, y1 += h * y, xx += h * (x * x - 2), xy += h * (x * y), yy += h * (y * y - 2);
    squares += h * h;
  }
  WindowFit fit;
  fit.bend = {static_cast<float>(xx / 70), static_cast<float>(xy / 100), static_cast<float>(yy / 70)};
  fit.facet = {static_cast<float>(u / 25 - (xx + yy) / 35), static_cast<float>(x1 / 50), static_cast<float>(y1 / 50),
               27.F / 175, RltsModel::quadric};
  const double sse = squares - u * u / 25 - (x1 * x1 + y1 * y1) / 50 - (xx * xx + yy * yy) / 70 - xy * xy / 100;
  fit.sse = static_cast<float>(std::max(sse, 0.0));
  fit.good = agrees(fit.facet);
  return fit;
}

}  // namespace

float WindowFit::at(int x, int y) const {
  const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
  return facet.value + facet.slope_x * fx + facet.slope_y * fy + bend[0] * fx * fx + bend[1] * fx * fy +
         bend[2] * fy * fy;
}

WindowFit plane_fit(const Window& heights, const Window& weights) {
  double n = 0, sx = 0, sy = 0, xx = 0, xy = 0, yy = 0, su = 0, xu = 0, yu = 0, uu = 0;
  for (std::size_t k = 0; k < 25; ++k) {
    const double w = weights[k], x = static_cast<double>(k % 5) - 2, y = static_cast<double>(k / 5) - 2;
    const double u = w * heights[k];
    n += w, sx += w * x, sy += w * y, xx += w * x * x, xy += w * x * y, yy += w * y * y;
    su += u, xu += u * x, yu += u * y, uu += u * u;
  }
  WindowFit fit;
  if (n < 3) return fit;
  const double mx = sx / n, my = sy / n, mu = su / n;
  xx -= sx * mx, xy -= sx * my, yy -= sy * my, xu -= su * mx, yu -= su * my, uu -= su * mu;
  const double det = xx * yy - xy * xy;
  if (!(det > 0.5)) return fit;
  const double a = (xu * yy - yu * xy) / det, b = (yu * xx - xu * xy) / det;
  fit.facet = {static_cast<float>(mu - a * mx - b * my), static_cast<float>(a), static_cast<float>(b),
               static_cast<float>(1 / n + (mx * mx * yy - 2 * mx * my * xy + my * my * xx) / det), RltsModel::plane};
  fit.sse = static_cast<float>(std::max(uu - a * xu - b * yu, 0.0));
  fit.good = agrees(fit.facet);
  return fit;
}

WindowFit quadric_fit(const Window& heights, const Window& weights) {
  if (std::count(weights.begin(), weights.end(), 1.F) == 25) return whole_quadric(heights);
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  Mat6 a = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  double sum = 0;
  for (std::size_t k = 0; k < 25; ++k) {
    if (weights[k] == 0) continue;
    const double x = static_cast<double>(k % 5) - 2, y = static_cast<double>(k / 5) - 2, h = heights[k];
    const double row[6] = {1, x, y, x * x, x * y, y * y};
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j <= i; ++j) a(i, j) += row[i] * row[j];
      b[i] += h * row[i];
    }
    sum += h * h;
  }
  WindowFit fit;
  const Eigen::LDLT<Mat6> solver(a);  // reads the lower half
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0.2)) return fit;
  const Vec6 x = solver.solve(b);
  fit.facet = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2]),
               static_cast<float>(solver.solve(Vec6::Unit(0))[0]), RltsModel::quadric};
  for (std::size_t k = 0; k < 3; ++k) fit.bend[k] = static_cast<float>(x[static_cast<int>(k) + 3]);
  fit.sse = static_cast<float>(std::max(sum - x.dot(b), 0.0));
  fit.good = agrees(fit.facet);
  return fit;
}

}  // namespace partscribe::geometry
