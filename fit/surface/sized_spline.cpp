#include "fit/surface/sized_spline.h"

#include <algorithm>

namespace partscribe::fit {

NetSize net_size(const PatchCounts& patches, int per_patch, int order) {
  return {std::max(order, per_patch * patches.along_row), std::max(order, per_patch * patches.along_column)};
}

PublishedSurface sized_surface(const PlaceGrid& grid, const PatchCounts& patches, Parameters kind, double tolerance) {
  const NetSize size = net_size(patches);
  return refined_surface(grid, equal_spans(size.columns), equal_spans(size.rows), kind, tolerance);
}

}  // namespace partscribe::fit
