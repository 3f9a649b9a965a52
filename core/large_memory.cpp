#include "core/large_memory.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace partscribe::core {

void* take_large_memory(std::size_t bytes) {
  constexpr std::size_t line = 64, page = std::size_t(1) << 21;
  // The last large page is there as a whole once it is touched: as long as touching a fiftieth to a fifth of it in
  // small pages takes, by machine. Where it is a fifth, an eighth loses little; where it is a fiftieth, a quarter loses
  // much.
  std::size_t in_pages = bytes / page * page;
  if (bytes - in_pages > page / 8) in_pages += page;
  const std::size_t step =
      in_pages > 0 ? page : line;  // what is asked for beyond `bytes` stays untouched, and is never there
  void* const memory = std::aligned_alloc(step, (std::max<std::size_t>(bytes, 1) + step - 1) / step * step);
  if (!memory) throw std::bad_alloc();
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  if (in_pages > 0) static_cast<void>(madvise(memory, in_pages, MADV_HUGEPAGE));  // a refusal costs time only
#endif
  return memory;
}

void give_back_large_memory(void* memory) { std::free(memory); }

}  // namespace partscribe::core
