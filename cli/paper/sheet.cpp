#include "cli/paper/sheet.h"

#include <algorithm>
#include <array>

#include "cli/describe.h"
#include "cli/pictures/raster_text.h"

namespace partscribe::cli {

Color series_color(std::size_t k) {
  constexpr std::array<Color, 8> colors{{{31, 97, 170},
                                         {214, 102, 24},
                                         {34, 139, 84},
                                         {168, 48, 60},
                                         {110, 76, 160},
                                         {120, 84, 60},
                                         {200, 78, 150},
                                         {70, 130, 150}}};
  return colors[k % colors.size()];
}

Sheet::Sheet(int width, int height) : raster_(width, height, sheet_white) {
  camera_.center = {0.5 * width, 0.5 * height, 0};
}

void Sheet::line(const std::vector<Vec3>& points, double width, Color color) {
  const auto on_raster = [&](const Vec3& p) { return Vec2(p.x(), raster_.height - p.y()); };
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    draw_stroke(raster_, on_raster(points[i]), on_raster(points[i + 1]), width, color);
}

void Sheet::dots(const std::vector<Vec3>& points, const std::vector<Color>& colors, double radius) {
  draw_points(raster_, camera_, points, colors, radius);
}

void Sheet::pixel(int column, int row, Color color) {
  if (column >= 0 && row >= 0 && column < raster_.width && row < raster_.height)
    raster_.pixels[std::size_t(row) * std::size_t(raster_.width) + std::size_t(column)] = color;
}

void Sheet::text(double x, double y, std::string_view words, double height) {
  draw_text(raster_, x, raster_.height - y, height, words, sheet_ink);
}

void Sheet::paste(const Raster& picture, int column, int row) {
  for (int r = 0; r < picture.height; ++r)
    for (int c = 0; c < picture.width; ++c)
      pixel(column + c, row + r, picture.pixels[std::size_t(r) * std::size_t(picture.width) + std::size_t(c)]);
}

Vec3 Chart::place(double x, double y) const {
  return {left + width * (x - x0) / (x1 - x0), bottom + height * (y - y0) / (y1 - y0), 0};
}

void Chart::frame(Sheet& sheet, const std::string& title) const {
  sheet.line({place(x0, y0), place(x1, y0), place(x1, y1), place(x0, y1), place(x0, y0)}, 1, sheet_faint);
  sheet.text(left, bottom + height + 6, title);
  sheet.text(left, bottom - 14, readable(x0), 9);
  sheet.text(left + width - 24, bottom - 14, readable(x1), 9);
  sheet.text(std::max(0.0, left - 34), bottom, readable(y0), 9);
  sheet.text(std::max(0.0, left - 34), bottom + height - 9, readable(y1), 9);
}

void Chart::curve(Sheet& sheet, const std::vector<double>& x, const std::vector<double>& y, double width_px,
                  Color color) const {
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < x.size(); ++i) places.push_back(place(x[i], std::clamp(y[i], y0, y1)));
  sheet.line(places, width_px, color);
}

}  // namespace partscribe::cli
