/// An image as it is, in the form in which filters are scored.
#include "bench/filter/peers.h"

namespace partscribe::filter_bench {

Filtered raw(const RangeImage& image) {
  Filtered out;
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c) {
      const auto p = view_point(image, r, c);
      out.points.push_back(p.value_or(Vec3::Zero()));
      out.kept.push_back(p.has_value());
    }
  return out;
}

}  // namespace partscribe::filter_bench
