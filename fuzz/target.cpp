// What libFuzzer calls: one of the entries of testing/fuzz, which the build names.
#include <cstddef>
#include <cstdint>

#include "testing/fuzz/entries.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  partscribe::testing::PARTSCRIBE_FUZZ_ENTRY({reinterpret_cast<const char*>(data), size});
  return 0;
}
