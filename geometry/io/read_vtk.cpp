/// VTK legacy polydata and unstructured grids of flat cells, ascii and binary (big-endian), versions up to 5.1.
#include <algorithm>
#include <map>

#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

std::optional<NumberType> number_type(const std::string& word) {
  static constexpr std::pair<std::string_view, NumberType> names[] = {
      {"float", NumberType::float32},   {"double", NumberType::float64},
      {"char", NumberType::int8},       {"unsigned_char", NumberType::uint8},
      {"short", NumberType::int16},     {"unsigned_short", NumberType::uint16},
      {"int", NumberType::int32},       {"unsigned_int", NumberType::uint32},
      {"long", NumberType::int64},      {"unsigned_long", NumberType::uint64},
      {"vtkidtype", NumberType::int32}, {"vtktypeint64", NumberType::int64}};
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
      return bad_input(name_ + ": expected " + std::to_string(count) + " numbers, found room for " +
                       std::to_string(room));
    return {};
  }
};

/// VTK's numbers of cell types.
enum CellType : std::int64_t { vertex = 1, vertices, line, lines, triangle, strip, polygon, pixel, quadrilateral };

/// "12 tetrahedra": how many cells of a type there are.
std::string cells_of_type(std::size_t count, std::int64_t type) {
  static constexpr std::pair<std::string_view, std::string_view> solids[] = {{"tetrahedron", "tetrahedra"},
                                                                             {"voxel", "voxels"},
                                                                             {"hexahedron", "hexahedra"},
                                                                             {"wedge", "wedges"},
                                                                             {"pyramid", "pyramids"}};
  const std::string number = std::to_string(count) + " ";
  if (type >= 10 && type < 15)
    return number + std::string(count == 1 ? solids[type - 10].first : solids[type - 10].second);
  return number + (count == 1 ? "cell of type " : "cells of type ") + std::to_string(type);
}

/// Cells as a file lists them: corners one after the other.
struct Cells {
  std::vector<std::int64_t> corners;
  std::vector<std::size_t> begins, ends;
};

/// `count` and `size` as the line before states them.
std::optional<Error> read_cells(Arrays& arrays, const std::string& key, double version, std::int64_t count,
                                std::int64_t size, const std::string& name, Cells& cells) {
  auto& words = arrays.words;
  const auto bad_cell = [&] { return bad_input(name + ": expected vertex indices in " + key + ", found others"); };
  cells = {};
  if (version >= 5) {  // offsets and connectivity apart
    std::vector<std::int64_t> offsets;
    const auto type_of = [&] { return number_type(lower_case(words.next())); };
    const auto no_type = [&] { return at_line(name, words.line, "expected a number and a type"); };
    if (words.next() != "OFFSETS") return at_line(name, words.line, "expected OFFSETS after " + key);
    auto type = type_of();
    if (!type) return no_type();
    if (auto error = arrays.integers(count, *type, offsets)) return error;
    if (words.next() != "CONNECTIVITY") return at_line(name, words.line, "expected CONNECTIVITY after OFFSETS");
    if (type = type_of(); !type) return no_type();
    if (auto error = arrays.integers(size, *type, cells.corners)) return error;
    for (std::size_t i = 0; i + 1 < offsets.size(); ++i) {
      if (offsets[i] < 0 || offsets[i] > offsets[i + 1] || offsets[i + 1] > size) return bad_cell();
      cells.begins.push_back(static_cast<std::size_t>(offsets[i])),
          cells.ends.push_back(static_cast<std::size_t>(offsets[i + 1]));
    }
    return {};
  }
  auto& list = cells.corners;  // each cell begins with the number of its corners
  if (auto error = arrays.integers(size, NumberType::int32, list)) return error;
  std::size_t at = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    if (at >= list.size() || list[at] < 0 || static_cast<std::uint64_t>(list[at]) > list.size() - at - 1)
      return bad_input(name + ": expected " + std::to_string(count) + " cells in " + key + ", found " +
                       std::to_string(i));
    cells.begins.push_back(at + 1);
    at += 1 + static_cast<std::size_t>(list[at]);
    cells.ends.push_back(at);
  }
  return {};
}

