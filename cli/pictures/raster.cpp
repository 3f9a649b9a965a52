#include "cli/pictures/raster.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "core/png.h"

namespace partscribe::cli {
namespace {

void put(Raster& raster, int column, int row, double depth, Color color) {
  if (column < 0 || row < 0 || column >= raster.width || row >= raster.height) return;
  const auto k = static_cast<std::size_t>(row) * raster.width + column;
  if (static_cast<float>(depth) <= raster.depth[k]) return;
  raster.depth[k] = static_cast<float>(depth);
  raster.pixels[k] = color;
}

}  // namespace

Color mixed(Color a, Color b, double share) {
  auto mix = [&](int x, int y) { return static_cast<std::uint8_t>(x + (y - x) * share + 0.5); };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Vec3 projected(const Raster& raster, const Camera& camera, const Vec3& point) {
  const Vec3 p = camera.view_from_world * (point - camera.center);
  return {0.5 * raster.width + p.x() * camera.pixels_per_mm, 0.5 * raster.height - p.y() * camera.pixels_per_mm, p.z()};
}

Raster::Raster(int width_px, int height_px, Color background)
    : width(width_px),
      height(height_px),
      pixels(static_cast<std::size_t>(width_px) * height_px, background),
      depth(pixels.size(), -std::numeric_limits<float>::infinity()) {}

Camera camera_for(const std::vector<Vec3>& points, const Vec3& to_eye, const Vec3& up, int width_px, int height_px) {
  Camera camera;
  if (points.empty()) return camera;
  const Vec3 z = to_eye.normalized();
  Vec3 x = up.cross(z);
  if (x.norm() < 1e-9) x = z.unitOrthogonal();
  x.normalize();
  camera.view_from_world.row(0) = x;
  camera.view_from_world.row(1) = z.cross(x);
  camera.view_from_world.row(2) = z;
  Box3 seen;
  for (const auto& point : points) seen.add(camera.view_from_world * point);
  camera.center = camera.view_from_world.transpose() * seen.center();
  const Vec3 size = seen.size().cwiseMax(1e-9);
  constexpr double margin = 0.92;
  camera.pixels_per_mm = margin * std::min(width_px / size.x(), height_px / size.y());
  return camera;
}

Color shaded(Color color, const Camera& camera, const Vec3& normal, double strength) {
  const Vec3 n = camera.view_from_world * normal;
  static const Vec3 key = Vec3(-0.45, 0.65, 0.9).normalized(), fill = Vec3(0.8, -0.2, 0.5).normalized();
  const Vec3 facing = n.z() < 0 ? Vec3(-n) : n;
  const double light = 0.34 + 0.6 * std::max(0.0, facing.dot(key)) + 0.16 * std::max(0.0, facing.dot(fill));
  const double brightness = 1 + strength * (light - 1);
  auto lit = [&](std::uint8_t c) { return static_cast<std::uint8_t>(std::clamp(c * brightness + 0.5, 0.0, 255.0)); };
  return {lit(color.red), lit(color.green), lit(color.blue)};
}

void draw_triangles(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                    const std::vector<std::array<std::uint32_t, 3>>& triangles, const Paint& paint) {
  std::vector<Vec3> places(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) places[v] = projected(raster, camera, points[v]);
  auto bound = [](double v, int limit) { return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(limit))); };
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Vec3 &a = places[triangles[t][0]], &b = places[triangles[t][1]], &c = places[triangles[t][2]];
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
    if (area == 0) continue;
    // Pixels whose middle lies inside.
    const int left = bound(std::ceil(std::min({a.x(), b.x(), c.x()}) - 0.5), raster.width - 1);
    const int right = bound(std::floor(std::max({a.x(), b.x(), c.x()}) - 0.5), raster.width - 1);
    const int top = bound(std::ceil(std::min({a.y(), b.y(), c.y()}) - 0.5), raster.height - 1);
    const int bottom = bound(std::floor(std::max({a.y(), b.y(), c.y()}) - 0.5), raster.height - 1);
    for (int row = top; row <= bottom; ++row)
      for (int column = left; column <= right; ++column) {
        const double x = column + 0.5, y = row + 0.5;
        const double w1 = ((x - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (y - a.y())) / area;
        const double w2 = ((b.x() - a.x()) * (y - a.y()) - (x - a.x()) * (b.y() - a.y())) / area;
        const double w0 = 1 - w1 - w2;
        constexpr double edge = -1e-9;
        if (w0 < edge || w1 < edge || w2 < edge) continue;
        const double depth = w0 * a.z() + w1 * b.z() + w2 * c.z();
        if (static_cast<float>(depth) <= raster.depth[static_cast<std::size_t>(row) * raster.width + column]) continue;
        put(raster, column, row, depth, paint(t, {w0, w1, w2}, column, row));
      }
  }
}

