#include "core/large_memory.h"

#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace partscribe {

void* take_large_memory(std::size_t bytes) {
  constexpr std::size_t line = 64, page = std::size_t(1) << 21;
  const bool large = bytes >= page;
  const std::size_t step = large ? page : line;
  void* const memory = std::aligned_alloc(step, (bytes + line - 1) / line * line);
  if (!memory) throw std::bad_alloc();
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  // Only whole large pages: a part of one would be given whole. A refusal costs time only.
  if (large) static_cast<void>(madvise(memory, bytes / page * page, MADV_HUGEPAGE));
#endif
  return memory;
}

void give_back_large_memory(void* memory) { std::free(memory); }

}  // namespace partscribe
