#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "verify/exchange/check_exchange.h"

namespace partscribe::verify {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

/// A whole number; -1 where there is none.
long whole(std::string_view text) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : -1;
}

/// Nothing, a finite number, or a text of which fields_of() has cut off the count.
bool fine(std::string_view field) {
  field = trimmed(field);
  if (field.empty()) return true;
  if (field.front() == '+') field.remove_prefix(1);
  std::string text(field);
  std::replace(text.begin(), text.end(), 'D', 'E');
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range) return text.find("E-") != std::string::npos;
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);  // NAN would be read as one
}

struct Fields {
  std::vector<std::string> list;
  bool closed = false;
  std::string bad;  ///< a field that is neither number nor text
};

Fields fields_of(const std::string& text, char separator, char end) {
  Fields result;
  std::string field;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == 'H' && !field.empty() && whole(field) >= 0) {  // 5Hwords
      const auto count = static_cast<std::size_t>(whole(field));
      field.clear();
      i += count;
      result.list.push_back("");
      while (i + 1 < text.size() && text[i + 1] == ' ') ++i;
      if (i + 1 >= text.size()) return result;
      ++i;
      if (text[i] == end) {
        result.closed = true;
        return result;
      }
      continue;
    }
    if (c == separator || c == end) {
      if (!fine(field) && result.bad.empty()) result.bad = std::string(trimmed(field));
      result.list.push_back(std::string(trimmed(field)));
      field.clear();
      if (c == end) {
        result.closed = true;
        return result;
      }
    } else {
      field += c;
    }
  }
  return result;
}

/// Places of pointers in the records whose circles or gaps would lead a reader astray.
std::vector<std::size_t> pointers_in(long type, const std::vector<std::string>& f) {
  std::vector<std::size_t> places;
  auto count_at = [&](std::size_t i) { return i < f.size() ? static_cast<std::size_t>(std::max(0l, whole(f[i]))) : 0; };
  if (type == 186) places = {1};
  if (type == 514)
    for (std::size_t i = 0; i < count_at(1); ++i) places.push_back(2 + 2 * i);
  if (type == 510) {
    places = {1};
    for (std::size_t i = 0; i < count_at(2); ++i) places.push_back(4 + i);
  }
  if (type == 430) places = {1};
  if (type == 184)
    for (std::size_t i = 0; i < count_at(1); ++i) places.push_back(2 + i);
  return places;
}

}  // namespace