/// The surfaces among the cells; points and lines are none. `type_of(i)` is that of a cell; false if an index fits no
/// mesh.
template <class TypeOf>
bool add_surfaces(const Cells& cells, const TypeOf& type_of, FilePolygons& faces) {
  std::vector<std::int64_t> corners;
  for (std::size_t i = 0; i < cells.ends.size(); ++i) {
    const std::int64_t type = type_of(i);
    if (type <= lines) continue;
    corners.assign(cells.corners.begin() + static_cast<std::ptrdiff_t>(cells.begins[i]),
                   cells.corners.begin() + static_cast<std::ptrdiff_t>(cells.ends[i]));
    if (type == strip) {
      if (!faces.add_strip(corners)) return false;
      continue;
    }
    if (type == pixel && corners.size() == 4) std::swap(corners[2], corners[3]);  // listed row by row
    for (const auto corner : corners)
      if (!faces.add_corner(corner)) return false;
    faces.end_face();
  }
  return true;
}

/// Why the cells of an unstructured grid are no surface, or nothing.
std::optional<Error> not_flat(const std::vector<std::int64_t>& types, const std::string& name) {
  std::map<std::int64_t, std::size_t> others;
  for (const auto type : types)
    if (type < vertex || type > quadrilateral) ++others[type];
  if (others.empty()) return {};
  std::string found;
  for (const auto& [type, count] : others) found += (found.empty() ? "" : ", ") + cells_of_type(count, type);
  return bad_input(name + ": expected triangles, quadrilaterals or polygons only, found " + found +
                   "; extract the surface and save it as PolyData");
}

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
  if (kind != "ASCII" && kind != "BINARY")
    return at_line(name, lines.line, "expected ASCII or BINARY, found " + shown(kind));
  arrays.binary = kind == "BINARY";
  words.at = std::min(lines.at, bytes.size());
  words.line = lines.line + 1;
  if (words.next() != "DATASET") return at_line(name, words.line, "expected 'DATASET POLYDATA'");
  const auto dataset = words.next();
  const bool grid = dataset == "UNSTRUCTURED_GRID";
  if (!grid && dataset != "POLYDATA")
    return at_line(
        name, words.line,
        "expected a POLYDATA or UNSTRUCTURED_GRID dataset, found " + shown(dataset) + "; save the surface as PolyData");

  FilePolygons faces;
  bool points_seen = false;
  std::vector<double> values;
  Cells cells;  // of an unstructured grid, until their types are known
  std::vector<std::int64_t> types;
  const auto count_of = [&](std::int64_t& count) { return to_integer(words.next(), count) && count >= 0; };
  const auto type_of = [&] { return number_type(lower_case(words.next())); };
  const auto bad_cell = [&](const std::string& in) {
    return bad_input(name + ": expected vertex indices in " + in + ", found others");
  };
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
      for (std::size_t i = 0; i + 2 < values.size(); i += 3)
        raw.cloud.points.emplace_back(values[i], values[i + 1], values[i + 2]);
    } else if (key == "CELLS" && grid) {
      if (!count_of(count) || !count_of(size)) return bad_count();
      if (auto error = read_cells(arrays, key, version, count, size, name, cells)) return *error;
    } else if (key == "CELL_TYPES" && grid) {
      if (!count_of(count)) return bad_count();
      if (auto error = arrays.integers(count, NumberType::int32, types)) return *error;
    } else if (!grid && (key == "VERTICES" || key == "LINES" || key == "POLYGONS" || key == "TRIANGLE_STRIPS")) {
      if (!count_of(count) || !count_of(size)) return bad_count();
      if (auto error = read_cells(arrays, key, version, count, size, name, cells)) return *error;
      const CellType type = key == "POLYGONS" ? polygon : key == "TRIANGLE_STRIPS" ? strip : vertices;
      if (!add_surfaces(
              cells, [&](std::size_t) { return type; }, faces))
        return bad_cell(key);
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
      for (std::size_t i = 0; i + 2 < values.size(); i += 3)
        raw.cloud.normals.emplace_back(values[i], values[i + 1], values[i + 2]);
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
      while (block.next(line) && line.find_first_not_of(" \t") != std::string_view::npos) {
      }
      words.at = std::min(block.at, bytes.size());
    } else {
      const std::string wanted = grid ? "POINTS, CELLS or CELL_TYPES" : "POINTS, POLYGONS or TRIANGLE_STRIPS";
      return at_line(name, words.line, "expected " + wanted + ", found " + shown(key));
    }
  }
  if (!points_seen) return bad_input(name + ": expected POINTS, found none");
  if (grid) {
    if (types.size() != cells.ends.size())
      return bad_input(name + ": expected a type for each of " + std::to_string(cells.ends.size()) + " cells, found " +
                       std::to_string(types.size()));
    if (auto error = not_flat(types, name)) return *error;
    if (!add_surfaces(
            cells, [&](std::size_t i) { return types[i]; }, faces))
      return bad_cell("CELLS");
  }
  if (auto error = cut_faces(faces, name, raw)) return *error;
  return raw;
}

}  // namespace partscribe::geometry::formats
