/// Runs the range-image filter over the views of a scan.
#pragma once

#include <cstddef>
#include <vector>

#include "core/context.h"
#include "geometry/point_cloud.h"
#include "geometry/range_image.h"

namespace partscribe {

enum class FilterUse {
  flags,   ///< points stay as measured; only cloud.rejected is set: for fits and verdicts, which average on their own
  values,  ///< points take the filtered depth, with its normal and sigma: for registration and merging
};

struct FilterSummary {
  std::size_t views = 0;             ///< that are range images; others stay as they are
  std::size_t returns = 0, rejected = 0;
  double sigma = 0;                  ///< mm, median over the views of the noise at normal incidence
};

/// Filters the image of each view (see read_scan) and carries the result to the view's points, found by view and pixel.
/// Columns normals and sigma are filled only where every view is a range image.
FilterSummary filter_views(Scan& scan, const std::vector<RangeImage>& images, FilterUse use, Context& context);

}  // namespace partscribe
