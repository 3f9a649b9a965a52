/// Stops the program when one of its own promises is broken: a crash beats a wrong part.
#pragma once

#include "core/layers.h"

namespace partscribe::core {

/// Prints `message` with its place and aborts; on in every build.
[[noreturn]] void ensure_failed(const char* message, const char* file, int line);

}  // namespace partscribe::core

#define ensure(condition, message) \
  ((condition) ? (void)0 : ::partscribe::core::ensure_failed((message), __FILE__, __LINE__))
