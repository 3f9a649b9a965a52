/// Points as text: XYZ, ASC, PTS, TXT, CSV, with or without header, normals and further columns.
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

/// How the columns of a file are parted and what they mean; -1: not there.
struct Layout {
  bool commas = false, semicolons = false, decimal_commas = false;
  std::array<int, 3> point = {0, 1, 2};
  std::array<int, 3> normal = {-1, -1, -1};
  int needed() const {
    return 1 + std::max(*std::max_element(point.begin(), point.end()), *std::max_element(normal.begin(), normal.end()));
  }
};

bool comment(std::string_view line) {
  const auto first = next_word(line);
  return first.empty() || first.front() == '#' || first.front() == '%' || first.front() == '!' ||
         first.substr(0, 2) == "//" || (first.front() == ';');
}

/// Cuts a line into words; with commas or semicolons, an empty field is an empty word. Names ("Z [mm]") may hold
/// blanks.
void split(std::string_view line, const Layout& layout, std::vector<std::string_view>& words, bool names = false) {
  words.clear();
  const char mark = layout.semicolons ? ';' : layout.commas ? ',' : '\0';
  if (!mark) {
    for (auto word = next_word(line); !word.empty(); word = next_word(line)) words.push_back(word);
    return;
  }
  while (true) {
    const auto end = line.find(mark);
    auto field = line.substr(0, end);
    auto word = next_word(field);
    if (names || word.empty()) words.push_back(word);
    // "1, 2, 3" and "1 2 3, 4": blanks part numbers too.
    for (; !names && !word.empty(); word = next_word(field)) words.push_back(word);
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
    if (line.find_first_not_of(" \t") == std::string_view::npos) break;
  }
}

bool number_of(std::string_view word, bool decimal_commas, double& value) {
  if (word.size() >= 2 && word.front() == '"' && word.back() == '"') word = word.substr(1, word.size() - 2);
  if (!decimal_commas || word.find(',') == std::string_view::npos) return to_real(word, value);
  std::string text(word);
  std::replace(text.begin(), text.end(), ',', '.');
  return to_real(text, value);
}

Layout marks_of(std::string_view line) {
  Layout layout;
  layout.semicolons = line.find(';') != std::string_view::npos;
  layout.commas = line.find(',') != std::string_view::npos;
  layout.decimal_commas = layout.semicolons && layout.commas;
  if (!layout.semicolons && layout.commas) {
    // "1,5 2,5 3,5": commas inside three blank-separated words are decimal.
    std::string_view rest = line;
    int words = 0, inside = 0;
    for (auto word = next_word(rest); !word.empty(); word = next_word(rest)) {
      ++words;
      inside += word.find(',') != std::string_view::npos && word.back() != ',' && word.front() != ',' &&
                std::count(word.begin(), word.end(), ',') == 1;
    }
    if (words >= 3 && inside == words) layout.commas = false, layout.decimal_commas = true;
  }
  return layout;
}

/// Takes the meaning of the columns from their names, where a header has any.
void apply_names(std::string_view header, Layout& layout) {
  while (!header.empty() &&
         (header.front() == '#' || header.front() == '/' || header.front() == '%' || header.front() == ' '))
    header.remove_prefix(1);
  const Layout marks = marks_of(header);
  std::vector<std::string_view> words;
  split(header, marks, words, true);
  std::array<int, 3> point = {-1, -1, -1}, normal = {-1, -1, -1};
  for (int i = 0; i < static_cast<int>(words.size()); ++i) {
    auto name = lower_case(words[i]);
    std::erase(name, '"');
    if (const auto unit = name.find_first_of("[("); unit != std::string::npos && unit > 0) name.resize(unit);
    static constexpr std::string_view points[3][7] = {
        {"x", "x_mm", "x_m", "points:0", "points_0", "xcoord", "x_coordinate"},
        {"y", "y_mm", "y_m", "points:1", "points_1", "ycoord", "y_coordinate"},
        {"z", "z_mm", "z_m", "points:2", "points_2", "zcoord", "z_coordinate"}};
    static constexpr std::string_view normals[3][5] = {{"nx", "normal_x", "normals:0", "normals_0", "normalx"},
                                                       {"ny", "normal_y", "normals:1", "normals_1", "normaly"},
                                                       {"nz", "normal_z", "normals:2", "normals_2", "normalz"}};
    for (int k = 0; k < 3; ++k) {
      for (const auto& n : points[k])
        if (point[k] < 0 && name == n) point[k] = i;
      for (const auto& n : normals[k])
        if (normal[k] < 0 && name == n) normal[k] = i;
    }
  }
  if (point[0] < 0 || point[1] < 0 || point[2] < 0) return;
  layout.point = point;
  layout.normal = normal[0] >= 0 && normal[1] >= 0 && normal[2] >= 0 ? normal : std::array{-1, -1, -1};
}

}  // namespace

