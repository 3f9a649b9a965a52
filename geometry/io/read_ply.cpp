/// PLY: ascii and both binaries, points, polygons, triangle strips and range grids.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

struct Property {
  std::string name;
  NumberType type = NumberType::float32;
  bool list = false;
  NumberType count_type = NumberType::uint8;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
  bool has_list() const {
    return std::any_of(properties.begin(), properties.end(), [](const auto& p) { return p.list; });
  }
  /// Bytes of the smallest possible record.
  std::size_t least_size(bool ascii) const {
    if (ascii) return properties.empty() ? 0 : 2 * properties.size() - 1;
    std::size_t sum = 0;
    for (const auto& p : properties) sum += size_of(p.list ? p.count_type : p.type);
    return sum;
  }
};

struct Header {
  bool ascii = true, swapped = false, millimetres = false;
  std::vector<Element> elements;
  int columns = 0, rows = 0;  ///< of a range grid
  std::size_t data = 0, lines = 0;
};

std::optional<NumberType> number_type(std::string_view word) {
  static constexpr std::pair<std::string_view, NumberType> names[] = {
      {"char", NumberType::int8},       {"int8", NumberType::int8},       {"uchar", NumberType::uint8},
      {"uint8", NumberType::uint8},     {"short", NumberType::int16},     {"int16", NumberType::int16},
      {"ushort", NumberType::uint16},   {"uint16", NumberType::uint16},   {"int", NumberType::int32},
      {"int32", NumberType::int32},     {"uint", NumberType::uint32},     {"uint32", NumberType::uint32},
      {"float", NumberType::float32},   {"float32", NumberType::float32}, {"double", NumberType::float64},
      {"float64", NumberType::float64}, {"int64", NumberType::int64},     {"uint64", NumberType::uint64}};
  for (const auto& [name, type] : names)
    if (name == word) return type;
  return {};
}

