#include "fit/surface/minsphere.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/mesh/bounded_mesh.h"

namespace partscribe::fit {

Minsphere minsphere(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a, w = u.cross(v);
  const double sq = w.squaredNorm();
  if (!(sq > 0)) return {a, std::numeric_limits<double>::infinity()};
  const Vec3 to_centre = (u.squaredNorm() * v.cross(w) + v.squaredNorm() * w.cross(u)) / (2 * sq);
  return {a + to_centre, to_centre.squaredNorm()};
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  return (geometry::closest_on_triangle(p, a, b, c) - p).norm();
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
