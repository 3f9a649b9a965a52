#include "fit/sketch/profile.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/number.h"
#include "geometry/decompose.h"

namespace partscribe::fit {
namespace {

/// Weighted moments of a run of nodes about a common origin.
struct Moments {
  double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, zx = 0, zy = 0, zz = 0;  // z = x^2 + y^2
  Moments operator-(const Moments& o) const {
    return {w - o.w, x - o.x, y - o.y, xx - o.xx, xy - o.xy, yy - o.yy, zx - o.zx, zy - o.zy, zz - o.zz};
  }
  void add(double weight, const Vec2& p) {
    const double z = p.squaredNorm();
    w += weight, x += weight * p.x(), y += weight * p.y();
    xx += weight * p.x() * p.x(), xy += weight * p.x() * p.y(), yy += weight * p.y() * p.y();
    zx += weight * z * p.x(), zy += weight * z * p.y(), zz += weight * z * z;
  }
};

struct LineFit {
  double cost = 1e300;
  Vec2 point, direction;
};

LineFit line_fit(const Moments& m) {
  LineFit fit;
  if (m.w <= 0) return fit;
  const double mx = m.x / m.w, my = m.y / m.w;
  const double xx = m.xx - m.w * mx * mx, xy = m.xy - m.w * mx * my, yy = m.yy - m.w * my * my;
  const double mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy);
  fit.cost = std::max(mean - std::hypot(half, xy), 0.0);
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  fit.point = {mx, my};
  fit.direction = {std::cos(angle), std::sin(angle)};
  return fit;
}

struct ArcFit {
  double cost = 1e300;
  Vec2 center = Vec2::Zero();
  double radius = 0;
};

ArcFit arc_fit(const Moments& m) {
  ArcFit fit;
  if (m.w <= 0) return fit;
  // Centred moments of (u, v) and z' = u^2 + v^2 from those of (x, y).
  const double a = m.x / m.w, b = m.y / m.w;
  const double xx = m.xx - m.w * a * a, xy = m.xy - m.w * a * b, yy = m.yy - m.w * b * b;
  const double sz = m.xx + m.yy;
  // z' = z - 2 a x - 2 b y + (a^2 + b^2)
  const double c = a * a + b * b;
  const double z = sz - 2 * a * m.x - 2 * b * m.y + c * m.w;
  const double zx = m.zx - 2 * a * m.xx - 2 * b * m.xy + c * m.x, zy = m.zy - 2 * a * m.xy - 2 * b * m.yy + c * m.y;
  const double zu = zx - a * z, zv = zy - b * z;
  const double zz = m.zz - 4 * a * m.zx - 4 * b * m.zy + 2 * c * sz + 4 * a * a * m.xx + 8 * a * b * m.xy +
                    4 * b * b * m.yy - 4 * c * (a * m.x + b * m.y) + c * c * m.w;
  const double det = xx * yy - xy * xy;
  if (!(det > 1e-12 * (xx + yy) * (xx + yy))) return fit;
  const double p = 0.5 * (zu * yy - zv * xy) / det, q = 0.5 * (zv * xx - zu * xy) / det;
  const double mean_z = z / m.w;
  const double r2 = mean_z + p * p + q * q;
  const double residual = zz - m.w * mean_z * mean_z - 2 * (p * zu + q * zv);
  fit.cost = std::max(residual, 0.0) / (4 * r2);
  fit.center = {a + p, b + q};
  fit.radius = std::sqrt(r2);
  return fit;
}

/// Orthogonal refinement of a circle by Gauss-Newton.
void refine_arc(const std::vector<ChainNode>& nodes, std::size_t first, std::size_t last, double floor, ArcFit& fit) {
  for (int round = 0; round < 20; ++round) {
    Mat3 h = Mat3::Zero();
    Vec3 g = Vec3::Zero();
    for (std::size_t i = first; i <= last; ++i) {
      if (nodes[i].corner) continue;
      const Vec2 d = nodes[i].position - fit.center;
      const double rho = d.norm();
      if (rho <= 0) continue;
      const double w = 1 / (nodes[i].sigma * nodes[i].sigma + floor * floor);
      const Vec3 row(-d.x() / rho, -d.y() / rho, -1);
      h += w * row * row.transpose();
      g += w * (rho - fit.radius) * row;
    }
    h.diagonal() *= 1 + 1e-9;
    if (!(std::abs(h.determinant()) > 0)) return;
    const Vec3 step = -h.inverse() * g;
    if (!step.allFinite() || step.norm() > 2 * fit.radius) return;
    fit.center += step.head<2>();
    fit.radius += step.z();
    if (step.norm() < 1e-10 * (1 + std::abs(fit.radius))) return;
  }
}

double swept_angle(const std::vector<ChainNode>& nodes, std::size_t first, std::size_t last, const Vec2& center) {
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) {
    const Vec2 a = nodes[i].position - center, b = nodes[i + 1].position - center;
    sum += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return sum;
}

struct Piece {
  std::size_t first, last;
  bool arc;
};

// ---- splines ------------------------------------------------------------------------------------------------------

constexpr int degree = 3;

/// Clamped knots with the inner ones at even shares of `us`.
std::vector<double> knots_for(const std::vector<double>& us, std::size_t controls) {
  std::vector<double> knots(degree + 1, 0.0);
  const std::size_t inner = controls - degree - 1;
  for (std::size_t k = 1; k <= inner; ++k) knots.push_back(snapped(us[k * (us.size() - 1) / (inner + 1)], 1e-4));
  knots.insert(knots.end(), degree + 1, 1.0);
  return knots;
}

/// Least squares through the nodes with the fewest control points that stay within `tolerance`; parameters by chord
/// length, then corrected to the feet of the nodes.
std::optional<Nurbs2> spline_through(const std::vector<ChainNode>& nodes, std::size_t first, std::size_t last,
                                     double tolerance) {
  std::vector<Vec2> q;
  std::vector<double> w;
  for (std::size_t i = first; i <= last; ++i) {
    if (nodes[i].corner) continue;
    q.push_back(nodes[i].position);
    w.push_back(std::sqrt(nodes[i].weight));
  }
  if (q.size() < 8) return {};
  std::vector<double> start = {0.0};
  for (std::size_t i = 1; i < q.size(); ++i) start.push_back(start.back() + (q[i] - q[i - 1]).norm());
  for (auto& u : start) u /= start.back();
  for (std::size_t controls = 4; controls <= std::min<std::size_t>(40, q.size() / 2); ++controls) {
    std::vector<double> us = start;
    Nurbs2 curve;
    double worst = 0;
    for (int round = 0; round < 4; ++round) {
      curve.t = {degree, knots_for(us, controls)};
      Eigen::MatrixXd m =
          Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(controls), static_cast<Eigen::Index>(controls));
      Eigen::MatrixXd r = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(controls), 2);
      for (std::size_t i = 0; i < q.size(); ++i) {
        BasisValues n;
        basis(curve.t, us[i], 0, n);
        const double* b = n.value[0];
        for (int j = 0; j <= degree; ++j) {
          r.row(n.first + j) += w[i] * b[j] * q[i].transpose();
          for (int k = 0; k <= degree; ++k) m(n.first + j, n.first + k) += w[i] * b[j] * b[k];
        }
      }
      m.diagonal().array() += 1e-12 * m.trace();
      const Eigen::MatrixXd solution = solve_ldlt(m, r);
      curve.points.clear();
      for (Eigen::Index k = 0; k < solution.rows(); ++k) curve.points.emplace_back(solution(k, 0), solution(k, 1));
      worst = 0;
      for (std::size_t i = 0; i < q.size(); ++i) {
        Vec2 p, d1, d2;
        curve.derivatives(us[i], p, d1, d2);
        const double speed = d1.squaredNorm();
        if (speed > 0) us[i] = std::clamp(us[i] + d1.dot(q[i] - p) / speed, 0.0, 1.0);
        worst = std::max(worst, (q[i] - curve.at(us[i])).norm());
      }
      std::sort(us.begin(), us.end());
    }
    if (worst < tolerance) return curve;
  }
  return {};
}

