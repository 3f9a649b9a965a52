#include "testing/fuzz/bundle.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace partscribe::testing {
namespace {

constexpr std::string_view mark = "--- ";

bool is_plain(std::string_view name) {
  return !name.empty() && name.size() < 60 && name.front() != '.' && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
  });
}

}  // namespace

Bundle::Bundle(std::string_view text) {
  std::ofstream file;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size() - 1) + 1;
    const auto line = text.substr(0, end);
    text.remove_prefix(end);
    if (!line.starts_with(mark)) {
      if (file.is_open()) file.write(line.data(), static_cast<std::streamsize>(line.size()));
      continue;
    }
    const auto name = line.substr(mark.size(), line.find('\n') - mark.size());
    file.close();
    if (!is_plain(name)) continue;
    const Path path = folder_.path() / name;
    file.open(path, std::ios::binary);
    if (first_.empty()) first_ = path;
  }
}

}  // namespace partscribe::testing