Result<Header> parse_header(std::string_view bytes, const std::string& name) {
  Header header;
  LineReader lines{bytes};
  std::string_view line;
  if (!lines.next(line) || next_word(line) != "ply")
    return at_line(name, 1,
                   "expected 'ply', found " + shown(bytes.substr(0, std::min(bytes.find('\n'), bytes.size()))));
  bool has_format = false;
  while (lines.next(line)) {
    std::string_view rest = line;
    const auto key = next_word(rest);
    if (key == "end_header") {
      if (!has_format) return at_line(name, lines.line, "expected a 'format' line before 'end_header', found none");
      header.data = std::min(lines.at, bytes.size());
      header.lines = lines.line;
      return header;
    }
    if (key == "format") {
      const auto format = next_word(rest);
      has_format = true;
      header.ascii = format == "ascii";
      header.swapped = format == "binary_big_endian";
      if (!header.ascii && !header.swapped && format != "binary_little_endian")
        return at_line(name, lines.line,
                       "expected ascii, binary_little_endian or binary_big_endian, found " + shown(format));
    } else if (key == "obj_info") {
      const auto what = next_word(rest);
      std::int64_t value = 0;
      if (what == "num_cols" && to_integer(next_word(rest), value) && value > 0 && value < 1'000'000)
        header.columns = static_cast<int>(value);
      if (what == "num_rows" && to_integer(next_word(rest), value) && value > 0 && value < 1'000'000)
        header.rows = static_cast<int>(value);
    } else if (key == "element") {
      Element element;
      element.name = next_word(rest);
      std::int64_t count = -1;
      const auto word = next_word(rest);
      if (!to_integer(word, count) || count < 0)
        return at_line(name, lines.line, "expected a number of '" + element.name + "', found " + shown(word));
      element.count = static_cast<std::uint64_t>(count);
      header.elements.push_back(element);
    } else if (key == "property") {
      if (header.elements.empty()) return at_line(name, lines.line, "expected 'element' before 'property'");
      Property property;
      auto word = next_word(rest);
      if (word == "list") {
        property.list = true;
        word = next_word(rest);
        const auto count_type = number_type(word);
        if (!count_type) return at_line(name, lines.line, "expected a number type, found " + shown(word));
        property.count_type = *count_type;
        word = next_word(rest);
      }
      const auto type = number_type(word);
      if (!type) return at_line(name, lines.line, "expected a number type, found " + shown(word));
      property.type = *type;
      property.name = lower_case(next_word(rest));
      header.elements.back().properties.push_back(property);
      if (header.elements.back().properties.size() > 10'000)
        return at_line(name, lines.line, "expected fewer than 10000 properties");
    } else if (key == "comment") {
      if (next_word(rest) == "millimetres" && next_word(rest).empty())
        header.millimetres = true;  // our own files say so
    } else if (!key.empty()) {
      return at_line(name, lines.line, "expected a PLY header line, found " + shown(line));
    }
    if (lines.line > 100'000) break;
  }
  return at_line(name, lines.line, "expected 'end_header', found the end of the file");
}

/// The records of a file one after the other, whichever way they are written.
class Records {
 public:
  Records(std::string_view bytes, const Header& header, const std::string& name)
      : bytes_(bytes), header_(header), name_(name), at_(header.data) {
    lines_ = {bytes, header.data, header.lines};
  }
  std::size_t remaining() const { return bytes_.size() - (header_.ascii ? std::min(lines_.at, bytes_.size()) : at_); }

  /// Must be called before the first field of each record.
  std::optional<Error> begin(const Element& element, std::uint64_t index) {
    element_ = &element;
    index_ = index;
    if (header_.ascii && !element.properties.empty() && !lines_.next_filled(line_)) return short_file();
    return {};
  }
  std::optional<Error> real(NumberType type, double& value) {
    if (header_.ascii) {
      const auto word = next_word(line_);
      if (!to_real(word, value)) return expected_number(word);
      return {};
    }
    const auto size = size_of(type);
    if (bytes_.size() - at_ < size) return short_file();
    value = load_real(bytes_.data() + at_, type, header_.swapped);
    at_ += size;
    return {};
  }
  std::optional<Error> integer(NumberType type, std::int64_t& value) {
    if (header_.ascii) {
      const auto word = next_word(line_);
      if (!to_integer(word, value)) {
        double real = 0;
        if (!to_real(word, real)) return expected_number(word);
        value = std::abs(real) < 4e18 ? static_cast<std::int64_t>(real) : -1;
      }
      return {};
    }
    const auto size = size_of(type);
    if (bytes_.size() - at_ < size) return short_file();
    value = load_integer(bytes_.data() + at_, type, header_.swapped);
    at_ += size;
    return {};
  }
  std::optional<Error> list(const Property& property, std::vector<std::int64_t>& values) {
    std::int64_t count = 0;
    if (auto error = integer(property.count_type, count)) return error;
    const auto room = header_.ascii ? line_.size() : (bytes_.size() - at_) / size_of(property.type);
    if (count < 0 || static_cast<std::uint64_t>(count) > room)
      return failure("expected at most " + std::to_string(room) + " list entries, found a count of " +
                     std::to_string(count));
    values.resize(static_cast<std::size_t>(count));
    for (auto& value : values)
      if (auto error = integer(property.type, value)) return error;
    return {};
  }
  Error failure(const std::string& message) const {
    return header_.ascii ? at_line(name_, lines_.line, message) : at_byte(name_, at_, message);
  }

 private:
  std::string_view bytes_;
  const Header& header_;
  const std::string& name_;
  std::size_t at_;
  LineReader lines_;
  std::string_view line_;
  const Element* element_ = nullptr;
  std::uint64_t index_ = 0;

  Error short_file() const {
    return failure("expected " + std::to_string(element_->count) + " " + element_->name +
                   " records, found the end of the file after " + std::to_string(index_));
  }
  Error expected_number(std::string_view word) const {
    return failure("expected " + std::to_string(element_->properties.size()) + " numbers of a " + element_->name +
                   ", found " + shown(word));
  }
};

/// Where each wanted property of a vertex goes.
enum Column { x, y, z, nx, ny, nz, ray_x, ray_y, ray_z, sigma, view, pixel, rejected, column_count };
constexpr std::string_view column_names[] = {"x",     "y",     "z",     "nx",   "ny",    "nz",      "ray_x",
                                             "ray_y", "ray_z", "sigma", "view", "pixel", "rejected"};

int column_of(const std::string& name) {
  for (int i = 0; i < column_count; ++i)
    if (column_names[i] == name) return i;
  static constexpr std::string_view normals[] = {"normal_x", "normal_y", "normal_z"};
  for (int i = 0; i < 3; ++i)
    if (normals[i] == name) return nx + i;
  return -1;
}

std::int32_t to_int32(double value) { return std::abs(value) < 2147483647.0 ? static_cast<std::int32_t>(value) : -1; }

std::optional<Error> read_vertices(const Element& element, Records& records, const std::string& name,
                                   RawGeometry& raw) {
  std::vector<int> target;
  std::array<bool, column_count> has{};
  for (const auto& p : element.properties) {
    target.push_back(p.list ? -1 : column_of(p.name));
    if (target.back() >= 0) has[target.back()] = true;
  }
  if (element.count > 0 && !(has[x] && has[y] && has[z]))
    return bad_input(name + ": expected the vertex properties x, y and z, found not all of them");
  auto& cloud = raw.cloud;
  const auto count = static_cast<std::size_t>(element.count);
  const bool normals = has[nx] && has[ny] && has[nz], rays = has[ray_x] && has[ray_y] && has[ray_z];
  cloud.points.reserve(count);
  if (normals) cloud.normals.reserve(count);
  if (rays) cloud.rays.reserve(count);
  std::array<double, column_count> value{};
  std::vector<std::int64_t> ignored;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if (auto error = records.begin(element, i)) return error;
    for (std::size_t p = 0; p < target.size(); ++p) {
      const auto& property = element.properties[p];
      if (property.list) {
        if (auto error = records.list(property, ignored)) return error;
        continue;
      }
      double number = 0;
      if (auto error = records.real(property.type, number)) return error;
      if (target[p] >= 0) value[target[p]] = number;
    }
    cloud.points.emplace_back(value[x], value[y], value[z]);
    if (normals) cloud.normals.emplace_back(value[nx], value[ny], value[nz]);
    if (rays) cloud.rays.emplace_back(value[ray_x], value[ray_y], value[ray_z]);
    if (has[sigma]) cloud.sigma.push_back(static_cast<float>(value[sigma]));
    if (has[view]) cloud.view.push_back(to_int32(value[view]));
    if (has[pixel]) cloud.pixel.push_back(to_int32(value[pixel]));
    if (has[rejected]) cloud.rejected.push_back(value[rejected] != 0);
  }
  return {};
}

/// Faces, strips and grids: the list of vertex indices of each record.
template <class Use>
std::optional<Error> read_lists(const Element& element, Records& records, Use&& use) {
  std::vector<std::int64_t> indices, list;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if (auto error = records.begin(element, i)) return error;
    indices.clear();
    bool found = false;
    for (const auto& property : element.properties) {
      if (!property.list) {
        double ignored = 0;
        if (auto error = records.real(property.type, ignored)) return error;
        continue;
      }
      if (auto error = records.list(property, list)) return error;
      if (property.name == "vertex_indices" || property.name == "vertex_index") indices.swap(list), found = true;
    }
    if (found && !use(i, indices))
      return records.failure("expected vertex indices that are not negative in " + element.name + " " +
                             std::to_string(i + 1) + ", found others");
  }
  return {};
}

