/// The ellipse through points of a plane by direct least squares.
#pragma once

#include <optional>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// An ellipse of a plane, in the unit of its points.
struct PlaneEllipse {
  Vec2 center = Vec2::Zero();
  Vec2 direction = Vec2::UnitX();       ///< unit, of the longer half axis
  double longer = 0, shorter = 0;       ///< half axes
  double mean_radius() const;           ///< of the circle of equal area
  double off(const Vec2& point) const;  ///< distance along the ray from the centre; positive outside
};

/// The conic that makes the sum of its squared equation at the points least, among those that are ellipses
/// (Fitzgibbon, Pilu and Fisher, 1999; with the terms of first order eliminated beforehand, as Halir and Flusser,
/// 1998). Nothing if there are fewer than six points, or if they lie on a line or in a place. From noisy arcs much
/// shorter than half a turn it comes out too small, as is known of it.
std::optional<PlaneEllipse> fitted_ellipse(const std::vector<Vec2>& points);

}  // namespace partscribe::geometry
