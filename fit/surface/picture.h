/// Finds the place or the direction from which a cloud could have been seen in one picture.
#pragma once

#include <optional>
#include <vector>

#include "geometry/points/point_cloud.h"

namespace partscribe::fit {

/// How places in space become places in the picture. z is depth, away from the sensor; straight lines stay straight.
struct Projection {
  Mat3 rotation = Mat3::Identity();  // rows: right, down, away
  Vec3 origin = Vec3::Zero();
  double distance = 0;  // mm at which the picture has its true scale; 0: parallel rays

  Vec3 operator()(const Vec3& p) const {
    Vec3 q = rotation * (p - origin);
    if (distance > 0) q.head<2>() *= distance / q.z();
    return q;
  }

  /// Unit, away from the sensor.
  Vec3 ray_to(const Vec3& p) const {
    return distance > 0 ? Vec3((p - origin).normalized()) : Vec3(rotation.row(2).transpose());
  }
};

/// Usable points of a cloud in an order that depends on the coordinates only.
struct Samples {
  std::vector<Vec3> points, normals, rays;  // rays: empty or as points
};

/// A projection in which at most the share `max_hidden` of the points lies clearly behind other points. Tried are, in
/// this order, the sensor of the only view, the point where the rays meet, the direction of the rays, the frame's
/// origin, the main direction of the normals, and the axes; the first good one is taken, or else the best. `oriented`:
/// the sign of the normals is known, and they must face the sensor.
std::optional<Projection> find_projection(const Samples& s, const std::vector<View>& views, double spacing,
                                          double max_hidden, bool oriented);

}  // namespace partscribe::fit
