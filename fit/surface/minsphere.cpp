#include "fit/surface/minsphere.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace partscribe::fit {

Minsphere minsphere(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a, w = u.cross(v);
  const double sq = w.squaredNorm();
  if (!(sq > 0)) return {a, std::numeric_limits<double>::infinity()};
  const Vec3 to_centre = (u.squaredNorm() * v.cross(w) + v.squaredNorm() * w.cross(u)) / (2 * sq);
  return {a + to_centre, to_centre.squaredNorm()};
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  const double sq = n.squaredNorm();
  if (sq > 0) {
    const double a1 = n.dot((b - p).cross(c - p)), a2 = n.dot((c - p).cross(a - p)), a3 = n.dot((a - p).cross(b - p));
    if (a1 >= 0 && a2 >= 0 && a3 >= 0) return std::abs(n.dot(p - a)) / std::sqrt(sq);
  }
  // One weight is zero.
  const auto to_edge = [&](const Vec3& from, const Vec3& to) {
    const Vec3 along = to - from;
    const double length = along.squaredNorm();
    const double t = length > 0 ? std::clamp(along.dot(p - from) / length, 0.0, 1.0) : 0;
    return (from + t * along - p).squaredNorm();
  };
  return std::sqrt(std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)}));
}

EdgeFunctions edge_functions(const Vec3& a, const Vec3& b, const Vec3& c) {
  EdgeFunctions e;
  e.across.fill(Vec3::Zero());
  const Vec3 n = (b - a).cross(c - a);
  const double size = n.norm();
  if (!(size > 0)) return e;
  e.normal = n / size;
  e.offset = e.normal.dot(a);
  const std::array<const Vec3*, 3> from = {&b, &a, &a}, to = {&c, &c, &b}, own = {&a, &b, &c};
  for (std::size_t i = 0; i < 3; ++i) {
    e.across[i] = e.normal.cross(*to[i] - *from[i]).normalized();
    e.offsets[i] = e.across[i].dot(*from[i]);
    e.corner[i] = e.across[i].dot(*own[i]) - e.offsets[i];
  }
  return e;
}

bool projects_inside(const EdgeFunctions& edges, const Vec3& p) {
  const Vec3 foot = p - (edges.normal.dot(p) - edges.offset) * edges.normal;
  for (std::size_t i = 0; i < 3; ++i) {
    const double d = edges(i, foot), most = edges.corner[i];
    if (most > 0 ? !(0 < d && d < most) : !(most < d && d < 0)) return false;
  }
  return true;
}

LineFoot line_foot(const EdgeFunctions& edges, const Vec3& p, const Vec3& direction) {
  LineFoot foot;
  const double slope = edges.normal.dot(direction);
  if (!(std::abs(slope) > 1e-12)) return foot;
  foot.t = (edges.offset - edges.normal.dot(p)) / slope;
  const Vec3 q = p + foot.t * direction;
  foot.least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i)
    if (const double share = edges(i, q) / edges.corner[i]; share < foot.least) foot.least = share, foot.edge = i;
  return foot;
}

std::optional<double> distance_along_normal(const EdgeFunctions& edges, const Vec3& p, const Vec3& n) {
  const LineFoot foot = line_foot(edges, p, n);
  if (!foot.inside()) return std::nullopt;
  return std::abs(foot.t);
}

}  // namespace partscribe::fit
