/// Connected groups of places.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::verify {

/// Groups of indices into `places` that are linked through neighbours closer than the smaller of their `reach`es, and
/// that `alike` allows to link; in the order of their first member.
std::vector<std::vector<std::uint32_t>> clusters_of(const std::vector<Vec3>& places, const std::vector<double>& reach,
                                                    const std::function<bool(std::uint32_t, std::uint32_t)>& alike);

}  // namespace partscribe::verify