Vec2 leaving(const ProfileSegment& s, bool at_end) {
  if (!s.arc) return s.direction;
  const Vec2 d = ((at_end ? s.end : s.start) - s.center).normalized();
  return s.sweep > 0 ? Vec2(-d.y(), d.x()) : Vec2(d.y(), -d.x());
}

/// Runs of pieces without a corner between them become splines.
std::vector<ProfileSegment> with_splines(const std::vector<ProfileSegment>& segments, const std::vector<Piece>& pieces,
                                         const std::vector<ChainNode>& nodes, double tolerance, double size) {
  std::vector<ProfileSegment> result;
  for (std::size_t i = 0; i < segments.size();) {
    std::size_t end = i + 1;
    // A long straight piece is an edge of its own.
    auto straight = [&](const ProfileSegment& s) { return !s.arc && s.length() > 0.15 * size; };
    while (end < segments.size() && !straight(segments[end - 1]) && !straight(segments[end]) &&
           leaving(segments[end - 1], true).dot(leaving(segments[end], false)) > 0.8)
      ++end;
    if (end - i >= 4) {
      if (const auto curve = spline_through(nodes, pieces[i].first, pieces[end - 1].last, tolerance)) {
        ProfileSegment s;
        s.spline = true;
        s.curve = *curve;
        s.start = curve->points.front(), s.end = curve->points.back();
        for (std::size_t k = i; k < end; ++k) s.points += segments[k].points, s.nodes += segments[k].nodes;
        result.push_back(s);
        i = end;
        continue;
      }
    }
    result.push_back(segments[i++]);
  }
  return result;
}

