/// Text and byte readers shared by the file parsers.
#include <charconv>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

bool blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool line_end(char c) { return c == '\n' || c == '\r'; }

}  // namespace

bool LineReader::next(std::string_view& content) {
  if (at >= text.size()) return false;
  std::size_t end = at;
  while (end < text.size() && !line_end(text[end])) ++end;
  content = text.substr(at, end - at);
  if (end < text.size() && text[end] == '\r' && end + 1 < text.size() && text[end + 1] == '\n') ++end;
  at = end + 1;
  ++line;
  return true;
}

bool LineReader::next_filled(std::string_view& content) {
  while (next(content)) {
    for (const char c : content)
      if (!blank(c)) return true;
  }
  return false;
}

std::string_view next_word(std::string_view& rest) {
  std::size_t begin = 0;
  while (begin < rest.size() && blank(rest[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest.size() && !blank(rest[end])) ++end;
  const auto word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

std::string_view WordReader::next() {
  while (at < text.size() && (blank(text[at]) || line_end(text[at]))) {
    if (text[at] == '\n' || (text[at] == '\r' && !(at + 1 < text.size() && text[at + 1] == '\n'))) ++line;
    ++at;
  }
  const std::size_t begin = at;
  while (at < text.size() && !blank(text[at]) && !line_end(text[at])) ++at;
  return text.substr(begin, at - begin);
}

void WordReader::skip_line() {
  while (at < text.size() && !line_end(text[at])) ++at;
}

bool to_real(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  if (word.empty()) return false;
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (failure == std::errc::result_out_of_range && end == word.data() + word.size()) {
    const auto exponent = word.find_first_of("eE");
    const bool tiny = exponent == std::string_view::npos || word.find('-', exponent) != std::string_view::npos;
    value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
    return true;
  }
  if (failure != std::errc()) return false;
  if (end == word.data() + word.size()) return true;
  // "1.#QNAN", "-1.#IND": how an old Microsoft library spells what is not a number.
  if (word.find(".#") != std::string_view::npos) {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  return false;
}

bool to_integer(std::string_view word, std::int64_t& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  return failure == std::errc() && end == word.data() + word.size() && !word.empty();
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (auto& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

std::string suffix_of(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? std::string() : lower_case(std::string_view(name).substr(dot));
}

std::string shown(std::string_view found) {
  if (found.empty()) return "nothing";
  std::string result = "'";
  for (const char c : found.substr(0, 40)) result += (c >= ' ' && c <= '~') ? c : '?';
  return result + (found.size() > 40 ? "...'" : "'");
}

Error at_line(const std::string& name, std::size_t line, const std::string& message) {
  return bad_input(name + ", line " + std::to_string(line) + ": " + message);
}

Error at_byte(const std::string& name, std::size_t byte, const std::string& message) {
  return bad_input(name + ", byte " + std::to_string(byte) + ": " + message);
}

std::size_t size_of(NumberType type) {
  switch (type) {
    case NumberType::int8:
    case NumberType::uint8:
      return 1;
    case NumberType::int16:
    case NumberType::uint16:
      return 2;
    case NumberType::int32:
    case NumberType::uint32:
    case NumberType::float32:
      return 4;
    default:
      return 8;
  }
}

double load_real(const char* from, NumberType type, bool swapped) {
  switch (type) {
    case NumberType::float32:
      return load<float>(from, swapped);
    case NumberType::float64:
      return load<double>(from, swapped);
    case NumberType::uint64:
      return static_cast<double>(load<std::uint64_t>(from, swapped));
    default:
      return static_cast<double>(load_integer(from, type, swapped));
  }
}

std::int64_t load_integer(const char* from, NumberType type, bool swapped) {
  switch (type) {
    case NumberType::int8:
      return load<std::int8_t>(from);
    case NumberType::uint8:
      return load<std::uint8_t>(from);
    case NumberType::int16:
      return load<std::int16_t>(from, swapped);
    case NumberType::uint16:
      return load<std::uint16_t>(from, swapped);
    case NumberType::int32:
      return load<std::int32_t>(from, swapped);
    case NumberType::uint32:
      return load<std::uint32_t>(from, swapped);
    case NumberType::int64:
    case NumberType::uint64:
      return load<std::int64_t>(from, swapped);
    default:
      break;
  }
  const double value = load_real(from, type, swapped);
  // Some writers store indices as floats; anything else fits no index and is refused as such.
  return std::abs(value) < 4e18 && value == std::floor(value) ? static_cast<std::int64_t>(value) : -1;
}

}  // namespace partscribe::geometry::formats
