#include "geometry/vec.h"

#include <cmath>

namespace partscribe::geometry {

Mat3 rotation_of(const Vec3& v) {
  const double angle = v.norm();
  Mat3 k;
  k << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  // Rodrigues; the series keeps full accuracy for the tiny steps of a converging fit.
  const double a = angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  const double half = angle / 2;
  const double s = angle < 1e-4 ? 0.5 * (1 - angle * angle / 24) : std::sin(half) / angle;
  const double b = angle < 1e-4 ? 0.5 - angle * angle / 24 : 2 * s * s;
  return Mat3::Identity() + a * k + b * (k * k);
}

Mat3 rotation_from_euler(const Vec3& a) {
  const double cx = std::cos(a.x()), sx = std::sin(a.x()), cy = std::cos(a.y()), sy = std::sin(a.y()),
               cz = std::cos(a.z()), sz = std::sin(a.z());
  Mat3 r;
  r << cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx,  //
      sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx,   //
      -sy, cy * sx, cy * cx;
  return r;
}

Vec3 euler_from_rotation(const Mat3& r) {
  const double cy = std::hypot(r(0, 0), r(1, 0));
  const double y = std::atan2(-r(2, 0), cy);
  if (cy < 1e-12) return {std::atan2(-r(1, 2), r(1, 1)), y, 0};  // only x +- z is defined: z = 0
  return {std::atan2(r(2, 1), r(2, 2)), y, std::atan2(r(1, 0), r(0, 0))};
}

Mat3 rotation_onto_axis(const Vec3& axis) {
  // The shortest turn from z; the antipode turns about x.
  const Vec3 z = axis.normalized();
  const double c = z.z();
  if (c < -1 + 1e-12) return Vec3(1, -1, -1).asDiagonal();
  const double k = 1 / (1 + c);
  Mat3 r;
  r << 1 - z.x() * z.x() * k, -z.x() * z.y() * k, z.x(),  //
      -z.x() * z.y() * k, 1 - z.y() * z.y() * k, z.y(),   //
      -z.x(), -z.y(), c;
  return r;
}

}  // namespace partscribe::geometry
