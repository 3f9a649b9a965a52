/// Reweighted least trimmed squares filters for range images: outliers are found, noise is reduced, edges stay.
///
/// The filters work on heights in which planes are linear (depth, or inverse depth behind a pinhole). Everything that
/// comes out is in mm along the optical axis. No pixel is dropped or filled.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/images/range_image.h"

namespace partscribe::geometry {

enum class RltsForm {
  combined,  ///< trimmed lines in four directions reject; planes, quadrics and sides of edges give the value
  profile,   ///< as the 1993 paper: exact trimmed lines through five samples along each row
  facet,     ///< as the paper: trimmed planes in 5x5 windows
  quadric,   ///< as the paper: trimmed second-order surfaces in 5x5 windows
};

struct RltsOptions {
  RltsForm form = RltsForm::combined;  ///< the paper's windows take 100 times as long and blur steps
  double sigma = 0;                    ///< mm, noise at normal incidence; 0: estimated from the image
};

/// Noise along the optical axis: sigma = level + growth / cos^2(incidence), mm.
struct RangeNoise {
  double level = 0, growth = 0;
  double sigma(double incidence) const { return level + growth * incidence; }  ///< incidence: 1 / cos^2
};

/// How a filtered value came about.
enum class RltsModel : std::uint8_t { none, rejected, raw, line, plane, quadric, side };

/// Row by row, as the codes. Where there was no return depth is NaN and model `none`; a rejected pixel keeps its raw
/// depth, and so does a kept one without enough neighbours (`raw`).
struct FilteredImage {
  int width = 0, height = 0;
  std::vector<double> depth;  ///< mm
  std::vector<float> sigma;   ///< of the depth, mm, by the noise of the samples
  std::vector<float> doubt;   ///< mm, what a crease or bend that hides in the noise may add: in all hypot(sigma, doubt)
  std::vector<float> raw_sigma;                ///< of the sample itself, mm
  std::vector<float> slope_column, slope_row;  ///< of the depth, mm per pixel
  std::vector<std::uint8_t> kept;              ///< 1: the pixel's own sample was accepted
  std::vector<RltsModel> model;
  RangeNoise noise;
  std::size_t returns = 0, rejected = 0;
  /// Rejected pixels that one flipped bit explains, by bit. Flips below some 3 sigma look like noise: see
  /// detectable_share.
  std::array<std::size_t, 16> bit_errors{};
};

FilteredImage rlts_filter(const RangeImage& image, const RltsOptions& options, Context& context);

/// The share of flips of one bit that lie outside the acceptance limits of noise `sigma` (mm), for codes of `q` mm.
double detectable_share(int bit, double q, double sigma);

}  // namespace partscribe::geometry
