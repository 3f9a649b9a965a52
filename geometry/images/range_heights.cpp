#include "geometry/images/range_heights.h"

#include <cmath>
#include <limits>

namespace partscribe::geometry {

RangeHeights::RangeHeights(const RangeImage& image)
    : pinhole(image.projection == Projection::pinhole),
      width(image.width),
      height_px(image.height),
      grid(image.width, image.height, std::numeric_limits<float>::quiet_NaN()),
      z0_(image.z0),
      q_(image.q),
      reference_(1),
      fx_(image.fx),
      fy_(image.fy),
      cx_(image.cx),
      cy_(image.cy),
      pitch_x_(image.pitch_x),
      pitch_y_(image.pitch_y) {
  const auto depth_of = [&](std::uint16_t code) { return z0_ + q_ * (static_cast<double>(code) - 1); };
  const auto usable = [&](std::uint16_t code) {
    return code != image.invalid_code && (!pinhole || depth_of(code) > 0);
  };
  double sum = 0;
  for (const std::uint16_t code : image.codes)
    if (usable(code)) {
      if (pinhole) sum += depth_of(code);
      ++returns;
    }
  if (returns > 0 && pinhole) reference_ = sum / static_cast<double>(returns);
  for (int r = 0; r < height_px; ++r) {
    const std::uint16_t* from = image.codes.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(width);
    float* to = grid.row(r);
    for (int c = 0; c < width; ++c)
      if (usable(from[c]))
        to[c] = pinhole ? static_cast<float>(height(depth_of(from[c]))) : static_cast<float>(from[c]);
  }
}

double RangeHeights::depth(double h) const {
  return pinhole ? reference_ / (1 - h * q_ / reference_) : z0_ + q_ * (h - 1);
}

double RangeHeights::height(double z) const {
  return pinhole ? reference_ / q_ * (1 - reference_ / z) : 1 + (z - z0_) / q_;
}

double RangeHeights::mm_per_height(double h) const {
  if (!pinhole) return q_;
  const double ratio = depth(h) / reference_;
  return q_ * ratio * ratio;
}

Vec3 RangeHeights::gradient(int row, int column, double h, double slope_x, double slope_y) const {
  if (!pinhole) return {slope_x * q_ / pitch_x_, slope_y * q_ / pitch_y_, -1};
  const double per_height = -q_ / (reference_ * reference_);  // of the inverse depth
  const double a = per_height * slope_x * fx_, b = per_height * slope_y * fy_, inverse = 1 / depth(h);
  const Vec3 v = ray(row, column);
  return -Vec3(a, b, inverse - a * v.x() - b * v.y()) / inverse;
}

Vec3 RangeHeights::ray(int row, int column) const {
  return pinhole ? Vec3((column - cx_) / fx_, (row - cy_) / fy_, 1) : Vec3(0, 0, 1);
}

double RangeHeights::incidence(int row, int column, double h, double slope_x, double slope_y) const {
  const double sq_length = gradient(row, column, h, slope_x, slope_y).squaredNorm();
  const Vec3 v = ray(row, column);
  return sq_length * (v.x() * v.x() + v.y() * v.y() + 1);  // gradient . ray = -1
}

Tilt RangeHeights::tilt(int row, int column, double h, double slope_x, double slope_y) const {
  const Vec3 g = gradient(row, column, h, slope_x, slope_y);
  const Vec3 v = ray(row, column);
  const double sq_length = v.squaredNorm();
  const Vec3 across = g + v / sq_length;  // gradient . ray = -1
  const double in_image = across.head<2>().norm();
  if (!(in_image > 1e-9)) return {};
  const double sq_tangent = across.squaredNorm() * sq_length;
  return {static_cast<float>(across.x() / in_image), static_cast<float>(across.y() / in_image),
          static_cast<float>(std::sqrt(sq_tangent)), static_cast<float>(std::sqrt(1 + sq_tangent))};
}

double RangeHeights::pixels_per_height(double h) const {
  const double pixel = pinhole ? depth(h) / std::sqrt(fx_ * fy_) : std::sqrt(pitch_x_ * pitch_y_);
  return mm_per_height(h) / pixel;
}

Vec3 RangeHeights::normal(int row, int column, double h, double slope_x, double slope_y) const {
  return gradient(row, column, h, slope_x, slope_y).normalized();
}

}  // namespace partscribe::geometry
