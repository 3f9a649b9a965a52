/// Loops over index ranges in parallel, with the same result for any number of threads.
#pragma once

#include <cstddef>
#include <functional>

#include "core/layers.h"

namespace partscribe::core {

/// Calls `body(begin, end)` over [0, count) in blocks of fixed size. Blocks run in any order and
/// on any thread, so a body writes only to slots of its own indices.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t begin, std::size_t end)>& body,
                  std::size_t block = 1024);

}  // namespace partscribe::core