std::optional<std::string> fault_of_iges(std::string_view text) {
  std::map<char, std::vector<std::string>> sections;
  const std::string_view order = "SGDPT";
  std::size_t section = 0, number = 0;
  for (std::size_t at = 0; at < text.size();) {
    auto end = text.find('\n', at);
    if (end == std::string_view::npos) end = text.size();
    std::string_view line = text.substr(at, end - at);
    at = end + 1, ++number;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (!sections['T'].empty()) continue;  // what follows the last line means nothing
    if (line.size() < 73)
      return number == 1 ? "the file does not begin with a line of IGES"
                         : "line " + std::to_string(number) + " is cut off";
    if (number == 1 && (line[72] == 'B' || line[72] == 'C')) return std::nullopt;
    const auto found = order.find(line[72]);
    if (found == std::string_view::npos || found < section)
      return "line " + std::to_string(number) + " belongs to no section or stands in the wrong one";
    section = found;
    auto& lines = sections[line[72]];
    if (const long n = whole(line.substr(73)); n != static_cast<long>(lines.size()) + 1)
      return "line " + std::to_string(number) + " is numbered " + std::string(trimmed(line.substr(73))) +
             " in its section, expected " + std::to_string(lines.size() + 1) + ": lines are missing";
    lines.push_back(std::string(line.substr(0, 72)));
  }
  if (sections['T'].empty()) return "the file ends before its last line, which counts all others";
  const std::string& counts = sections['T'][0];
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string_view entry = std::string_view(counts).substr(8 * i, 8);
    const auto held = static_cast<long>(sections[order[i]].size());
    if (entry[0] != order[i] || whole(entry.substr(1)) != held)
      return "its last line counts " + std::string(trimmed(entry)) + ", but section " + order[i] + " has " +
             std::to_string(held) + " lines";
  }
  std::string global;
  for (const auto& line : sections['G']) global += line;
  char separator = ',', close = ';';
  if (global.substr(0, 2) == "1H" && global.size() > 3)
    separator = global[2], global.erase(0, 4);
  else if (!global.empty())
    global.erase(0, 1);
  if (global.substr(0, 2) == "1H" && global.size() > 3) close = global[2];

  const auto &entries = sections['D'], &parameters = sections['P'];
  if (entries.size() % 2) return "an entry of section D has one line only";
  const long last = static_cast<long>(entries.size()) - 1;
  std::map<long, std::vector<long>> refers;
  for (long entry = 1; entry <= last; entry += 2) {
    const std::string &a = entries[static_cast<std::size_t>(entry) - 1], &b = entries[static_cast<std::size_t>(entry)];
    const long type = whole(std::string_view(a).substr(0, 8)), first = whole(std::string_view(a).substr(8, 8));
    const long lines = std::max(1l, whole(std::string_view(b).substr(24, 8)));
    const std::string name = "entry " + std::to_string(entry) + " (type " + std::to_string(type) + ")";
    if (type < 0 || type != whole(std::string_view(b).substr(0, 8))) return name + " has two types";
    if (type == 0) continue;
    if (first < 1 || first + lines - 1 > static_cast<long>(parameters.size()))
      return name + " refers to lines of section P that are missing";
    std::string record;
    for (long i = first; i < first + lines; ++i) {
      const std::string& line = parameters[static_cast<std::size_t>(i) - 1];
      if (whole(std::string_view(line).substr(64, 8)) != entry)
        return name + ": its lines in section P belong to another entry";
      record += line.substr(0, 64);
    }
    const Fields fields = fields_of(record, separator, close);
    if (!fields.closed) return name + ": its record is not closed";
    if (!fields.bad.empty()) return name + ": '" + fields.bad + "' is no finite number";
    if (fields.list.empty() || whole(fields.list[0]) != type) return name + ": its record is of another type";
    for (const std::size_t place : pointers_in(type, fields.list)) {
      const long to = place < fields.list.size() ? std::abs(whole(fields.list[place])) : 0;
      if (to < 1 || to > last || to % 2 == 0) return name + " refers to an entry that is missing";
      refers[entry].push_back(to);
    }
    if (type == 514) {
      auto faces = refers[entry];
      std::sort(faces.begin(), faces.end());
      if (const auto twice = std::adjacent_find(faces.begin(), faces.end()); twice != faces.end())
        return name + " lists the face of entry " + std::to_string(*twice) + " twice";
    }
    if (type == 180) {  // operands are pointers with the sign changed, operations small positive numbers
      const long count = fields.list.size() > 1 ? whole(fields.list[1]) : 0;
      if (count < 1 || fields.list.size() < static_cast<std::size_t>(count) + 2)
        return name + ": its record is too short";
      for (long i = 0; i < count; ++i) {
        const std::string& field = fields.list[static_cast<std::size_t>(i) + 2];
        if (field.empty() || field[0] != '-') continue;
        const long to = whole(std::string_view(field).substr(1));
        if (to < 1 || to > last || to % 2 == 0) return name + " refers to an entry that is missing";
        refers[entry].push_back(to);
      }
    }
  }
  // Shells and trees are a few levels deep: a walk that comes back to where it is goes in a circle.
  std::set<long> done;
  for (const auto& [start, ignored] : refers) {
    std::vector<std::pair<long, std::size_t>> path = {{start, 0}};
    std::set<long> on_path = {start};
    while (!path.empty()) {
      auto& [entry, next] = path.back();
      const auto at = refers.find(entry);
      if (done.count(entry) || at == refers.end() || next == at->second.size()) {
        done.insert(entry), on_path.erase(entry), path.pop_back();
        continue;
      }
      const long to = at->second[next++];
      if (on_path.count(to)) return "entry " + std::to_string(to) + " refers to itself in a circle";
      if (!done.count(to)) on_path.insert(to), path.push_back({to, 0});
    }
  }
  return std::nullopt;
}

}  // namespace partscribe::verify
