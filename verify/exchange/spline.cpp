#include "verify/exchange/spline.h"

#include <algorithm>

namespace partscribe::verify {
namespace {

/// Values and two derivatives of the degree + 1 basis functions that live at x (Piegl & Tiller, The NURBS Book, A2.3,
/// by differences of lower degrees); returns the first pole's index.
int basis(const SplineKnots& s, double x, double (*ders)[most_spline_degree + 1]) {
  const int p = s.degree;
  const auto& k = s.knots;
  const auto end = k.end() - p - 1;
  int span = static_cast<int>(std::upper_bound(k.begin() + p + 1, end, x) - k.begin()) - 1;
  double left[most_spline_degree + 1], right[most_spline_degree + 1];
  double value[3][most_spline_degree + 1];  // of degree p - 2, p - 1, p
  double n[most_spline_degree + 1];
  n[0] = 1;
  if (p == 2) value[0][0] = 1;
  if (p == 1) value[1][0] = 1;
  for (int j = 1; j <= p; ++j) {
    left[j] = x - k[std::size_t(span + 1 - j)], right[j] = k[std::size_t(span + j)] - x;
    double saved = 0;
    for (int r = 0; r < j; ++r) {
      const double t = n[r] / (right[r + 1] + left[j - r]);
      n[r] = saved + right[r + 1] * t;
      saved = left[j - r] * t;
    }
    n[j] = saved;
    if (j >= p - 2 && j < p)
      for (int r = 0; r <= j; ++r) value[j - p + 2][r] = n[r];
  }
  for (int r = 0; r <= p; ++r) ders[0][r] = n[r];
  // N'_(i,p) = p (N_(i,p-1) / (k_(i+p) - k_i) - N_(i+1,p-1) / (k_(i+p+1) - k_(i+1))).
  auto lowered = [&](const double* lower, int degree, int i) -> double {
    // Function i (0..degree) of `degree` from the `degree` functions of one degree less that live on the span.
    const int first = span - degree + i;
    double d = 0;
    if (i > 0) d += lower[i - 1] / (k[std::size_t(first + degree)] - k[std::size_t(first)]);
    if (i < degree) d -= lower[i] / (k[std::size_t(first + degree + 1)] - k[std::size_t(first + 1)]);
    return degree * d;
  };
  for (int i = 0; i <= p; ++i) ders[1][i] = p >= 1 ? lowered(value[1], p, i) : 0;
  if (p >= 2) {
    double first[most_spline_degree + 1];
    for (int i = 0; i < p; ++i) first[i] = lowered(value[0], p - 1, i);
    for (int i = 0; i <= p; ++i) ders[2][i] = lowered(first, p, i);
  } else {
    for (int i = 0; i <= p; ++i) ders[2][i] = 0;
  }
  return span - p;
}

}  // namespace

CurvePoint evaluate(const SplineCurve& curve, double t) {
  double n[3][most_spline_degree + 1];
  const int first = basis(curve.t, t, n);
  double h[3][4] = {};
  for (int i = 0; i <= curve.t.degree; ++i) {
    const double* pole = &curve.poles[std::size_t(first + i) * 4];
    for (int d = 0; d < 3; ++d)
      for (int c = 0; c < 4; ++c) h[d][c] += n[d][i] * pole[c];
  }
  CurvePoint r;
  const double w = 1 / h[0][3];
  r.p = w * Vec3(h[0][0], h[0][1], h[0][2]);
  r.d1 = w * (Vec3(h[1][0], h[1][1], h[1][2]) - h[1][3] * r.p);
  r.d2 = w * (Vec3(h[2][0], h[2][1], h[2][2]) - 2 * h[1][3] * r.d1 - h[2][3] * r.p);
  return r;
}

SplinePoint evaluate(const SplineSurface& surface, double u, double v) {
  double nu[3][most_spline_degree + 1], nv[3][most_spline_degree + 1];
  const int first_u = basis(surface.u, u, nu), first_v = basis(surface.v, v, nv);
  const std::size_t row = surface.v.knots.size() - std::size_t(surface.v.degree) - 1;
  double h[3][3][4] = {};  // by derivative in u, in v
  for (int i = 0; i <= surface.u.degree; ++i) {
    double line[3][4] = {};
    const double* pole = &surface.poles[(std::size_t(first_u + i) * row + std::size_t(first_v)) * 4];
    for (int j = 0; j <= surface.v.degree; ++j, pole += 4)
      for (int d = 0; d < 3; ++d)
        for (int c = 0; c < 4; ++c) line[d][c] += nv[d][j] * pole[c];
    for (int d = 0; d < 3; ++d)
      for (int e = 0; d + e < 3; ++e)
        for (int c = 0; c < 4; ++c) h[d][e][c] += nu[d][i] * line[e][c];
  }
  auto xyz = [&](int d, int e) { return Vec3(h[d][e][0], h[d][e][1], h[d][e][2]); };
  SplinePoint r;
  const double w = 1 / h[0][0][3], wu = h[1][0][3], wv = h[0][1][3];
  r.p = w * xyz(0, 0);
  r.du = w * (xyz(1, 0) - wu * r.p);
  r.dv = w * (xyz(0, 1) - wv * r.p);
  r.duu = w * (xyz(2, 0) - 2 * wu * r.du - h[2][0][3] * r.p);
  r.dvv = w * (xyz(0, 2) - 2 * wv * r.dv - h[0][2][3] * r.p);
  r.duv = w * (xyz(1, 1) - wu * r.dv - wv * r.du - h[1][1][3] * r.p);
  return r;
}

}  // namespace partscribe::verify
