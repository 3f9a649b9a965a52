/// Simulated range images of a known part, with the true depth, normal and noise of every pixel.
#pragma once

#include <string>
#include <vector>

#include "geometry/images/range_image.h"
#include "scan/simulate/simulate.h"

namespace partscribe::filter_bench {

using namespace scan;

struct Truth {
  double depth = 0;   ///< mm along the optical axis; NaN: nothing there
  double sigma = 0;   ///< mm along the optical axis
  Vec3 normal;        ///< in the sensor's frame
  bool edge = false;  ///< the 5x5 window reaches a step, a crease or the end of the part
};

struct Scene {
  std::string name;
  RangeImage image;
  std::vector<Truth> truth;                   ///< one per pixel
  double depth_at(double x, double y) const;  ///< orthographic: true depth at a place in the sensor's frame; may be NaN
  Surface surface;
};

struct SceneOptions {
  std::string part = "bracket";  ///< bracket or dome
  int resolution = 240;
  int bits = 12;
  double sigma = 0.2;  ///< mm
  double bit_error = 0.01;
  double mixed = 0, outliers = 0;
  Projection projection = Projection::orthographic;
};

/// One view of the part.
Scene scene_of(const SceneOptions& options);

}  // namespace partscribe::filter_bench
