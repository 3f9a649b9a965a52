/// A grid of range codes as a scanner delivers it, and how a code becomes a point.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

enum class Projection { orthographic, pinhole };

/// Codes are stored row by row; `invalid_code` means no return.
/// Depth z = z0 + q * (code - 1). Pinhole: x = (column - cx) / fx * z, y = (row - cy) / fy * z.
/// Orthographic: x = x0 + column * pitch_x, y = y0 + row * pitch_y.
struct RangeImage {
  int width = 0, height = 0;
  std::vector<std::uint16_t> codes;
  std::uint16_t invalid_code = 0;
  Projection projection = Projection::orthographic;
  double z0 = 0, q = 1;                             ///< mm at code 1, mm per code
  double fx = 1, fy = 1, cx = 0, cy = 0;            ///< pinhole, pixels
  double x0 = 0, y0 = 0, pitch_x = 1, pitch_y = 1;  ///< orthographic, mm
  Pose world_from_view;                             ///< the sensor looks along +z of its own frame
};

/// The point of a pixel in the sensor's frame; nothing where there was no return.
std::optional<Vec3> view_point(const RangeImage& image, int row, int column);

}  // namespace partscribe::geometry