std::vector<Piece> split(const std::vector<ChainNode>& nodes, const ProfileOptions& o) {
  const std::size_t n = nodes.size();
  Vec2 origin = Vec2::Zero();
  for (const auto& node : nodes) origin += node.position / double(n);
  std::vector<Moments> sum(n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    sum[i + 1] = sum[i];
    // A corner's mean lies inside the corner: it belongs to neither side.
    const double w = nodes[i].corner ? 0 : 1 / (nodes[i].sigma * nodes[i].sigma + o.floor * o.floor);
    sum[i + 1].add(w, nodes[i].position - origin);
  }
  std::vector<double> along(n, 0.0);
  for (std::size_t i = 1; i < n; ++i) along[i] = along[i - 1] + (nodes[i].position - nodes[i - 1].position).norm();
  std::vector<double> best(n + 1, 1e300);
  std::vector<std::size_t> from(n + 1, 0);
  std::vector<char> is_arc(n + 1, 0);
  best[0] = 0;
  for (std::size_t j = 1; j <= n; ++j)
    for (std::size_t i = 0; i < j; ++i) {
      if (best[i] >= 1e300) continue;
      const Moments m = sum[j] - sum[i];
      if (j - i < 2 && n > 2) {
        // A single deviating node costs as much as an outlier, so that one bad node never leads to two segments.
        const double cost = best[i] + 0.75 * o.line_cost;
        if (cost < best[j]) best[j] = cost, from[j] = i, is_arc[j] = 2;
        continue;
      }
      const double line = best[i] + 0.5 * line_fit(m).cost + o.line_cost;
      if (line < best[j]) best[j] = line, from[j] = i, is_arc[j] = 0;
      if (j - i < 5 || best[i] + o.arc_cost >= best[j]) continue;
      const ArcFit arc = arc_fit(m);
      if (!(arc.radius > 0) || arc.radius > 4 * o.size) continue;
      const double cost = best[i] + 0.5 * arc.cost + o.arc_cost;
      if (cost >= best[j]) continue;
      const double sweep = (along[j - 1] - along[i]) / arc.radius;
      if (sweep < 0.15 || sweep > 6.6) continue;
      best[j] = cost, from[j] = i, is_arc[j] = 1;
    }
  std::vector<Piece> pieces;
  for (std::size_t j = n; j > 0; j = from[j])
    if (is_arc[j] != 2) pieces.push_back({from[j], j - 1, is_arc[j] == 1});
  std::reverse(pieces.begin(), pieces.end());
  return pieces;
}

}  // namespace

