/// Single evaluated solids, each in its own frame: exact distances, and the nearest point of every face.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/vec.h"
#include "model/shapes.h"

namespace partscribe::model {

/// The nearest place on a solid.
struct LocalHit {
  double distance;  ///< mm; negative inside
  int face;         ///< index into Solid::faces
};

/// The nearest point of one face, its border included.
struct Foot {
  double distance = 0;  ///< mm, >= 0
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< of the face, unit length, either way
};

/// The nearest point of a plane convex polygon, whose corners run counter-clockwise seen along its unit normal.
Foot foot_on_polygon(std::span<const Vec3> corners, const Vec3& normal, const Vec3& p);

class Solid {
 public:
  virtual ~Solid() = default;
  virtual LocalHit hit(const Vec3& p) const = 0;
  /// Infinitely far (1e300) for a face that bounds nothing.
  virtual Foot foot(const Vec3& p, int face) const = 0;
  std::vector<std::string> faces;  ///< their names
  Box3 bounds;                     ///< holds the solid
};

/// Nothing for booleans, which have no surface of their own. Features have to be lowered before.
std::unique_ptr<Solid> make_solid(const EvaluatedShape& shape);

}  // namespace partscribe::model
