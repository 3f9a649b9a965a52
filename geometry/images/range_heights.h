/// The codes of a range image as heights in which a plane of the part is a plane of the image.
#pragma once

#include "geometry/images/bent_surface.h"
#include "geometry/images/padded_grid.h"
#include "geometry/images/range_image.h"

namespace partscribe::geometry {

/// Orthographic: the codes themselves. Pinhole: inverse depth, which is linear in the pixel on a plane (1 / z = A X +
/// B Y + C), turned and scaled to steps of about one code. Missing: NaN.
struct RangeHeights {
  explicit RangeHeights(const RangeImage& image);

  double depth(double height) const;  ///< mm along the optical axis
  double height(double depth) const;
  double mm_per_height(double height) const;  ///< derivative of the depth
  /// 1 / cos^2 of the angle between ray and normal for a slope in heights per pixel.
  double incidence(int row, int column, double height, double slope_x, double slope_y) const;
  /// The same slope against the ray itself.
  Tilt tilt(int row, int column, double height, double slope_x, double slope_y) const;
  double pixels_per_height(double height) const;  ///< along the optical axis, in widths of a pixel there
  /// The unit normal against the ray, in the sensor's frame.
  Vec3 normal(int row, int column, double height, double slope_x, double slope_y) const;

  bool pinhole = false;
  int width = 0, height_px = 0;
  std::size_t returns = 0;
  PaddedGrid<float> grid;

 private:
  /// Through a pixel, with a unit component along the axis.
  Vec3 ray(int row, int column) const;
  /// Normal times depth (pinhole), or with a unit component along the axis; not normalised, against the ray.
  Vec3 gradient(int row, int column, double height, double slope_x, double slope_y) const;

  double z0_, q_, reference_, fx_, fy_, cx_, cy_, pitch_x_, pitch_y_;
};

}  // namespace partscribe::geometry
