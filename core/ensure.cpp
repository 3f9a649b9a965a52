#include "core/ensure.h"

#include <cstdio>
#include <cstdlib>

namespace partscribe::core {

void ensure_failed(const char* message, const char* file, int line) {
  std::fprintf(stderr, "partscribe: internal error: %s (%s:%d)\n", message, file, line);
  std::abort();
}

}  // namespace partscribe::core
