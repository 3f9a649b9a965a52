/// VTK legacy polydata, ascii and binary (big-endian), versions up to 5.1.
#include "geometry/read_formats.h"

namespace partscribe::formats {
namespace {

std::optional<NumberType> number_type(const std::string& word) {
  static constexpr std::pair<std::string_view, NumberType> names[] = {
      {"float", NumberType::float32},        {"double", NumberType::float64},       {"char", NumberType::int8},
      {"unsigned_char", NumberType::uint8},  {"short", NumberType::int16},          {"unsigned_short", NumberType::uint16},
      {"int", NumberType::int32},            {"unsigned_int", NumberType::uint32},  {"long", NumberType::int64},
      {"unsigned_long", NumberType::uint64}, {"vtkidtype", NumberType::int32},      {"vtktypeint64", NumberType::int64}};
  for (const auto& [name, type] : names)
    if (name == word) return type;
  return {};
}

/// Arrays of numbers, as words or as bytes.
class Arrays {
 public:
  Arrays(std::string_view bytes, const std::string& name) : words{bytes}, name_(name) {}
  WordReader words;
  bool binary = false;

  std::optional<Error> reals(std::int64_t count, NumberType type, std::vector<double>& values) {
    if (auto error = begin(count, type)) return error;
    values.resize(static_cast<std::size_t>(count));
    for (auto& value : values) {
      if (binary) {
        value = load_real(words.text.data() + words.at, type, true);
        words.at += size_of(type);
      } else if (const auto word = words.next(); !to_real(word, value)) {
        return at_line(name_, words.line, "expected a number, found " + shown(word));
      }
    }
    return {};
  }
  std::optional<Error> integers(std::int64_t count, NumberType type, std::vector<std::int64_t>& values) {
    if (auto error = begin(count, type)) return error;
    values.resize(static_cast<std::size_t>(count));
    for (auto& value : values) {
      if (binary) {
        value = load_integer(words.text.data() + words.at, type, true);
        words.at += size_of(type);
      } else if (const auto word = words.next(); !to_integer(word, value)) {
        return at_line(name_, words.line, "expected a whole number, found " + shown(word));
      }
    }
    return {};
  }

