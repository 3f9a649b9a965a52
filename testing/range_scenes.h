/// Range images of known surfaces for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/random.h"
#include "geometry/images/range_image.h"

namespace partscribe::testing {

using namespace geometry;

/// An image, what a perfect scanner would have seen, and which pixels had a bit flipped.
struct RangeScene {
  RangeImage image;
  std::vector<double> truth;  ///< mm along the optical axis, NaN where there is nothing
  std::vector<int> flipped;   ///< the bit, or -1
};

struct RangeSceneOptions {
  int width = 80, height = 60, bits = 16;
  double sigma = 0.02;  ///< mm along the optical axis
  double bit_error = 0;
  double q = 0.002;  ///< mm per code
  std::uint64_t seed = 1;
};

/// `depth` (column, row) in mm, orthographic, pixels of 1 mm.
inline RangeScene range_scene(const RangeSceneOptions& o, const std::function<double(double, double)>& depth) {
  RangeScene s;
  s.image.width = o.width, s.image.height = o.height;
  s.image.q = o.q, s.image.z0 = 0;
  Random random(o.seed);
  const int most = (1 << o.bits) - 1;
  for (int r = 0; r < o.height; ++r)
    for (int c = 0; c < o.width; ++c) {
      const double z = depth(c, r), noise = random.normal(), chance = random.uniform();
      const int bit = static_cast<int>(random.below(static_cast<std::uint64_t>(o.bits)));
      s.truth.push_back(z);
      s.flipped.push_back(-1);
      int code = 0;
      if (!std::isnan(z)) {
        code = std::clamp(static_cast<int>(std::lround(1 + (z + o.sigma * noise) / o.q)), 1, most);
        if (chance < o.bit_error) code ^= 1 << bit, s.flipped.back() = bit;
      }
      s.image.codes.push_back(static_cast<std::uint16_t>(code));
    }
  return s;
}

}  // namespace partscribe::testing
