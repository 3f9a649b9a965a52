/// Letters for pictures: a small stroke font of our own, smooth at any size.
#pragma once

#include <string_view>

#include "cli/pictures/raster.h"

namespace partscribe::cli {

enum class TextAlign { left, middle, right };

/// Width in pixels of `text` when capitals are `height_px` high.
double text_width(std::string_view text, double height_px);

/// Writes `text` (letters, digits and common signs; others leave a gap) so that its baseline is in row `y` and it
/// starts, is centred or ends in column `x`. Depth is ignored.
void draw_text(Raster& raster, double x, double y, double height_px, std::string_view text, Color color,
               TextAlign align = TextAlign::left);

/// A smooth straight line of `width_px`, depth ignored.
void draw_stroke(Raster& raster, const Vec2& from, const Vec2& to, double width_px, Color color);

/// A filled rectangle, depth ignored.
void fill_box(Raster& raster, int left, int top, int width, int height, Color color);

}  // namespace partscribe::cli