Result<RawGeometry> parse_xyz(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  raw.format = "XYZ";
  if (const auto zero = bytes.find('\0'); zero != std::string_view::npos)
    return at_byte(name, zero, "expected text with three coordinates a line, found binary data");
  LineReader lines{bytes};
  std::string_view line, header;
  std::vector<std::string_view> words;
  Layout layout;
  double value = 0;

  // The first line with three numbers starts the data; what stands before is header.
  std::size_t skipped = 0, first = 0, start = 0;
  while (true) {
    start = lines.at;
    if (!lines.next_filled(line)) break;
    if (lower_case(line.substr(0, 5)) == "ncols")
      return at_line(name, lines.line, "expected three coordinates a line, found an ESRI grid, which is not supported");
    layout = marks_of(line);
    split(line, layout, words);
    std::size_t numbers = 0;
    while (numbers < words.size() && number_of(words[numbers], layout.decimal_commas, value)) ++numbers;
    if (!comment(line) && words.size() >= 3 && numbers >= 1) {
      std::size_t all = 0;
      for (const auto& w : words) all += number_of(w, layout.decimal_commas, value);
      if (all >= 3) {
        first = lines.line;
        break;
      }
    }
    if (line.find_first_of("xX:") != std::string_view::npos) header = line;
    if (++skipped > 1000) break;
  }
  if (first == 0)
    return at_line(name, std::max<std::size_t>(lines.line, 1), "expected a line with three coordinates, found none");
  const auto columns = words.size();
  apply_names(header, layout);
  if (layout.needed() > static_cast<int>(columns)) layout.point = {0, 1, 2}, layout.normal = {-1, -1, -1};

  // Without names, three columns are normals when they are unit vectors in every one of the first lines.
  if (layout.normal[0] < 0 && columns >= 6) {
    for (const int begin : {3, static_cast<int>(columns) - 3}) {
      LineReader ahead{bytes, start};
      std::string_view sample;
      int lines_seen = 0, unit = 0;
      while (lines_seen < 500 && ahead.next_filled(sample)) {
        if (comment(sample)) continue;
        split(sample, layout, words);
        Vec3 n;
        if (static_cast<int>(words.size()) < begin + 3) continue;
        ++lines_seen;
        bool ok = true;
        for (int k = 0; k < 3; ++k) ok = ok && number_of(words[begin + k], layout.decimal_commas, n[k]);
        unit += ok && std::abs(n.norm() - 1) < 0.02;
      }
      if (lines_seen > 0 && unit == lines_seen) {
        layout.normal = {begin, begin + 1, begin + 2};
        break;
      }
    }
  }

  const bool normals = layout.normal[0] >= 0;
  const auto needed = static_cast<std::size_t>(layout.needed());
  std::size_t bad = 0, first_bad = 0;
  std::string bad_text;
  lines = {bytes, start, first - 1};
  while (lines.next_filled(line)) {
    if (comment(line)) continue;
    split(line, layout, words);
    Vec3 p, n = Vec3::Zero();
    bool ok = words.size() >= needed;
    for (int k = 0; ok && k < 3; ++k) {
      ok = number_of(words[static_cast<std::size_t>(layout.point[k])], layout.decimal_commas, p[k]);
      if (ok && normals) ok = number_of(words[static_cast<std::size_t>(layout.normal[k])], layout.decimal_commas, n[k]);
    }
    if (!ok) {
      std::int64_t count = 0;
      if (words.size() == 1 && to_integer(words[0], count)) continue;  // PTS: the count of the next block
      if (!bad++) first_bad = lines.line, bad_text = shown(line);
      continue;
    }
    raw.cloud.points.push_back(p);
    if (normals) raw.cloud.normals.push_back(n);
  }
  if (bad >= std::max<std::size_t>(raw.cloud.size(), 1))
    return at_line(name, first_bad, "expected at least " + std::to_string(needed) + " numbers, found " + bad_text);
  if (bad)
    raw.warnings.push_back(name + ": " + std::to_string(bad) + " lines left out, the first of them line " +
                           std::to_string(first_bad) + " (" + bad_text + ")");
  return raw;
}

}  // namespace partscribe::geometry::formats
