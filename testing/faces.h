/// Faces made by hand, as if they had been found on a part.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/number.h"
#include "geometry/segment/simple_features.h"

namespace partscribe::testing {

using namespace geometry;

/// Puts faces together one by one; they keep the order in which they came.
class FacesByHand {
 public:
  Faces faces;

  std::uint32_t plane(const Vec3& middle, const Vec3& normal, double area, double sigma = 0.001) {
    Face face = started(FaceKind::plane, middle, normal, area, sigma);
    face.middle = middle;
    return added(face);
  }

  /// From `middle` half of `length` both ways along the axis.
  std::uint32_t cylinder(const Vec3& middle, const Vec3& axis, double radius, double length, bool hollow,
                         double arc = 2 * pi, double sigma = 0.001) {
    Face face = started(FaceKind::cylinder, middle, axis, arc * radius * length, sigma);
    face.fit.primitive.radius = radius, face.fit.sigma_radius = sigma;
    face.hollow = hollow, face.arc = arc, face.coverage = arc / (2 * pi);
    face.low = -length / 2, face.high = length / 2;
    face.middle = middle + (arc < 2 * pi ? Vec3(radius * rotation_onto_axis(axis).col(0)) : Vec3::Zero());
    return added(face);
  }

  std::uint32_t sphere(const Vec3& centre, double radius, bool hollow, double area, double sigma = 0.001) {
    Face face = started(FaceKind::sphere, centre, Vec3::UnitZ(), area, sigma);
    face.fit.primitive.radius = radius, face.fit.sigma_radius = sigma, face.hollow = hollow;
    return added(face);
  }

  void meet(std::uint32_t a, std::uint32_t b, EdgeKind edge, double length, double angle = 0.5 * pi) {
    if (edge == EdgeKind::tangent) angle = 0;
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, a}}) {
      auto& neighbours = faces.faces[from].neighbours;
      neighbours.push_back({to, edge, angle, length});
      std::sort(neighbours.begin(), neighbours.end(), [](const auto& p, const auto& q) { return p.face < q.face; });
    }
  }

 private:
  std::uint32_t added(const Face& face) {
    faces.faces.push_back(face);
    return static_cast<std::uint32_t>(faces.faces.size() - 1);
  }

  static Face started(FaceKind kind, const Vec3& point, const Vec3& axis, double area, double sigma) {
    Face face;
    face.kind = kind;
    Primitive& p = face.fit.primitive;
    p.kind = kind == FaceKind::plane    ? PrimitiveKind::plane
             : kind == FaceKind::sphere ? PrimitiveKind::sphere
                                        : PrimitiveKind::cylinder;
    p.point = point, p.axis = axis.normalized();
    face.fit.sigma_point = sigma;
    if (kind != FaceKind::sphere) face.fit.sigma_axis = sigma / std::sqrt(area);
    face.fit.converged = true;
    face.area = area, face.points = 1000, face.middle = point;
    return face;
  }
};

/// A plate, bottom in z = 0, with what is drilled through it; its sides are missing.
class DrilledPlate : public FacesByHand {
 public:
  DrilledPlate(double size, double given_thickness)
      : thickness(given_thickness),
        top(plane({0, 0, thickness}, Vec3::UnitZ(), size * size)),
        bottom(plane({0, 0, 0}, -Vec3::UnitZ(), size * size)) {}

  double thickness;
  std::uint32_t top, bottom;

  std::uint32_t drill(double x, double y, double radius, double sigma = 0.001) {
    const auto wall = cylinder({x, y, thickness / 2}, Vec3::UnitZ(), radius, thickness, true, 2 * pi, sigma);
    meet(wall, top, EdgeKind::convex, 2 * pi * radius), meet(wall, bottom, EdgeKind::convex, 2 * pi * radius);
    return wall;
  }
};

}  // namespace partscribe::testing