 private:
  const std::string& name_;
  std::optional<Error> begin(std::int64_t count, NumberType type) {
    if (binary) {
      words.skip_line();
      if (words.at < words.text.size() && words.text[words.at] == '\r') ++words.at;
      if (words.at < words.text.size() && words.text[words.at] == '\n') ++words.at;
    }
    const auto left = words.text.size() - words.at;
    const auto room = binary ? left / size_of(type) : (left + 1) / 2;
    if (count < 0 || static_cast<std::uint64_t>(count) > room)
      return bad_input(name_ + ": expected " + std::to_string(count) + " numbers, found room for " + std::to_string(room));
    return {};
  }
};

}  // namespace

Result<RawGeometry> parse_vtk(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  raw.format = "VTK";
  Arrays arrays(bytes, name);
  auto& words = arrays.words;
  LineReader lines{bytes};
  std::string_view line;
  if (!lines.next(line) || line.substr(0, 14) != "# vtk DataFile")
    return at_line(name, 1, "expected '# vtk DataFile Version', found " + shown(line));
  double version = 3;
  to_real(line.substr(std::min(line.size(), line.find_last_of(" \t") + 1)), version);
  lines.next(line);  // a title
  lines.next_filled(line);
  const auto kind = next_word(line);
  if (kind != "ASCII" && kind != "BINARY") return at_line(name, lines.line, "expected ASCII or BINARY, found " + shown(kind));
  arrays.binary = kind == "BINARY";
  words.at = std::min(lines.at, bytes.size());
  words.line = lines.line + 1;
  if (words.next() != "DATASET") return at_line(name, words.line, "expected 'DATASET POLYDATA'");
  if (const auto dataset = words.next(); dataset != "POLYDATA")
    return at_line(name, words.line, "expected a POLYDATA dataset, found " + shown(dataset));

  Faces faces;
  bool points_seen = false;
  std::vector<double> values;
  std::vector<std::int64_t> cells, offsets;
  const auto count_of = [&](std::int64_t& count) { return to_integer(words.next(), count) && count >= 0; };
  const auto type_of = [&] { return number_type(lower_case(words.next())); };
  const auto bad_count = [&] { return at_line(name, words.line, "expected a number and a type"); };
  for (auto word = words.next(); !word.empty(); word = words.next()) {
    const std::string key(word);
    std::int64_t count = 0, size = 0;
    if (key == "POINTS") {
      if (!count_of(count)) return bad_count();
      const auto type = type_of();
      if (!type || count > std::int64_t(1) << 40) return bad_count();
      if (auto error = arrays.reals(3 * count, *type, values)) return *error;
      points_seen = true;
      for (std::size_t i = 0; i + 2 < values.size(); i += 3) raw.cloud.points.emplace_back(values[i], values[i + 1], values[i + 2]);
    } else if (key == "VERTICES" || key == "LINES" || key == "POLYGONS" || key == "TRIANGLE_STRIPS") {
      if (!count_of(count) || !count_of(size)) return bad_count();
      std::vector<std::int64_t> cell;
      const auto add = [&](std::size_t from, std::size_t to) {
        if (key == "POLYGONS") {
          for (std::size_t i = from; i < to; ++i)
            if (!faces.add_corner(cells[i])) return false;
          faces.end_face();
          return true;
        }
        if (key != "TRIANGLE_STRIPS") return true;
        cell.assign(cells.begin() + static_cast<std::ptrdiff_t>(from), cells.begin() + static_cast<std::ptrdiff_t>(to));
        return faces.add_strip(cell);
      };
      const auto bad_cell = [&] { return bad_input(name + ": expected vertex indices in " + key + ", found others"); };
      if (version >= 5) {  // offsets and connectivity apart
        if (words.next() != "OFFSETS") return at_line(name, words.line, "expected OFFSETS after " + key);
        auto type = type_of();
        if (!type) return bad_count();
        if (auto error = arrays.integers(count, *type, offsets)) return *error;
        if (words.next() != "CONNECTIVITY") return at_line(name, words.line, "expected CONNECTIVITY after OFFSETS");
        if (type = type_of(); !type) return bad_count();
        if (auto error = arrays.integers(size, *type, cells)) return *error;
        for (std::size_t i = 0; i + 1 < offsets.size(); ++i) {
          if (offsets[i] < 0 || offsets[i] > offsets[i + 1] || offsets[i + 1] > size) return bad_cell();
          if (!add(static_cast<std::size_t>(offsets[i]), static_cast<std::size_t>(offsets[i + 1]))) return bad_cell();
        }
      } else {
        if (auto error = arrays.integers(size, NumberType::int32, cells)) return *error;
        std::size_t at = 0;
        for (std::int64_t i = 0; i < count; ++i) {
          if (at >= cells.size() || cells[at] < 0 || static_cast<std::uint64_t>(cells[at]) > cells.size() - at - 1)
            return bad_input(name + ": expected " + std::to_string(count) + " cells in " + key + ", found " + std::to_string(i));
          const auto end = at + 1 + static_cast<std::size_t>(cells[at]);
          if (!add(at + 1, end)) return bad_cell();
          at = end;
        }
      }
    } else if (key == "POINT_DATA") {
      if (!count_of(count)) return bad_count();
      // Only normals that stand first are worth having; other attributes end the reading.
      const auto before = words;
      if (words.next() != "NORMALS" || count != static_cast<std::int64_t>(raw.cloud.size())) {
        words = before;
        break;
      }
      words.next();
      const auto type = type_of();
      if (!type) return bad_count();
      if (auto error = arrays.reals(3 * count, *type, values)) return *error;
      for (std::size_t i = 0; i + 2 < values.size(); i += 3) raw.cloud.normals.emplace_back(values[i], values[i + 1], values[i + 2]);
      break;
    } else if (key == "FIELD" && !points_seen) {
      words.next();  // its name
      if (!count_of(count)) return bad_count();
      for (std::int64_t i = 0; i < count; ++i) {
        const std::string array(words.next());
        if (!count_of(size)) return bad_count();
        std::int64_t tuples = 0;
        if (!count_of(tuples) || (tuples > 0 && size > (std::int64_t(1) << 40) / tuples)) return bad_count();
        const auto type = type_of();
        if (!type) return at_line(name, words.line, "expected an array of numbers in FIELD, found " + shown(array));
        if (auto error = arrays.reals(size * tuples, *type, values)) return *error;
      }
    } else if (key == "CELL_DATA" || key == "FIELD") {
      break;
    } else if (key == "METADATA") {
      // A block of text up to a blank line.
      LineReader block{bytes, words.at, words.line};
      block.next(line);
      while (block.next(line) && line.find_first_not_of(" \t") != std::string_view::npos) {}
      words.at = std::min(block.at, bytes.size());
    } else {
      return at_line(name, words.line, "expected POINTS, POLYGONS or TRIANGLE_STRIPS, found " + shown(key));
    }
  }
  if (!points_seen) return bad_input(name + ": expected POINTS, found none");
  if (auto error = cut_faces(faces, name, raw)) return *error;
  return raw;
}

}  // namespace partscribe::formats
