#include "cli/pictures/color_scale.h"

#include <algorithm>
#include <cmath>

#include "cli/pictures/raster_text.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

std::string hex(Color c) {
  constexpr const char* digits = "0123456789abcdef";
  std::string text = "#";
  for (const auto part : {c.red, c.green, c.blue}) text += digits[part >> 4], text += digits[part & 15];
  return text;
}

std::string number(double v) { return print_number(snapped(v, 0.01)); }

/// A signed length as ticks say it; the minus is a real one.
std::string tick_text(double mm, double tolerance) {
  const double value = snapped(std::abs(mm), std::max(power_of_ten_below(tolerance) / 1000, 1e-9));
  if (value == 0) return "0";
  return (mm < 0 ? "\xe2\x88\x92" : "+") + print_number(value);
}

}  // namespace

Color deviation_color(double deviation, double tolerance) {
  if (!std::isfinite(deviation)) return {130, 130, 130};
  const double share = deviation / tolerance, size = std::abs(share);
  constexpr Color none{230, 230, 227};
  const Color near = share < 0 ? Color{94, 170, 224} : Color{250, 164, 76};
  const Color far = share < 0 ? Color{16, 62, 150} : Color{176, 42, 10},
              end = share < 0 ? Color{8, 16, 70} : Color{84, 8, 20};
  // A tenth of the tolerance stays grey: nobody needs to look there.
  if (size <= 0.1) return none;
  if (size <= 1) return mixed(none, near, (size - 0.1) / 0.9);
  return mixed(far, end, std::min(1.0, size - 1));
}

std::vector<std::size_t> scale_histogram(const std::vector<float>& deviations, double tolerance, std::size_t bins) {
  std::vector<std::size_t> counts(bins, 0);
  for (const float d : deviations) {
    if (!std::isfinite(d)) continue;
    const double place = (d / tolerance + 2) / 4 * static_cast<double>(bins);
    ++counts[static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(bins) - 1))];
  }
  return counts;
}

std::string scale_svg(const std::vector<float>& deviations, double tolerance) {
  constexpr int height = 320, top = 14, bins = 80;
  const std::string t = print_number(tolerance);
  std::string svg =
      "<svg class=\"scale\" viewBox=\"0 0 176 360\" width=\"176\" height=\"360\" role=\"img\" aria-label=\"Colour "
      "scale of the deviation in mm, with a histogram of the scanned points. Blue: the scan lies inside the "
      "model's surface. Orange: outside. Dark: beyond the tolerance of " +
      t + " mm.\">\n";
  auto y_of = [&](double share) { return top + (2 - share) / 4 * height; };
  for (int k = 0; k < bins; ++k) {
    const double share = 2 - (k + 0.5) * 4 / bins;
    svg += "<path fill=\"" + hex(deviation_color(share * tolerance, tolerance)) + "\" d=\"M70 " +
           number(top + k * height / double(bins)) + "h22v" + number(height / double(bins) + 0.4) + "h-22z\"/>";
  }
  const auto counts = scale_histogram(deviations, tolerance, bins);
  const auto most = std::max<std::size_t>(1, *std::max_element(counts.begin(), counts.end()));
  std::string bars;
  for (int k = 0; k < bins; ++k)
    if (const auto n = counts[static_cast<std::size_t>(bins - 1 - k)]) {
      // Square root: a hundred points out of a million must still be seen.
      const double width = std::max(1.0, 64 * std::sqrt(static_cast<double>(n) / static_cast<double>(most)));
      bars += "M66 " + number(top + k * height / double(bins)) + "h-" + number(width) + "v3.4h" + number(width) + "z";
    }
  svg += "\n<path class=\"bars\" d=\"" + bars + "\"/>\n";
  for (const double share : {2.0, 1.0, 0.5, 0.0, -0.5, -1.0, -2.0}) {
    const bool limit = std::abs(share) == 1;
    svg += std::string("<path class=\"") + (limit ? "limit" : "tick") + "\" d=\"M" + (limit ? "4 " : "92 ") +
           number(y_of(share)) + (limit ? "h96" : "h5") + "\"/><text " + (limit ? "class=\"limit\" " : "") +
           "data-share=\"" + number(share) + "\" x=\"104\" y=\"" + number(y_of(share) + 4) + "\">" +
           tick_text(share * tolerance, tolerance) + (limit ? " T" : "") + "</text>\n";
  }
  return svg + "<text x=\"0\" y=\"352\">points \xc2\xb7 deviation in mm</text></svg>\n";
}

void draw_scale(Raster& raster, int left, int top, int height, double tolerance) {
  constexpr int width = 14;
  for (int row = 0; row < height; ++row) {
    const double share = 2 - (row + 0.5) * 4 / height;
    fill_box(raster, left, top + row, width, 1, deviation_color(share * tolerance, tolerance));
  }
  for (const double share : {2.0, 1.0, 0.0, -1.0, -2.0}) {
    const double y = top + (2 - share) / 4 * height;
    const bool limit = std::abs(share) == 1;
    draw_stroke(raster, {left - (limit ? 4.0 : 0.0), y}, {left + width + (limit ? 5.0 : 3.0), y}, limit ? 2 : 1, ink);
    draw_text(raster, left + width + 10, y + 4, 8, tick_text(share * tolerance, tolerance), ink);
  }
}

}  // namespace partscribe::cli
