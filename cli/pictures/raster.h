/// Draws points, surfaces and lines into a picture by a z-buffer; no window, no graphics card.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::cli {

struct Color {
  std::uint8_t red = 255, green = 255, blue = 255;
  bool operator==(const Color&) const = default;
};

/// `share` 0 gives a, 1 gives b.
Color mixed(Color a, Color b, double share);

/// Orthographic: `view_from_world` turns x right, y up, z towards the eye.
struct Camera {
  Mat3 view_from_world = Mat3::Identity();
  Vec3 center = Vec3::Zero();  ///< world point in the middle of the picture
  double pixels_per_mm = 1;
};

/// A picture with depth; rows from the top.
struct Raster {
  Raster(int width_px, int height_px, Color background);
  int width, height;
  std::vector<Color> pixels;
  std::vector<float> depth;  ///< larger is nearer to the eye; minus infinity where nothing was drawn
};

/// Looks from the direction `to_eye` (need not be unit) with `up` pointing up, so that `points` fill the picture.
Camera camera_for(const std::vector<Vec3>& points, const Vec3& to_eye, const Vec3& up, int width_px, int height_px);

/// Column, row and depth of a world point.
Vec3 projected(const Raster& raster, const Camera& camera, const Vec3& point);

/// The colour of a pixel of triangle `triangle` where its corners weigh `weights`; column and row allow patterns.
using Paint = std::function<Color(std::uint32_t triangle, const Vec3& weights, int column, int row)>;

void draw_triangles(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                    const std::vector<std::array<std::uint32_t, 3>>& triangles, const Paint& paint);

/// Lines of `width_px`, drawn over surfaces that are not more than a little nearer.
void draw_lines(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                const std::vector<std::array<std::uint32_t, 2>>& lines, double width_px, Color color);

/// Lines of `width_px` where the depth leaps by more than `leap_mm`: the contour of the part.
void draw_contour(Raster& raster, double leap_mm, int width_px, Color color);

/// Discs of `radius_px`; `colors` is one per point.
void draw_points(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                 const std::vector<Color>& colors, double radius_px);

/// `color` as lit on a surface with this unit normal (its sign does not matter). `strength` 0 leaves it as it is.
Color shaded(Color color, const Camera& camera, const Vec3& normal, double strength = 1);

/// Each pixel the mean of factor x factor: smooth edges.
Raster reduced(const Raster& raster, int factor);

/// A complete PNG file, the same bytes for the same picture.
std::string write_png(const Raster& raster);

}  // namespace partscribe::cli
