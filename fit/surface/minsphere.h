/// Minspheres, distances and edge functions of single triangles in space.
#pragma once

#include <array>
#include <optional>

#include "geometry/vec.h"

namespace partscribe::fit {

/// The smallest sphere through three corners: its centre lies in their plane.
struct Minsphere {
  Vec3 centre = Vec3::Zero();
  double sq_radius = 0;  ///< mm^2; infinite if the corners lie on a line
  /// How deep a place lies inside: 1 at the centre, 0 on the sphere, negative outside.
  double depth(const Vec3& p) const { return 1 - (p - centre).squaredNorm() / sq_radius; }
  /// The sphere itself does not count, nor does what rounding adds to it: those of a square's halves hold nothing.
  bool holds(const Vec3& p) const { return depth(p) > 1e-9; }
};
Minsphere minsphere(const Vec3& a, const Vec3& b, const Vec3& c);

/// d(p, T), the least of |a1 p1 + a2 p2 + a3 p3 - p| over weights in [0, 1] whose sum is 1. mm.
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// The plane of a triangle T, and d_i, the signed distance within it from edge i, the one without corner i. Edges run
/// from the earlier corner to the later, so that d_1 is negative on the side of its corner.
struct EdgeFunctions {
  Vec3 normal = Vec3::Zero();       ///< unit, right-handed; zero if the corners lie on a line
  double offset = 0;                ///< normal . x on the plane
  std::array<Vec3, 3> across;       ///< unit
  std::array<double, 3> offsets{};  ///< across . x on the edge
  std::array<double, 3> corner{};   ///< d_i(p_i), computed once and stored

  double operator()(std::size_t i, const Vec3& v) const { return across[i].dot(v) - offsets[i]; }
};
EdgeFunctions edge_functions(const Vec3& a, const Vec3& b, const Vec3& c);

/// The printed test of interiority: 0 < d_i(q) < d_i(p_i) for i = 1..3 and the foot q of p on the plane, signs reversed
/// where d_i(p_i) < 0. It leaves out edges and corners, which belong to no triangle then: there d(p, T) has to answer,
/// whose minimum includes them.
bool projects_inside(const EdgeFunctions& edges, const Vec3& p);

/// Where a line meets a triangle's plane.
struct LineFoot {
  double t = 0;          ///< mm along the line
  double least = -1;     ///< the least d_i / d_i(p_i) there
  std::size_t edge = 0;  ///< and the edge i it belongs to: the farthest beyond
  /// Edges and corners belong to all their triangles, and rounding lets no line slip through between two.
  bool inside() const { return least >= -1e-9; }
};

/// The line p + t * direction (unit). Not inside if it runs along the plane.
LineFoot line_foot(const EdgeFunctions& edges, const Vec3& p, const Vec3& direction);

/// The distance from p to the triangle, edges included, along the surface's unit normal n at p, to either side; nothing
/// where the normal does not meet it.
std::optional<double> distance_along_normal(const EdgeFunctions& edges, const Vec3& p, const Vec3& n);

}  // namespace partscribe::fit
