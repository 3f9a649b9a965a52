/// How the smooth surfaces of a range image bend around each pixel.
#pragma once

#include <vector>

#include "geometry/images/bent_surface.h"
#include "geometry/images/padded_grid.h"
#include "geometry/images/range_heights.h"

namespace partscribe::geometry {

/// Curvatures found in 5x5 windows, in heights per pixel^2, or sums of them over neighbours.
struct CurvatureGrids {
  CurvatureGrids(int width, int height) : xx(width, height, 0), yy(xx), xy(xx), variance(xx), count(xx) {}
  PaddedGrid<float> xx, yy, xy;
  PaddedGrid<float> variance;  ///< of a curvature along the tilt, but for the factor 1 / 70
  PaddedGrid<float> count;     ///< of windows
};

/// How the surface at a pixel bends.
struct KnownBend {
  BentSurface shape;
  float variance = 0;        ///< that it adds to the value of a plane's middle, in units of the noise squared
  float doubt = 0;           ///< what a bend that hides in the noise, or a crease that passes for one, may add to that
  bool far_steeper = false;  ///< than where it was seen
};

/// More samples tell a bend that hides in the noise of one window: curvatures are averaged over 5x5, 9x9 and 17x17
/// windows.
class CurvatureMap {
 public:
  /// `windows`: count 1 where a window is smooth, else 0 throughout. `sigma`: noise of each sample, in heights; like
  /// `heights` it has to outlive the map.
  CurvatureMap(const RangeHeights& heights, const CurvatureGrids& windows, const PaddedGrid<float>& sigma);

  /// Whether the pixel lies in a smooth window; then it has a height.
  bool known(int row, int column) const { return scales_[0].count.row(row)[column] > 0; }

  /// The bend, seen at `tilt`, of the surface around a pixel: from the widest neighbourhood that says the same as every
  /// narrower one (Lepski 1990). Flat where nothing is known or no bend shows.
  KnownBend at(int row, int column, const Tilt& tilt) const;

 private:
  struct Estimate {
    Bend bend;
    float windows = 0;     ///< as precise as the mean of so many independent ones
    float steepening = 1;  ///< variance of the bend over that of the windows which tell it: they are less steep
  };
  static Estimate estimate(const CurvatureGrids& sums, int row, int column, const Tilt& tilt, float sigma);

  const RangeHeights& heights_;
  const PaddedGrid<float>& sigma_;
  std::vector<CurvatureGrids> scales_;
};

}  // namespace partscribe::geometry
