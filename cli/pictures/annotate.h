/// What every picture of a part says besides: a title, a bar of a round length, the directions of the scan's axes.
#pragma once

#include <string>

#include "cli/pictures/raster.h"

namespace partscribe::cli {

/// `camera` is that of the raster as it is now; the bar is in its lower left corner, the title in its upper left one.
void annotate(Raster& raster, const Camera& camera, const std::string& title);

}  // namespace partscribe::cli
