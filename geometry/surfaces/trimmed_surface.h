/// B-spline surfaces that closed curves in their parameter planes bound, alone or joined along common edges.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"
#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// One piece of a border, in the parameter plane (u, v).
struct SurfaceTrim {
  NurbsCurve<2> curve;
  /// Curves of one edge are one curve in space: that of the second surface runs against that of the first, and equal
  /// shares of their parameters' domains, from either end, are equal places. An edge of one curve alone is a rim.
  int edge = 0;
};

/// What lies to the left of all loops: the outer one runs counter-clockwise, the others, round holes, clockwise. Each
/// curve begins where the one before ends.
struct TrimmedSurface {
  NurbsSurface surface;
  std::vector<std::vector<SurfaceTrim>> loops;
};

/// The same surface with its front where its back was: u runs the other way, and so do the loops.
TrimmedSurface turned_over(const TrimmedSurface& surface);

/// Which ends of edges are one place: those that a loop passes from one of its curves to the next.
class EdgeEnds {
 public:
  explicit EdgeEnds(std::span<const TrimmedSurface> surfaces);
  /// A number of the place where an edge begins, or ends (`last`), as its first curve runs.
  int place(int edge, bool last) const { return places_.at({edge, last}); }

 private:
  std::map<std::pair<int, bool>, int> places_;
};

/// Triangles of several trimmed surfaces; along common edges they have the same corners.
struct SurfaceTriangles {
  TriangleMesh mesh;                       ///< fronts are where du x dv points
  std::vector<std::uint32_t> patch;        ///< of each triangle
  std::vector<std::array<Vec2, 3>> place;  ///< (u, v) of its corners on that surface
  double deviation = 0;  ///< mm, the largest distance that was seen between a triangle and its surface
};

/// Corners lie on the surfaces, triangles within about `deviation` mm of them. No triangles where loops do not close.
SurfaceTriangles triangulated(std::span<const TrimmedSurface> surfaces, double deviation);

/// Distances to trimmed surfaces. Queries may run on many threads.
class SurfaceDistance {
 public:
  /// Distances are exact, but for far points that two places are nearly as near to: they are off by `deviation`, mm, at
  /// most.
  /// `closed`: the surfaces bound a body, and what lies in it is at negative distances; else what lies behind them is.
  SurfaceDistance(std::vector<TrimmedSurface> surfaces, double deviation, bool closed);
  ~SurfaceDistance();

  struct Hit {
    double distance = 0;  ///< mm
    std::uint32_t patch = 0;
    Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();
  };
  Hit operator()(const Vec3& p) const;
  /// The nearest place of one of the surfaces, at a distance of 0 or more.
  Hit on(std::uint32_t patch, const Vec3& p) const;
  Box3 bounds() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace partscribe::geometry
