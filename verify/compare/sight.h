/// What the sensors looked through: one depth map per view, made from the points themselves.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/points/point_cloud.h"

namespace partscribe::verify {

/// The nearest depth in every cell of one view's image plane.
struct SightMap {
  Pose view_from_world;   ///< the view looks along its z axis
  bool parallel = false;  ///< orthographic; otherwise all rays start at the view's origin
  std::int32_t view = 0;  ///< its number among the scan's views
  double pitch = 1;       ///< between neighbouring rays: mm (parallel) or tangent of an angle
  double cell = 1;        ///< as pitch, of the map
  double x0 = 0, y0 = 0;
  int width = 0, height = 0;
  std::vector<float> depth;  ///< row by row; infinite where no ray returned
};

/// Maps of all views whose rays are known and start in one place or run parallel, within 70 degrees of their mean;
/// other views give no evidence. `kept` lists the points to use.
std::vector<SightMap> sight_maps(const PointCloud& cloud, const std::vector<View>& views,
                                 const std::vector<std::uint32_t>& kept);

/// How a view looks at a place.
struct Sight {
  Vec3 to_sensor;               ///< unit
  double length = 0;            ///< mm to the sensor; infinite where rays run parallel
  double depth = 0;             ///< mm, of the place
  std::array<float, 9> around;  ///< depths in the 3 x 3 cells around it, mm
};

/// Nothing where the view's picture does not reach.
std::optional<Sight> sight_of(const SightMap& map, const Vec3& place);

/// Where the view's sensor lies as seen from `place`, if the view returned nothing from there (the whole 3 x 3
/// neighbourhood of cells is empty) though its picture reaches it and it faces the place at less than 60 degrees: a
/// unit vector. Nothing otherwise.
std::optional<Vec3> unanswered_from(const SightMap& map, const Vec3& place, const Vec3& normal);

/// True if a view saw farther than `place` + `margin` in the whole 3 x 3 neighbourhood of cells around it (at least 7
/// of them with a return): so there is nothing at `place`. Surface seen at more than 75 degrees from its normal is
/// never contradicted: sensors lose such surface and see what is behind it.
bool seen_through(const SightMap& map, const Vec3& place, const Vec3& normal, double margin);

}  // namespace partscribe::verify
