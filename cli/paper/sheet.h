/// A sheet on which figures are drawn: one unit is one pixel, from the lower left corner.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/pictures/raster.h"

namespace partscribe::cli {

inline constexpr Color sheet_white{255, 255, 255}, sheet_ink{20, 24, 32}, sheet_faint{215, 218, 224};

/// Colours that are told apart, for views, patches and lines.
Color series_color(std::size_t k);

class Sheet {
 public:
  Sheet(int width, int height);
  int width() const { return raster_.width; }
  int height() const { return raster_.height; }
  void line(const std::vector<Vec3>& points, double width, Color color);
  void dots(const std::vector<Vec3>& points, const std::vector<Color>& colors, double radius = 1.3);
  /// Column from the left, row from the top.
  void pixel(int column, int row, Color color);
  void text(double x, double y, std::string_view words, double height = 11);
  /// Puts another picture with its upper left corner at column and row.
  void paste(const Raster& picture, int column, int row);
  std::string png() const { return write_png(raster_); }

 private:
  Raster raster_;
  Camera camera_;
};

/// A field of a sheet in which y over x is drawn.
struct Chart {
  double left = 0, bottom = 0, width = 0, height = 0;  ///< pixels
  double x0 = 0, x1 = 1, y0 = 0, y1 = 1;               ///< what the edges of the field stand for
  Vec3 place(double x, double y) const;
  /// The frame, a title and the ends of both axes.
  void frame(Sheet& sheet, const std::string& title) const;
  void curve(Sheet& sheet, const std::vector<double>& x, const std::vector<double>& y, double width, Color color) const;
};

}  // namespace partscribe::cli