bool add_strips(const std::vector<std::int64_t>& indices, FilePolygons& faces) {
  std::vector<std::int64_t> strip;
  for (const auto index : indices) {
    if (index >= 0) {
      strip.push_back(index);
    } else {  // -1 ends a strip
      if (!faces.add_strip(strip)) return false;
      strip.clear();
    }
  }
  return faces.add_strip(strip);
}

}  // namespace

Result<RawGeometry> parse_ply(std::string_view bytes, const std::string& name) {
  const auto header = parse_header(bytes, name);
  if (!header.ok()) return header.error();
  RawGeometry raw;
  raw.format = "PLY";
  if (header->millimetres) raw.unit = "mm";
  FilePolygons faces;
  std::vector<std::int64_t> grid;  // vertex of each grid cell, -1 where there is none
  Records records(bytes, *header, name);
  bool has_vertices = false;
  for (const auto& element : header->elements) {
    // What a header promises must fit into what is left, before anything is reserved for it.
    const auto least = element.least_size(header->ascii);
    if (least == 0) continue;
    if (element.count > (records.remaining() + (header->ascii ? 1 : 0)) / least)
      return bad_input(name + ": expected " + std::to_string(element.count) + " " + element.name +
                       " records, found room for " + std::to_string(records.remaining() / least));
    std::optional<Error> error;
    if (element.name == "vertex" && !has_vertices) {
      has_vertices = true;
      error = read_vertices(element, records, name, raw);
    } else if (element.name == "face") {
      error = read_lists(element, records, [&](std::uint64_t, const auto& indices) {
        for (const auto index : indices)
          if (!faces.add_corner(index)) return false;
        faces.end_face();
        return true;
      });
    } else if (element.name == "tristrips") {
      error = read_lists(element, records, [&](std::uint64_t, const auto& list) { return add_strips(list, faces); });
    } else if (element.name == "range_grid") {
      grid.assign(static_cast<std::size_t>(element.count), -1);
      error = read_lists(element, records, [&](std::uint64_t i, const auto& list) {
        if (!list.empty()) grid[static_cast<std::size_t>(i)] = list.front();
        return list.empty() || list.front() >= 0;
      });
    } else {
      error = read_lists(element, records, [](std::uint64_t, const auto&) { return true; });
    }
    if (error) return *error;
  }
  if (!has_vertices) return bad_input(name + ": expected an element 'vertex' in the PLY header, found none");
  if (auto error = cut_faces(faces, name, raw)) return *error;
  if (!grid.empty()) {
    const auto cells = static_cast<std::size_t>(header->columns) * static_cast<std::size_t>(header->rows);
    if (cells != grid.size()) {
      raw.warnings.push_back(name + ": num_cols times num_rows is not the size of its range grid, which is ignored");
    } else {
      raw.width = header->columns, raw.height = header->rows;
      raw.cloud.pixel.assign(raw.cloud.size(), -1);
      for (std::size_t cell = 0; cell < grid.size(); ++cell) {
        if (grid[cell] < 0) continue;
        const auto vertex = static_cast<std::uint64_t>(grid[cell]);
        if (vertex >= raw.cloud.size())
          return bad_input(name + ", range grid cell " + std::to_string(cell) + ": expected a vertex index below " +
                           std::to_string(raw.cloud.size()) + ", found " + std::to_string(vertex));
        auto& pixel = raw.cloud.pixel[vertex];
        if (pixel < 0) pixel = static_cast<std::int32_t>(cell);
      }
    }
  }
  return raw;
}

}  // namespace partscribe::geometry::formats
