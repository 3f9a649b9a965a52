/// The colours of a deviation map: grey at none, light blue and orange within the tolerance, dark beyond it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cli/pictures/raster.h"

namespace partscribe::cli {

/// The scale ends at twice the tolerance. Lightness alone tells within from beyond, so that print without colours and
/// eyes that confuse hues still see it. Undefined deviations are mid grey.
Color deviation_color(double deviation, double tolerance);

inline constexpr Color not_scanned_color{247, 246, 240}, not_scanned_stripe{176, 176, 170};
inline constexpr Color contradicted_color{255, 214, 240}, contradicted_stripe{150, 0, 110};
inline constexpr Color paper{255, 255, 255}, ink{27, 36, 48};

/// How many deviations lie in each of `bins` equal parts of the scale; those beyond its ends count in the outermost.
std::vector<std::size_t> scale_histogram(const std::vector<float>& deviations, double tolerance, std::size_t bins);

/// The scale as a drawing in the page: colour bar, histogram beside it, ticks, the tolerance marked.
std::string scale_svg(const std::vector<float>& deviations, double tolerance);

/// The scale in a picture, `height` pixels high, its upper left corner at (left, top).
void draw_scale(Raster& raster, int left, int top, int height, double tolerance);

}  // namespace partscribe::cli
