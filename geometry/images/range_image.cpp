#include "geometry/images/range_image.h"

namespace partscribe::geometry {

std::optional<Vec3> view_point(const RangeImage& image, int row, int column) {
  const auto code = image.codes[static_cast<std::size_t>(row) * image.width + column];
  if (code == image.invalid_code) return {};
  const double z = image.z0 + image.q * (static_cast<double>(code) - 1);
  if (image.projection == Projection::pinhole)
    return Vec3((column - image.cx) / image.fx * z, (row - image.cy) / image.fy * z, z);
  return Vec3(image.x0 + column * image.pitch_x, image.y0 + row * image.pitch_y, z);
}

}  // namespace partscribe::geometry
