/// Exact signed distances from a point to an ellipsoid, a tapered and bent superellipsoid and a supertoroid, negative
/// inside.
#pragma once

#include <array>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// Ellipsoid about the origin with half axes `radii` along x, y, z (mm, > 0). Exact to rounding everywhere,
/// symmetry planes, near-spheres, flat ones and far points included.
double ellipsoid_distance(const Vec3& p, const Vec3& radii);

/// Superellipsoid about the origin, equation (5) of the 1993 paper with x -> x (taper_x z / a3 + 1), y alike.
/// Half sizes in mm; exponents 0.1..2; |taper| <= 0.95. The foot point is found by Newton's method: for points
/// outside and points inside that are nearer to the surface than to the middle, this is the nearest one.
double superellipsoid_distance(const Vec3& p, double a1, double a2, double a3, double e1, double e2, double taper_x,
                               double taper_y);

/// Where a point goes when the z axis is bent into an arc of this curvature (1/mm, towards +x): (x, z) to
/// (1/k - (1/k - x) cos(k z), (1/k - x) sin(k z)). One to one where k x < 1 and |k z| < pi.
Vec3 bent(const Vec3& p, double curvature);

/// A superellipsoid as above that is then bent, by less than half a turn over a3 and with a radius above its half width
/// (model/solids.h). The foot is found by Newton's method from the nearest places of a grid over the surface.
class BentSuperellipsoid {
 public:
  BentSuperellipsoid(double a1, double a2, double a3, double e1, double e2, double taper_x, double taper_y,
                     double bend);
  double distance(const Vec3& p) const;
  const Box3& bounds() const { return bounds_; }

 private:
  struct Place {
    Vec3 straight, bent;  // in the octant of non-negative coordinates
  };
  bool inside(const Vec3& p) const;
  Vec3 half_, exponents_, tapers_;  // a1 a2 a3; 2 / e1, 2 / e2; taper_x, taper_y
  double curvature_;
  std::array<std::vector<Place>, 4> grids_;  // x below or above 0, z below or above 0
  Box3 bounds_;
};

/// The cheap stand-in: distance along the ray from the centre, q (1 - 1/N(q)) in the untapered space, negative inside.
double superellipsoid_radial_distance(const Vec3& p, double a1, double a2, double a3, double e1, double e2,
                                      double taper_x, double taper_y);

/// Supertoroid about z with its ring in z = 0: |(r - major) / minor|^(2/e1) + |z / half_height|^(2/e1) = 1 with
/// r = (|x|^(2/e2) + |y|^(2/e2))^(e2/2). Sizes in mm, minor < major; exponents 0.1..2. Newton's method from several
/// starts.
double supertoroid_distance(const Vec3& p, double major, double minor, double half_height, double e1, double e2);

}  // namespace partscribe::geometry
