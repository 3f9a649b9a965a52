/// Runs the range-image filter over the views of a scan.
#pragma once

#include <cstddef>
#include <vector>

#include "core/context.h"
#include "geometry/images/range_image.h"
#include "geometry/images/rlts_filter.h"
#include "geometry/points/point_cloud.h"
#include "scan/register/register.h"

namespace partscribe::scan {

struct FilterSummary {
  std::size_t views = 0;  ///< that are range images; others stay as they are
  std::size_t returns = 0, rejected = 0;
  double sigma = 0;  ///< mm, median over the views of the noise at normal incidence
};

/// True if every view is a range image; false for none.
bool are_range_images(const std::vector<RangeImage>& images);

/// What the sigma of a filtered point stands for.
enum class FilterSigma {
  of_place,  ///< all that may be wrong with it: noise, and what hides in that
  of_noise,  ///< noise alone, which averages out between views
};

/// Filters the image of each view (see read_scan). The view's points, found by view and pixel, take the filtered depth,
/// with its normal and sigma, or are flagged as rejected. Columns normals and sigma are filled only where every view is
/// a range image. For registration and merging; fits and verdicts average on their own and take points as measured.
FilterSummary filter_views(Scan& scan, const std::vector<RangeImage>& images, Context& context,
                           FilterSigma sigma = FilterSigma::of_place);

/// Flags the points whose pixels the filter rejects; places stay as measured, and so do flags that are there. For fits
/// and verdicts.
FilterSummary flag_outliers(Scan& scan, const std::vector<RangeImage>& images, RltsForm form, Context& context);

/// The views of a scan as registration wants them: filtered, with normals, sigma of their noise and where they were
/// measured, if every view is a range image; as measured if not. A scan that filter_views has seen is taken as it is;
/// the scan itself stays.
std::vector<RegisterView> views_to_register(const Scan& scan, const std::vector<RangeImage>& images, Context& context);

}  // namespace partscribe::scan
