/// Surfaces z = f(x, y) that are known exactly, and the distance to them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "geometry/vec.h"

namespace bench {

using partscribe::geometry::Vec2;
using partscribe::geometry::Vec3;

/// Height and its derivatives.
struct Height {
  double z = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

/// A smooth part of a field, where `side . (x, y) <= end`; a `side` of zero: everywhere.
struct FieldPiece {
  std::function<Height(double x, double y)> height;
  Vec2 side = Vec2::Zero();
  double end = 0;
};

struct Field {
  std::string name;
  std::vector<FieldPiece> pieces;
  double height(double x, double y) const;
  /// From a point to the nearest of the surface, which goes on beyond its rectangle, mm. Exact for points much nearer
  /// than the surface bends.
  double distance(const Vec3& point) const;
};

/// All fields stand over [0, 80] x [0, 60].
inline const Vec2 field_size(80, 60);

/// Smooth; bumps of 3 to 10 mm on a wave; a crease along x = 30; a crease along x + y = 70.
std::vector<Field> fields();

}  // namespace bench
