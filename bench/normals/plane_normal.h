/// The normal of the plane through some points, the same for all who bring their own neighbours.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/vec.h"

namespace peers {

/// Unit direction of least spread of `count` points; `point(k)` gives each, best relative to one of them. Closed form:
/// the least eigenvalue by its cosine, the direction as the longest product of two rows.
template <class Point>
inline partscribe::geometry::Vec3 plane_normal(std::size_t count, const Point& point) {
  double sx = 0, sy = 0, sz = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const partscribe::geometry::Vec3 d = point(k);
    sx += d.x(), sy += d.y(), sz += d.z();
    xx += d.x() * d.x(), xy += d.x() * d.y(), xz += d.x() * d.z();
    yy += d.y() * d.y(), yz += d.y() * d.z(), zz += d.z() * d.z();
  }
  const double n = double(count);
  xx -= sx * sx / n, xy -= sx * sy / n, xz -= sx * sz / n, yy -= sy * sy / n, yz -= sy * sz / n, zz -= sz * sz / n;
  const double mean = (xx + yy + zz) / 3, a = xx - mean, b = yy - mean, c = zz - mean;
  const double off = xy * xy + xz * xz + yz * yz;
  const double p = std::sqrt((a * a + b * b + c * c + 2 * off) / 6);
  if (!(p > 0)) return {0, 0, 1};
  const double half = (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)) / (2 * p * p * p);
  const double least = mean + 2 * p * std::cos(std::acos(std::clamp(half, -1.0, 1.0)) / 3 + 2.0943951023931953);
  const partscribe::geometry::Vec3 x(xx - least, xy, xz), y(xy, yy - least, yz), z(xz, yz, zz - least);
  const partscribe::geometry::Vec3 candidates[3] = {x.cross(y), x.cross(z), y.cross(z)};
  const double squares[3] = {candidates[0].squaredNorm(), candidates[1].squaredNorm(), candidates[2].squaredNorm()};
  const std::size_t best =
      squares[0] >= squares[1] ? (squares[0] >= squares[2] ? 0 : 2) : (squares[1] >= squares[2] ? 1 : 2);
  if (!(squares[best] > 0)) return {0, 0, 1};
  return candidates[best] / std::sqrt(squares[best]);
}

}  // namespace peers
