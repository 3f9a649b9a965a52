/// Splines over nets that the characters of a surface size, as published in 1993 (Koivunen, Vezien & Bajcsy, section
/// 3.2).
#pragma once

#include "fit/surface/published_spline.h"
#include "geometry/images/region_growing.h"

namespace partscribe::fit {

/// Control points each way: `per_patch` for each patch along the row or column with most of them; what the order of the
/// spline needs at the least.
struct NetSize {
  int columns = 4, rows = 4;
};
NetSize net_size(const PatchCounts& patches, int per_patch = 3, int order = 4);

/// The cubic surface of a grid of places whose patches were counted, begun with a net of that size and equal spans, and
/// refined to `tolerance` (mm, at equal parameters).
PublishedSurface sized_surface(const PlaceGrid& grid, const PatchCounts& patches, Parameters kind, double tolerance);

}  // namespace partscribe::fit
