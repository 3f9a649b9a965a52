#include "geometry/mesh/surface_walk.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace partscribe::geometry {

SurfaceWalk::SurfaceWalk(const TriangleMesh& mesh) : mesh_(mesh), across_(mesh_neighbours(mesh)) {
  normals_.reserve(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) normals_.push_back(triangle_normal(mesh, t));
}

SurfacePlace SurfaceWalk::inside(std::uint32_t t, const Vec3& p) const {
  const Vec3 middle = (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2)) / 3;
  return {t, p + 1e-6 * (middle - p)};
}

Walk SurfaceWalk::along(const Vec3& a, const SurfacePlace& from, const Vec3& b, const SurfacePlace& to,
                        double bound) const {
  if (from.triangle == to.triangle) return Walk::within;
  const Vec3 way = to.point - from.point, segment = b - a;
  const Vec3 aside = way.cross(normals_[from.triangle] + normals_[to.triangle]);
  const double sq_bound = bound * bound, scale = 1 / segment.squaredNorm();
  const auto side = [&](std::uint32_t v) { return aside.dot(mesh_.vertices[v] - from.point); };
  // Where the edge between two corners, on either side of the plane, meets it.
  const auto crossing = [&](std::uint32_t v, double side_v, std::uint32_t w, double side_w) {
    return Vec3(mesh_.vertices[v] + (side_v / (side_v - side_w)) * (mesh_.vertices[w] - mesh_.vertices[v]));
  };
  std::uint32_t t = from.triangle;
  int leave = -1;  // the edge to cross next
  Vec3 at = from.point;
  double sides[3];
  for (int k = 0; k < 3; ++k) sides[k] = side(mesh_.triangles[t][k]);
  double ahead = 0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    if ((sides[k] >= 0) == (sides[l] >= 0)) continue;
    const Vec3 place = crossing(mesh_.triangles[t][k], sides[k], mesh_.triangles[t][l], sides[l]);
    if (leave < 0 || (place - from.point).dot(way) > ahead)
      leave = k, at = place, ahead = (place - from.point).dot(way);
  }
  if (leave < 0) return Walk::beyond;
  const double end = way.squaredNorm();
  for (std::uint32_t v = mesh_.triangles[t][leave], w = mesh_.triangles[t][(leave + 1) % 3];;) {
    // From v to w the edge is crossed, v is on the left as seen from t.
    const double share = std::clamp((at - a).dot(segment) * scale, 0.0, 1.0);
    if ((at - a - share * segment).squaredNorm() > sq_bound) return Walk::beyond;
    const std::uint32_t next = across_[t][leave];
    if (next == to.triangle) return Walk::within;
    if (next == no_neighbour) return Walk::ended;
    // Round in a circle, or past the end.
    if (next == from.triangle || (at - from.point).dot(way) > end) return Walk::beyond;
    const auto& corners = mesh_.triangles[next];
    int k = 0;
    while (corners[k] == v || corners[k] == w) ++k;
    const std::uint32_t tip = corners[k];
    const double side_tip = side(tip), side_v = side(v), side_w = side(w);
    // The corner between v and the tip, or between the tip and w.
    if ((side_tip >= 0) == (side_v >= 0)) {
      v = tip;
      at = crossing(tip, side_tip, w, side_w);
    } else {
      w = tip;
      at = crossing(v, side_v, tip, side_tip);
    }
    for (leave = 0; leave < 3; ++leave) {
      const std::uint32_t x = corners[leave], y = corners[(leave + 1) % 3];
      if ((x == v && y == w) || (x == w && y == v)) break;
    }
    t = next;
  }
}

}  // namespace partscribe::geometry