void draw_lines(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                const std::vector<std::array<std::uint32_t, 2>>& lines, double width_px, Color color) {
  const double bias = 1.2 * width_px / camera.pixels_per_mm;
  const int reach = static_cast<int>(std::ceil(width_px / 2));
  for (const auto& line : lines) {
    const Vec3 from = projected(raster, camera, points[line[0]]), to = projected(raster, camera, points[line[1]]);
    const double length = std::max(std::abs(to.x() - from.x()), std::abs(to.y() - from.y()));
    if (!(length < 1e6)) continue;
    const int steps = static_cast<int>(length) + 1;
    for (int i = 0; i <= steps; ++i) {
      const Vec3 p = from + (to - from) * (static_cast<double>(i) / steps);
      const int column = static_cast<int>(std::floor(p.x())), row = static_cast<int>(std::floor(p.y()));
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
          const double x = column + dx + 0.5 - p.x(), y = row + dy + 0.5 - p.y();
          if (4 * (x * x + y * y) <= width_px * width_px) put(raster, column + dx, row + dy, p.z() + bias, color);
        }
    }
  }
}

void draw_contour(Raster& raster, double leap_mm, int width_px, Color color) {
  std::vector<std::uint8_t> marked(raster.pixels.size(), 0);
  const auto width = static_cast<std::size_t>(raster.width);
  for (int row = width_px; row + width_px < raster.height; ++row)
    for (int column = width_px; column + width_px < raster.width; ++column) {
      const auto k = static_cast<std::size_t>(row) * width + column;
      if (std::isinf(raster.depth[k])) continue;
      const auto step = static_cast<std::size_t>(width_px);
      // The nearer side of the leap is drawn on, so that lines do not grow over what lies behind.
      for (const auto other : {k - step, k + step, k - step * width, k + step * width}) {
        // A steep surface is no leap: there it goes on as it came.
        const float came = std::max(0.0F, raster.depth[2 * k - other] - raster.depth[k]);
        if (raster.depth[k] - raster.depth[other] - came > leap_mm) marked[k] = 1;
      }
    }
  for (std::size_t k = 0; k < marked.size(); ++k)
    if (marked[k]) raster.pixels[k] = color;
}

void draw_points(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                 const std::vector<Color>& colors, double radius_px) {
  ensure(colors.size() == points.size(), "one colour per point");
  const int reach = static_cast<int>(std::ceil(radius_px));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = projected(raster, camera, points[i]);
    if (!(std::abs(p.x()) < 1e6 && std::abs(p.y()) < 1e6)) continue;
    const int column = static_cast<int>(std::floor(p.x())), row = static_cast<int>(std::floor(p.y()));
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx)
        if (dx * dx + dy * dy <= radius_px * radius_px) put(raster, column + dx, row + dy, p.z(), colors[i]);
  }
}

Raster reduced(const Raster& raster, int factor) {
  Raster small(raster.width / factor, raster.height / factor, {});
  const int count = factor * factor;
  for (int row = 0; row < small.height; ++row)
    for (int column = 0; column < small.width; ++column) {
      int red = count / 2, green = count / 2, blue = count / 2;
      for (int k = 0; k < count; ++k) {
        const auto& c = raster.pixels[static_cast<std::size_t>(factor * row + k / factor) * raster.width +
                                      factor * column + k % factor];
        red += c.red, green += c.green, blue += c.blue;
      }
      small.pixels[static_cast<std::size_t>(row) * small.width + column] = {static_cast<std::uint8_t>(red / count),
                                                                            static_cast<std::uint8_t>(green / count),
                                                                            static_cast<std::uint8_t>(blue / count)};
    }
  return small;
}

std::string write_png(const Raster& raster) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * raster.pixels.size());
  for (const Color& c : raster.pixels) bytes.insert(bytes.end(), {c.red, c.green, c.blue});
  return write_png_rgb(raster.width, raster.height, bytes);
}

}  // namespace partscribe::cli
