#include "cli/pictures/annotate.h"

#include "cli/pictures/color_scale.h"
#include "cli/pictures/raster_text.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

/// 1, 2 or 5 times a power of ten that is at most `limit`.
double round_length(double limit) {
  const double decade = power_of_ten_below(limit);
  for (const double step : {5.0, 2.0})
    if (step * decade <= limit) return step * decade;
  return decade;
}

}  // namespace

void annotate(Raster& raster, const Camera& camera, const std::string& title) {
  const double mm = round_length(0.22 * raster.width / camera.pixels_per_mm), length = mm * camera.pixels_per_mm;
  const double y = raster.height - 12.5;
  draw_stroke(raster, {12, y}, {12 + length, y}, 2, ink);
  for (const double x : {12.0, 12 + length}) draw_stroke(raster, {x, y - 4}, {x, y + 4}, 1.5, ink);
  draw_text(raster, 12 + length / 2, y - 7, 8, print_number(snapped(mm, 1e-9)) + " mm", ink, TextAlign::middle);
  draw_text(raster, 10, 19, 9, title, ink);
  const Vec2 origin(34, raster.height - 62);
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 direction = camera.view_from_world.col(axis);
    const Vec2 tip(22 * direction.x(), -22 * direction.y());
    if (tip.norm() < 5) continue;
    draw_stroke(raster, origin, origin + tip, 1.4, {110, 118, 128});
    const Vec2 letter = origin + tip * (1 + 7 / tip.norm());
    draw_text(raster, letter.x(), letter.y() + 3, 6, std::string(1, static_cast<char>('x' + axis)), {80, 88, 98},
              TextAlign::middle);
  }
}

}  // namespace partscribe::cli
