/// A measured part made by hand: a plate with two holes and a countersink, each number of it known.
#pragma once

#include <cmath>

#include "cli/measure/measured_part.h"
#include "core/number.h"

namespace partscribe::testing {

using namespace cli;

inline Face plane_face(const Vec3& middle, const Vec3& normal, double area) {
  Face face;
  face.kind = FaceKind::plane;
  face.fit.primitive.kind = PrimitiveKind::plane;
  face.fit.primitive.point = face.middle = middle;
  face.fit.primitive.axis = normal;
  face.fit.rms = 0.01, face.fit.sigma_point = 0.0004, face.fit.sigma_axis = radians(0.01);
  face.area = area, face.points = 900;
  return face;
}

/// About an axis along z, from z = `low` to `high`, all around.
inline Face round_face(FaceKind kind, const Vec3& middle, double radius, double length, bool hollow) {
  Face face = plane_face(middle, Vec3::UnitZ(), 2 * pi * radius * length);
  face.kind = kind;
  face.fit.primitive.kind = kind == FaceKind::cone ? PrimitiveKind::cone : PrimitiveKind::cylinder;
  face.fit.primitive.radius = radius;
  face.fit.sigma_radius = 0.0021;
  face.hollow = hollow, face.low = -length / 2, face.high = length / 2, face.arc = 2 * pi;
  return face;
}

/// 80 x 60 x 10 mm: 1 and 2 are the large faces, 3 and 4 the holes of 6 mm, 5 a countersink, 6 free form.
inline MeasuredPart measured_plate() {
  MeasuredPart part;
  part.tolerance = 0.1;
  auto& faces = part.faces.faces;
  faces = {plane_face({40, 30, 0}, {0, 0, -1}, 4700),
           plane_face({40, 30, 10}, {0, 0, 1}, 4690),
           round_face(FaceKind::cylinder, {12, 30, 5}, 3.0021, 10, true),
           round_face(FaceKind::cylinder, {68, 30, 5}, 2.9987, 10, true),
           round_face(FaceKind::cone, {68, 30, 9}, 4, 2, true),
           Face()};
  faces[4].fit.primitive.half_angle = radians(45), faces[4].fit.sigma_half_angle = radians(0.2);
  faces[5].area = 30, faces[5].middle = {1, 2, 3}, faces[5].complete = false;
  faces[0].neighbours = {{2, EdgeKind::convex, pi / 2, 18.85}, {3, EdgeKind::convex, pi / 2, 18.84}};
  faces[3].neighbours = {{0, EdgeKind::convex, pi / 2, 18.84}, {4, EdgeKind::concave, pi / 4, 18.84}};
  part.faces.noise = 0.0098;
  part.plane_sizes.assign(faces.size(), Vec2::Zero());
  part.plane_sizes[0] = part.plane_sizes[1] = {80, 60};
  using Size = decltype(SimpleFeature::dimensions)::value_type;
  part.features = {
      {"hole 1", "through hole", {2}, {{"diameter", Size::Quantity::length, 6.0042, 0.0042}}},
      {"hole 2",
       "countersunk hole",
       {3, 4},
       {{"diameter", Size::Quantity::length, 5.9974, 0.0042}, {"angle", Size::Quantity::angle, pi / 2, radians(0.4)}}},
      {"row of holes 1", "row of holes", {2, 3, 4}, {{"count", Size::Quantity::count, 2, 0}}}};
  part.relations = {{RelationKind::parallel, 0, 1, radians(0.004), radians(0.01), 0.4, true},
                    {RelationKind::parallel, 1, 2, radians(0.02), radians(0.05), 0.4, true},
                    {RelationKind::coaxial, 3, 4, 0.0021, 0.003, 0.7, true},
                    {RelationKind::equal_radius, 2, 3, 0.0034, 0.003, 1.1, true},
                    {RelationKind::parallel, 2, 3, radians(0.35), radians(0.04), 8.75, false}};
  part.unclassified = {{12.5, {79, 1, 10}, "no plane, cylinder, cone, sphere or torus describes it"}};
  return part;
}

}  // namespace partscribe::testing
