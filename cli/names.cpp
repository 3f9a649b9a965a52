#include "cli/names.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <set>
#include <vector>

namespace partscribe::cli {
namespace {

const std::set<std::string> names_without_meaning = {"cloud", "scan", "merged", "model", "part"};

/// U+00C0 to U+017F in letters that every language can write; "" where it is no letter.
constexpr std::array<const char*, 0xC0> latin = {
    "a",  "a", "a",  "a", "ae", "a", "ae", "c",  "e",  "e", "e",  "e",  "i", "i", "i",  "i",  "d",  "n", "o",  "o",
    "o",  "o", "oe", "",  "o",  "u", "u",  "u",  "ue", "y", "th", "ss", "a", "a", "a",  "a",  "ae", "a", "ae", "c",
    "e",  "e", "e",  "e", "i",  "i", "i",  "i",  "d",  "n", "o",  "o",  "o", "o", "oe", "",   "o",  "u", "u",  "u",
    "ue", "y", "th", "y", "a",  "a", "a",  "a",  "a",  "a", "c",  "c",  "c", "c", "c",  "c",  "c",  "c", "d",  "d",
    "d",  "d", "e",  "e", "e",  "e", "e",  "e",  "e",  "e", "e",  "e",  "g", "g", "g",  "g",  "g",  "g", "g",  "g",
    "h",  "h", "h",  "h", "i",  "i", "i",  "i",  "i",  "i", "i",  "i",  "i", "i", "ij", "ij", "j",  "j", "k",  "k",
    "k",  "l", "l",  "l", "l",  "l", "l",  "l",  "l",  "l", "l",  "n",  "n", "n", "n",  "n",  "n",  "n", "n",  "n",
    "o",  "o", "o",  "o", "o",  "o", "oe", "oe", "r",  "r", "r",  "r",  "r", "r", "s",  "s",  "s",  "s", "s",  "s",
    "s",  "s", "t",  "t", "t",  "t", "t",  "t",  "u",  "u", "u",  "u",  "u", "u", "u",  "u",  "u",  "u", "u",  "u",
    "w",  "w", "y",  "y", "y",  "z", "z",  "z",  "z",  "z", "z",  "s"};

/// U+0430 to U+044F.
constexpr std::array<const char*, 32> cyrillic = {"a",  "b",  "v",  "g",    "d", "e", "zh", "z", "i",  "y", "k",
                                                  "l",  "m",  "n",  "o",    "p", "r", "s",  "t", "u",  "f", "kh",
                                                  "ts", "ch", "sh", "shch", "",  "y", "",   "e", "yu", "ya"};

/// One character of a name: its bytes, and its number; 0 for a byte that is no UTF-8.
struct Character {
  std::string bytes;
  std::uint32_t code = 0;
};

std::vector<Character> characters(const std::string& text) {
  std::vector<Character> result;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first < 0x80                    ? 1
                               : first >= 0xC2 && first < 0xE0 ? 2
                               : first >= 0xE0 && first < 0xF0 ? 3
                               : first >= 0xF0 && first < 0xF5 ? 4
                                                               : 0;
    std::uint32_t code = length == 1 ? first : first & (0x7Fu >> length);
    std::size_t valid = length == 0 ? 0 : 1;
    for (; valid > 0 && valid < length && i + valid < text.size() &&
           (static_cast<unsigned char>(text[i + valid]) & 0xC0) == 0x80;
         ++valid)
      code = code << 6 | (static_cast<unsigned char>(text[i + valid]) & 0x3F);
    const bool whole = length > 0 && valid == length;
    result.push_back({text.substr(i, whole ? length : 1), whole ? code : 0});
    i += whole ? length : 1;
  }
  return result;
}

bool is_between(std::uint32_t code, std::uint32_t low, std::uint32_t high) { return code >= low && code <= high; }

/// Signs of Latin-1, spaces and dashes of all lengths, and what is no character.
bool is_sign(std::uint32_t code) {
  return code == 0 || is_between(code, 0x7F, 0xBF) || is_between(code, 0x2000, 0x206F) || code == 0x3000;
}

/// Accents that follow their letter.
bool is_accent(std::uint32_t code) { return is_between(code, 0x300, 0x36F); }

bool is_digit(std::uint32_t code) { return is_between(code, '0', '9'); }
bool is_letter(std::uint32_t code) { return is_between(code, 'a', 'z') || is_between(code, 'A', 'Z'); }

/// In lower-case letters and digits; empty where there is nothing to say.
std::string transliterated(std::uint32_t code) {
  if (is_digit(code)) return std::string(1, static_cast<char>(code));
  if (is_letter(code)) return std::string(1, static_cast<char>(code | 0x20));
  if (is_between(code, 0xC0, 0x17F)) return latin[code - 0xC0];
  if (is_between(code, 0x410, 0x42F)) code += 0x20;
  if (is_between(code, 0x430, 0x44F)) return cyrillic[code - 0x430];
  return code == 0x451 || code == 0x401 ? "yo" : "";
}

std::string as_identifier(const std::string& text) {
  std::string name;
  const auto separate = [&] {
    if (!name.empty() && name.back() != '_') name += '_';
  };
  for (const auto& c : characters(text)) {
    if (is_accent(c.code)) continue;
    const std::string letters = transliterated(c.code);
    const bool silent = is_between(c.code, 0x410, 0x44F);
    if (!letters.empty() || silent) {
      name += letters;
    } else if (c.code < 0x80 || is_sign(c.code) || is_between(c.code, 0xC0, 0x17F)) {
      separate();
    } else {
      std::array<char, 12> number{};
      std::snprintf(number.data(), number.size(), "u%04x", static_cast<unsigned>(c.code));
      separate();
      name += number.data();
      name += '_';
    }
  }
  while (name.ends_with('_')) name.pop_back();
  return name;
}

std::string as_folder(const std::string& text) {
  std::string name;
  for (const auto& c : characters(text)) {
    const bool kept = is_letter(c.code) || is_digit(c.code) || (c.code >= 0x80 && !is_sign(c.code));
    if (kept || ((c.bytes == "-" || c.bytes == ".") && !name.empty()))
      name += c.bytes;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (name.ends_with('_') || name.ends_with('.') || name.ends_with('-')) name.pop_back();
  return name;
}

/// The last name in a path that says something, without what it ends with.
std::string telling_name(const Path& input) {
  Path path = std::filesystem::absolute(input).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  std::error_code ignored;
  for (; path.has_relative_path(); path = path.parent_path()) {
    std::string stem = std::filesystem::is_directory(path, ignored) ? path.filename().string() : path.stem().string();
    if (stem.ends_with(folder_ending)) stem.resize(stem.size() - std::string_view(folder_ending).size());
    const std::string name = as_identifier(stem);
    if (!name.empty() && !names_without_meaning.count(name)) return stem;
  }
  return "part";
}

}  // namespace

std::string part_name(const Path& input) {
  const std::string name = as_identifier(telling_name(input));
  return is_digit(static_cast<unsigned char>(name.front())) ? "part_" + name : name;
}

std::string folder_name(const Path& input) { return as_folder(telling_name(input)); }

}  // namespace partscribe::cli
