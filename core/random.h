/// Seeded random numbers that are the same on every machine and library.
#pragma once

#include <cstdint>

#include "core/layers.h"

namespace partscribe::core {

/// SplitMix64 with distributions of our own (the standard library's differ between vendors).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  double uniform();  ///< in [0, 1)
  double uniform(double low, double high);
  std::uint64_t below(std::uint64_t count);  ///< in [0, count)
  double normal();                           ///< mean 0, standard deviation 1

 private:
  std::uint64_t state_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace partscribe::core
