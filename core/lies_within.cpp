#include "core/lies_within.h"

#include <algorithm>

namespace partscribe::core {

bool lies_within(const Path& file, const Path& folder) {
  std::error_code failure;
  const Path outer = std::filesystem::canonical(folder.empty() ? "." : folder, failure);
  if (failure) return false;
  const Path whole = std::filesystem::absolute(file, failure);
  const Path inner = std::filesystem::weakly_canonical(whole, failure).lexically_relative(outer);
  const auto hidden = [](const Path& part) { return part.string().starts_with('.'); };  // ".." as well
  return !failure && !inner.empty() && std::none_of(inner.begin(), inner.end(), hidden);
}

}  // namespace partscribe::core
