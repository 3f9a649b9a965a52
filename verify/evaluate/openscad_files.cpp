#include "verify/evaluate/openscad_files.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "core/lies_within.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t most_files = 1000;  // bubblewrap takes 9000 words
constexpr std::size_t most_names = 100'000;
constexpr std::uint64_t most_bytes = 64u << 20;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (c >= '0' && c <= '9');
}

/// Everything in a script that can be the name of a file.
std::vector<std::string> names_in(std::string_view text) {
  std::vector<std::string> names;
  std::size_t at = 0;
  const auto skip_to = [&](std::string_view end) {
    at = std::min(text.find(end, at), text.size() - end.size()) + end.size();
  };
  while (at < text.size()) {
    const auto rest = text.substr(at);
    if (rest.starts_with("//")) {
      skip_to("\n");
    } else if (rest.starts_with("/*")) {
      at += 2;
      skip_to("*/");
    } else if (rest.front() == '"') {
      std::string name;
      for (++at; at < text.size() && text[at] != '"'; ++at) {
        if (text[at] == '\\' && at + 1 < text.size()) ++at;
        name += text[at];
      }
      ++at;
      names.push_back(std::move(name));
    } else if (is_letter(rest.front())) {
      const auto end = std::ranges::find_if_not(rest, is_letter);
      const auto word = rest.substr(0, static_cast<std::size_t>(end - rest.begin()));
      at += word.size();
      if (word != "use" && word != "include") continue;
      while (at < text.size() && is_blank(text[at])) ++at;
      if (at == text.size() || text[at] != '<') continue;
      const std::size_t begin = at + 1;
      skip_to(">");
      names.emplace_back(text.substr(begin, at - 1 - begin));
    } else {
      ++at;
    }
  }
  return names;
}

}  // namespace

std::vector<Path> files_of_script(const Path& script) {
  const Path folder = script.parent_path();
  std::vector<Path> files = {script};
  std::size_t names = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (i > 0 && files[i].extension() != ".scad") continue;
    const auto text = read_file(files[i], most_bytes);
    if (!text.ok()) continue;
    for (const auto& name : names_in(*text)) {
      if (++names > most_names) break;
      for (const Path& from : {files[i].parent_path(), folder}) {
        const Path file = (from / name).lexically_normal();
        std::error_code none;
        if (files.size() < most_files && name.find('\0') == std::string::npos &&
            std::filesystem::is_regular_file(file, none) && lies_within(file, folder) &&
            std::ranges::find(files, file) == files.end())
          files.push_back(file);
      }
    }
  }
  return files;
}

}  // namespace partscribe::verify
