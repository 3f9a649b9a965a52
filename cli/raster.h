/// Draws points and meshes into a picture by a z-buffer, and writes it as PNG; no window, no graphics card.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/triangle_mesh.h"
#include "geometry/vec.h"

namespace partscribe {

struct Color {
  std::uint8_t red = 255, green = 255, blue = 255;
  bool operator==(const Color&) const = default;
};

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
  std::vector<float> depth;  ///< larger is nearer to the eye
};

/// Looks from the direction `to_eye` (need not be unit) with `up` pointing up, so that `points` fill the picture.
Camera camera_for(const std::vector<Vec3>& points, const Vec3& to_eye, const Vec3& up, int width_px, int height_px);

/// Smooth shading across edges below 30 degrees; sharper edges and borders get a dark line.
void draw_mesh(Raster& raster, const Camera& camera, const TriangleMesh& mesh, Color color);

/// Discs of `radius_px`; `colors` is one per point.
void draw_points(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                 const std::vector<Color>& colors, double radius_px);

/// `color` as lit on a surface with this unit normal (its sign does not matter).
Color shaded(Color color, const Camera& camera, const Vec3& normal);

/// Half the width and height, four pixels averaged: smooth edges.
Raster halved(const Raster& raster);

/// A complete PNG file, the same bytes for the same picture.
std::string write_png(const Raster& raster);

}  // namespace partscribe
