#include "geometry/surfaces/nurbs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/ensure.h"

namespace partscribe::geometry {

int KnotVector::span(double t) const {
  const auto first = knots.begin() + degree, last = knots.end() - degree - 1;
  // The last knot of the domain belongs to the span before it.
  const auto after = t < *last ? std::upper_bound(first, last, t) : std::lower_bound(first, last, *last);
  return std::max(static_cast<int>(after - knots.begin()) - 1, degree);
}

std::vector<std::pair<double, int>> KnotVector::multiplicities() const {
  std::vector<std::pair<double, int>> result;
  for (const double knot : knots) {
    if (result.empty() || knot > result.back().first) result.emplace_back(knot, 0);
    ++result.back().second;
  }
  return result;
}

std::vector<double> KnotVector::breaks() const {
  std::vector<double> result(knots.begin() + degree, knots.end() - degree);
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

KnotVector clamped(int degree, const std::vector<double>& breaks) {
  ensure(breaks.size() >= 2, "a knot vector has two ends");
  KnotVector result{degree, breaks};
  result.knots.insert(result.knots.begin(), static_cast<std::size_t>(degree), breaks.front());
  result.knots.insert(result.knots.end(), static_cast<std::size_t>(degree), breaks.back());
  return result;
}

void basis(const KnotVector& s, double t, int derivatives, BasisValues& result) {
  // The NURBS Book, A2.2; derivatives as differences of lower degrees, N' = p (N_i,p-1 / (t_i+p - t_i) - ...).
  const int p = s.degree, span = s.span(t);
  ensure(p <= most_spline_degree, "a B-spline's degree is at most 25");
  const auto& k = s.knots;
  double left[most_spline_degree + 1], right[most_spline_degree + 1];
  double lower[2][most_spline_degree + 1];  // of degree p - 2, p - 1
  auto& n = result.value[0];
  result.first = span - p;
  n[0] = 1;
  for (int j = 1; j <= p; ++j) {
    if (j >= p - 1) std::copy(n, n + j, lower[j - p + 1]);
    left[j] = t - k[std::size_t(span + 1 - j)], right[j] = k[std::size_t(span + j)] - t;
    double saved = 0;
    for (int r = 0; r < j; ++r) {
      const double share = n[r] / (right[r + 1] + left[j - r]);
      n[r] = saved + right[r + 1] * share;
      saved = left[j - r] * share;
    }
    n[j] = saved;
  }
  // Function i (0 .. degree) of `degree` from the `degree` functions of one degree less that live on the span.
  const auto derived = [&](const double* less, int degree, int i) {
    const std::size_t first = std::size_t(span - degree + i), d = std::size_t(degree);
    double sum = 0;
    if (i > 0) sum += less[i - 1] / (k[first + d] - k[first]);
    if (i < degree) sum -= less[i] / (k[first + d + 1] - k[first + 1]);
    return degree * sum;
  };
  if (derivatives < 1) return;
  for (int i = 0; i <= p; ++i) result.value[1][i] = p >= 1 ? derived(lower[1], p, i) : 0;
  if (derivatives < 2) return;
  double once[most_spline_degree + 1];
  for (int i = 0; i < p; ++i) once[i] = p >= 2 ? derived(lower[0], p - 1, i) : 0;
  for (int i = 0; i <= p; ++i) result.value[2][i] = p >= 2 ? derived(once, p, i) : 0;
}

template <int D>
typename NurbsCurve<D>::Point NurbsCurve<D>::at(double u) const {
  BasisValues n;
  basis(t, u, 0, n);
  Point sum = Point::Zero();
  double weight = weights.empty() ? 1 : 0;
  for (int i = 0; i <= t.degree; ++i) {
    const std::size_t c = std::size_t(n.first + i);
    const double share = weights.empty() ? n.value[0][i] : n.value[0][i] * weights[c];
    sum += share * points[c];
    if (!weights.empty()) weight += share;
  }
  return sum / weight;
}

template <int D>
void NurbsCurve<D>::derivatives(double u, Point& point, Point& first, Point& second) const {
  BasisValues n;
  basis(t, u, 2, n);
  Point sum[3] = {Point::Zero(), Point::Zero(), Point::Zero()};
  double weight[3] = {};
  for (int i = 0; i <= t.degree; ++i) {
    const std::size_t c = std::size_t(n.first + i);
    const double w = weights.empty() ? 1 : weights[c];
    for (int d = 0; d < 3; ++d) {
      sum[d] += n.value[d][i] * w * points[c];
      weight[d] += n.value[d][i] * w;
    }
  }
  if (weights.empty()) {
    point = sum[0], first = sum[1], second = sum[2];
    return;
  }
  point = sum[0] / weight[0];
  first = (sum[1] - weight[1] * point) / weight[0];
  second = (sum[2] - 2 * weight[1] * first - weight[2] * point) / weight[0];
}

Vec3 SurfacePoint::normal() const {
  const Vec3 n = du.cross(dv);
  const double length = n.norm();
  return length > 1e-12 * (du.squaredNorm() + dv.squaredNorm()) ? Vec3(n / length) : Vec3::Zero();
}

Vec3 NurbsSurface::at(double s, double t) const {
  BasisValues nu, nv;
  basis(u, s, 0, nu);
  basis(v, t, 0, nv);
  const int row = v.count();
  Vec3 sum = Vec3::Zero();
  double weight = 0;
  for (int i = 0; i <= u.degree; ++i) {
    const std::size_t from = std::size_t((nu.first + i) * row + nv.first);
    Vec3 line = Vec3::Zero();
    double along = 0;
    for (int j = 0; j <= v.degree; ++j) {
      const std::size_t c = from + std::size_t(j);
      const double share = weights.empty() ? nv.value[0][j] : nv.value[0][j] * weights[c];
      line += share * points[c], along += share;
    }
    sum += nu.value[0][i] * line, weight += nu.value[0][i] * along;
  }
  return weights.empty() ? sum : Vec3(sum / weight);
}

SurfacePoint NurbsSurface::derivatives(double s, double t) const {
  BasisValues nu, nv;
  basis(u, s, 2, nu);
  basis(v, t, 2, nv);
  const int row = v.count();
  Vec3 h[3][3];  // by derivative in u, in v
  double w[3][3] = {};
  for (auto& line : h)
    for (Vec3& x : line) x.setZero();
  for (int i = 0; i <= u.degree; ++i) {
    const std::size_t from = std::size_t((nu.first + i) * row + nv.first);
    Vec3 line[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    double along[3] = {};
    for (int j = 0; j <= v.degree; ++j) {
      const std::size_t c = from + std::size_t(j);
      const double weight = weights.empty() ? 1 : weights[c];
      for (int d = 0; d < 3; ++d) {
        const double share = nv.value[d][j] * weight;
        line[d] += share * points[c], along[d] += share;
      }
    }
    for (int d = 0; d < 3; ++d)
      for (int e = 0; d + e < 3; ++e) {
        h[d][e] += nu.value[d][i] * line[e];
        w[d][e] += nu.value[d][i] * along[e];
      }
  }
  SurfacePoint r;
  if (weights.empty()) {
    r.p = h[0][0], r.du = h[1][0], r.dv = h[0][1], r.duu = h[2][0], r.duv = h[1][1], r.dvv = h[0][2];
    return r;
  }
  const double f = 1 / w[0][0];
  r.p = f * h[0][0];
  r.du = f * (h[1][0] - w[1][0] * r.p);
  r.dv = f * (h[0][1] - w[0][1] * r.p);
  r.duu = f * (h[2][0] - 2 * w[1][0] * r.du - w[2][0] * r.p);
  r.dvv = f * (h[0][2] - 2 * w[0][1] * r.dv - w[0][2] * r.p);
  r.duv = f * (h[1][1] - w[1][0] * r.dv - w[0][1] * r.du - w[1][1] * r.p);
  return r;
}

Vec3 normal_at(const NurbsSurface& surface, double u, double v) {
  const SurfacePoint at = surface.derivatives(u, v);
  if (const Vec3 n = at.normal(); !n.isZero()) return n;
  // Inwards by e (su, sv) the derivatives are du + e (su duu + sv duv), dv + e (su duv + sv dvv): the lowest power of e
  // whose factor in their product does not vanish says where the normal comes from.
  const double low_u = surface.u.low(), high_u = surface.u.high(), low_v = surface.v.low(), high_v = surface.v.high();
  const double edge_u = 1e-9 * (high_u - low_u), edge_v = 1e-9 * (high_v - low_v);
  double su = u < low_u + edge_u ? 1 : u > high_u - edge_u ? -1 : 0;
  double sv = v < low_v + edge_v ? 1 : v > high_v - edge_v ? -1 : 0;
  // An edge that is a point is left across it, so that the limit is that of its own u or v.
  const double first_u = at.du.norm() * (high_u - low_u), first_v = at.dv.norm() * (high_v - low_v);
  if (sv != 0 && first_u < 1e-9 * first_v) su = 0;
  if (su != 0 && first_v < 1e-9 * first_u) sv = 0;
  su *= high_u - low_u, sv *= high_v - low_v;
  const Vec3 du = su * at.duu + sv * at.duv, dv = su * at.duv + sv * at.dvv;
  const Vec3 once = du.cross(at.dv) + at.du.cross(dv), twice = du.cross(dv);
  const double size_u = du.norm() + at.du.norm(), size_v = dv.norm() + at.dv.norm();
  for (const Vec3& n : {once, twice})
    if (const double length = n.norm(); length > 1e-9 * size_u * size_v) return n / length;
  return Vec3::Zero();
}

std::vector<double> insertion_shares(const KnotVector& s, double t) {
  const int span = s.span(t), p = s.degree;
  std::vector<double> shares(std::size_t(s.count()) + 1, 0.0);
  for (int i = 0; i <= s.count(); ++i) {
    double share = i <= span - p ? 1 : 0;
    if (i > span - p && i <= span) {
      const double a = s.knots[std::size_t(i)], b = s.knots[std::size_t(i + p)];
      share = b > a ? (t - a) / (b - a) : 0;
    }
    shares[std::size_t(i)] = share;
  }
  return shares;
}

KnotVector with_knot(const KnotVector& s, double t) {
  KnotVector result = s;
  result.knots.insert(std::upper_bound(result.knots.begin(), result.knots.end(), t), t);
  return result;
}

namespace {

/// Refines each of `lines` lines of control points; `fastest`: the points of a line stand one after the other.
template <class Point>
void insert_once(std::vector<Point>& points, std::vector<double>& weights, const std::vector<double>& shares,
                 std::size_t lines, bool fastest) {
  const std::size_t more = shares.size(), count = more - 1;
  std::vector<Point> refined(more * lines);
  std::vector<double> refined_weights(weights.empty() ? 0 : more * lines);
  for (std::size_t l = 0; l < lines; ++l)
    for (std::size_t i = 0; i < more; ++i) {
      const auto old_place = [&](std::size_t k) { return fastest ? l * count + k : k * lines + l; };
      const std::size_t place = fastest ? l * more + i : i * lines + l;
      const double b = shares[i], a = 1 - b;
      const std::size_t from = old_place(i > 0 ? i - 1 : 0), to = old_place(i < count ? i : count - 1);
      if (weights.empty()) {
        refined[place] = a * points[from] + b * points[to];
        continue;
      }
      const double wa = a * weights[from], wb = b * weights[to];
      refined_weights[place] = wa + wb;
      refined[place] = (wa * points[from] + wb * points[to]) / (wa + wb);
    }
  points = std::move(refined), weights = std::move(refined_weights);
}

}  // namespace

template <int D>
NurbsCurve<D> with_knot(const NurbsCurve<D>& curve, double t, int times) {
  NurbsCurve<D> result = curve;
  for (int i = 0; i < times; ++i) {
    insert_once(result.points, result.weights, insertion_shares(result.t, t), 1, true);
    result.t = with_knot(result.t, t);
  }
  return result;
}

NurbsSurface with_knot(const NurbsSurface& surface, bool along_u, double t, int times) {
  NurbsSurface result = surface;
  for (int i = 0; i < times; ++i) {
    KnotVector& s = along_u ? result.u : result.v;
    const std::size_t lines = std::size_t((along_u ? result.v : result.u).count());
    insert_once(result.points, result.weights, insertion_shares(s, t), lines, !along_u);
    s = with_knot(s, t);
  }
  return result;
}

SplineFoot foot_near(const NurbsSurface& surface, const Vec3& p, double u, double v) {
  const double u0 = surface.u.low(), u1 = surface.u.high(), v0 = surface.v.low(), v1 = surface.v.high();
  const double edge_u = 1e-9 * (u1 - u0), edge_v = 1e-9 * (v1 - v0);
  u = std::clamp(u, u0, u1), v = std::clamp(v, v0, v1);
  SurfacePoint at = surface.derivatives(u, v);
  double best = (at.p - p).squaredNorm();
  for (int round = 0; round < 30; ++round) {
    const Vec3 r = at.p - p;
    const double gu = r.dot(at.du), gv = r.dot(at.dv);
    // What leads out of the domain is left out: the nearest place may lie on its border.
    const bool stuck_u = (u <= u0 + edge_u && gu > 0) || (u >= u1 - edge_u && gu < 0);
    const bool stuck_v = (v <= v0 + edge_v && gv > 0) || (v >= v1 - edge_v && gv < 0);
    if (stuck_u && stuck_v) break;
    const double first_uu = at.du.squaredNorm(), first_vv = at.dv.squaredNorm(), first_uv = at.du.dot(at.dv);
    double huu = first_uu + r.dot(at.duu), hvv = first_vv + r.dot(at.dvv), huv = first_uv + r.dot(at.duv);
    double du = 0, dv = 0;
    if (stuck_u || stuck_v) {
      if (!(huu > 1e-3 * first_uu)) huu = first_uu;
      if (!(hvv > 1e-3 * first_vv)) hvv = first_vv;
      (stuck_u ? dv : du) = stuck_u ? (hvv > 0 ? -gv / hvv : 0) : (huu > 0 ? -gu / huu : 0);
    } else {
      if (!(huu > 0 && hvv > 0 && huu * hvv - huv * huv > 1e-3 * first_uu * first_vv))
        huu = first_uu, hvv = first_vv, huv = first_uv;
      const double det = huu * hvv - huv * huv;
      if (!(det > 1e-14 * huu * hvv)) break;
      du = -(hvv * gu - huv * gv) / det, dv = -(huu * gv - huv * gu) / det;
    }
    bool nearer = false;
    for (double step = 1; step > 1e-3 && !nearer; step /= 4) {
      const double s = std::clamp(u + step * du, u0, u1), t = std::clamp(v + step * dv, v0, v1);
      const SurfacePoint next = surface.derivatives(s, t);
      const double d = (next.p - p).squaredNorm();
      if (!(d < best)) continue;
      nearer = true;
      const bool settled = best - d < 1e-14 * best;
      u = s, v = t, at = next, best = d;
      if (settled) return {u, v, std::sqrt(best), at.p};
    }
    if (!nearer) break;
  }
  return {u, v, std::sqrt(best), at.p};
}

template struct NurbsCurve<2>;
template struct NurbsCurve<3>;
template NurbsCurve<2> with_knot(const NurbsCurve<2>&, double, int);
template NurbsCurve<3> with_knot(const NurbsCurve<3>&, double, int);

}  // namespace partscribe::geometry