double ProfileSegment::length() const {
  if (!spline) return arc ? std::abs(sweep) * radius : (end - start).norm();
  const auto points = polyline(curve, 1e-2 * (end - start).norm() + 1e-6);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) sum += (points[i + 1] - points[i]).norm();
  return sum;
}

std::vector<ProfileSegment> segments_of(const Chain& chain, const ProfileOptions& o) {
  std::vector<ChainNode> nodes = chain.nodes;
  if (nodes.size() < 3) return {};
  if (chain.closed) {
    // One circle?
    Moments all;
    Vec2 origin = nodes[0].position;
    double w_sum = 0;
    for (const auto& node : nodes) {
      const double w = 1 / (node.sigma * node.sigma + o.floor * o.floor);
      all.add(w, node.position - origin), w_sum += w;
    }
    ArcFit circle = arc_fit(all);
    if (circle.radius > 0 && circle.cost < 2.0 * double(nodes.size()) + 2 * o.line_cost) {
      circle.center += origin;
      refine_arc(nodes, 0, nodes.size() - 1, o.floor, circle);
      ProfileSegment s;
      s.arc = true, s.center = circle.center, s.radius = circle.radius;
      const double turn = swept_angle(nodes, 0, nodes.size() - 1, circle.center);
      s.sweep = turn > 0 ? 2 * pi : -2 * pi;
      s.start = s.end = circle.center + Vec2(circle.radius, 0);
      s.nodes = nodes.size();
      for (const auto& node : nodes) s.points += node.weight;
      if (std::abs(std::abs(turn) - 2 * pi) < 1.5) return {s};
    }
    const auto pieces = split(nodes, o);
    if (pieces.size() > 1) {
      // Start again at a break in the middle, where the arbitrary start cannot have made one.
      const std::size_t at = pieces[pieces.size() / 2].first;
      std::rotate(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(at), nodes.end());
    }
  }
  std::vector<ProfileSegment> segments;
  std::vector<Piece> behind;
  for (const auto& piece : split(nodes, o)) {
    // A run that covers mostly corners carries no information.
    std::size_t good = 0;
    for (std::size_t i = piece.first; i <= piece.last; ++i) good += !nodes[i].corner;
    if (good < 2) continue;
    const std::size_t trim = piece.last - piece.first >= 6 ? 1 : 0;
    const std::size_t first = piece.first + trim, last = piece.last - trim;
    Moments m;
    const Vec2 origin = nodes[(first + last) / 2].position;
    ProfileSegment s;
    for (std::size_t i = first; i <= last; ++i)
      if (!nodes[i].corner)
        m.add(1 / (nodes[i].sigma * nodes[i].sigma + o.floor * o.floor), nodes[i].position - origin);
    for (std::size_t i = piece.first; i <= piece.last; ++i) s.points += nodes[i].weight;
    s.nodes = piece.last - piece.first + 1;
    const Vec2 a = nodes[piece.first].position, b = nodes[piece.last].position;
    if (piece.arc) {
      ArcFit fit = arc_fit(m);
      fit.center += origin;
      refine_arc(nodes, first, last, o.floor, fit);
      s.arc = true, s.center = fit.center, s.radius = fit.radius;
      s.sweep = swept_angle(nodes, piece.first, piece.last, fit.center);
      s.start = fit.center + (a - fit.center).normalized() * fit.radius;
      s.end = fit.center + (b - fit.center).normalized() * fit.radius;
    } else {
      const LineFit fit = line_fit(m);
      s.point = fit.point + origin;
      s.direction = fit.direction.dot(b - a) < 0 ? Vec2(-fit.direction) : fit.direction;
      s.start = s.point + s.direction * s.direction.dot(a - s.point);
      s.end = s.point + s.direction * s.direction.dot(b - s.point);
    }
    segments.push_back(s);
    behind.push_back(piece);
  }
  return o.spline > 0 ? with_splines(segments, behind, nodes, o.spline, o.size) : segments;
}

}  // namespace partscribe::fit
