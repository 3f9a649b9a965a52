#include "testing/places.h"

namespace partscribe::testing {

Path program() { return PARTSCRIBE_PROGRAM; }

Path source_file(const std::string& path) { return Path(PARTSCRIBE_SOURCE_DIR) / path; }

}  // namespace partscribe::testing
