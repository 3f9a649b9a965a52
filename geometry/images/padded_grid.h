/// A grid with a border of two cells, so that windows need no case for the edge of an image.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/large_memory.h"

namespace partscribe::geometry {

template <class T>
class PaddedGrid {
 public:
  PaddedGrid(int width, int height, T fill)
      : stride_(width + 4), cells_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 4), fill) {}

  void fill(T value) { std::fill(cells_.begin(), cells_.end(), value); }

  /// row(r)[c] is good for r and c from -2 to two beyond the image.
  T* row(int r) { return cells_.data() + (r + 2) * static_cast<std::ptrdiff_t>(stride_) + 2; }
  const T* row(int r) const { return cells_.data() + (r + 2) * static_cast<std::ptrdiff_t>(stride_) + 2; }

 private:
  int stride_;
  LargeVector<T> cells_;
};

}  // namespace partscribe::geometry
