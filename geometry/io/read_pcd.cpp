/// PCD: ascii, binary and binary_compressed, organised or not.
#include <array>

#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

struct Field {
  std::string name;                  // "_": padding
  std::int64_t size = 4, count = 1;  // drivers of lidars write padding of count 0: no bytes and no column
  char type = 'F';
};

std::optional<NumberType> number_type(const Field& field) {
  if (field.type == 'F' && field.size == 4) return NumberType::float32;
  if (field.type == 'F' && field.size == 8) return NumberType::float64;
  static constexpr NumberType integers[] = {NumberType::int8, NumberType::int16, NumberType::int32, NumberType::int64};
  static constexpr NumberType naturals[] = {NumberType::uint8, NumberType::uint16, NumberType::uint32,
                                            NumberType::uint64};
  const int index = field.size == 1 ? 0 : field.size == 2 ? 1 : field.size == 4 ? 2 : field.size == 8 ? 3 : -1;
  if (index < 0 || (field.type != 'I' && field.type != 'U')) return {};
  return field.type == 'I' ? integers[index] : naturals[index];
}

/// LZF: a control byte below 32 starts a run of literals; others copy earlier output.
bool expand_lzf(std::string_view in, std::size_t size, std::string& out) {
  out.reserve(size);
  for (std::size_t at = 0; at < in.size();) {
    const auto control = static_cast<unsigned char>(in[at++]);
    if (control < 32) {
      const std::size_t length = control + 1u;
      if (in.size() - at < length || size - out.size() < length) return false;
      out.append(in.substr(at, length));
      at += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (at >= in.size()) return false;
      length += static_cast<unsigned char>(in[at++]);
    }
    length += 2;
    if (at >= in.size()) return false;
    const std::size_t back = ((control & 31u) << 8 | static_cast<unsigned char>(in[at++])) + 1u;
    if (back > out.size() || size - out.size() < length) return false;
    for (std::size_t i = 0, from = out.size() - back; i < length; ++i) out.push_back(out[from + i]);
  }
  return out.size() == size;
}

constexpr std::string_view wanted[] = {"x", "y", "z", "normal_x", "normal_y", "normal_z"};

}  // namespace

Result<RawGeometry> parse_pcd(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  raw.format = "PCD";
  std::vector<Field> fields;
  std::int64_t width = 0, height = 1, count = -1;
  std::string data;
  LineReader lines{bytes};
  std::string_view rest;
  while (data.empty() && lines.next_filled(rest)) {
    const auto key = next_word(rest);
    std::int64_t value = 0;
    if (key == "FIELDS" || key == "COLUMNS") {
      for (auto word = next_word(rest); !word.empty(); word = next_word(rest)) {
        fields.emplace_back();
        fields.back().name = word;
      }
    } else if (key == "SIZE" || key == "COUNT" || key == "TYPE") {
      for (auto& field : fields) {
        const auto word = next_word(rest);
        if (key == "TYPE" && word.size() == 1) {
          field.type = word[0];
        } else if (key == "TYPE" || !to_integer(word, value) || value < (key == "COUNT" ? 0 : 1) || value > 100'000) {
          return at_line(name, lines.line, "expected a " + std::string(key) + " for each field, found " + shown(word));
        } else {
          (key == "SIZE" ? field.size : field.count) = value;
        }
      }
    } else if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
      const auto word = next_word(rest);
      if (!to_integer(word, value) || value < 0 || value > (std::int64_t(1) << 40))
        return at_line(name, lines.line, "expected a number after " + std::string(key) + ", found " + shown(word));
      (key == "WIDTH" ? width : key == "HEIGHT" ? height : count) = value;
    } else if (key == "DATA") {
      data = next_word(rest);
    } else if (key.front() != '#' && key != "VERSION" && key != "VIEWPOINT") {
      return at_line(name, lines.line, "expected a PCD header line, found " + shown(key));
    }
  }
  if (data != "ascii" && data != "binary" && data != "binary_compressed")
    return at_line(name, lines.line, "expected 'DATA ascii', 'binary' or 'binary_compressed', found " + shown(data));
  if (count < 0) count = width <= 1'000'000'000 && height <= 1'000'000'000 ? width * height : -1;
  if (count < 0) return bad_input(name + ": expected a number of points, found none");

  // Where x y z and the normal stand: as a column of text, as an offset in a record.
  std::array<int, 6> column, offset;
  std::array<NumberType, 6> type{};
  column.fill(-1), offset.fill(-1);
  std::int64_t columns = 0, stride = 0;
  for (const auto& field : fields) {
    for (int k = 0; k < 6; ++k) {
      if (field.name != wanted[k] || field.count != 1) continue;
      const auto t = number_type(field);
      if (!t) return bad_input(name + ": expected TYPE F, I or U of SIZE 1, 2, 4 or 8 for '" + field.name + "'");
      column[k] = static_cast<int>(columns), offset[k] = static_cast<int>(stride), type[k] = *t;
    }
    columns += field.count, stride += field.count * field.size;
    if (stride > 1'000'000) return bad_input(name + ": expected records below a megabyte");
  }
  if (column[0] < 0 || column[1] < 0 || column[2] < 0)
    return bad_input(name + ": expected the fields x, y and z, found not all of them");
  const int values = column[3] >= 0 && column[4] >= 0 && column[5] >= 0 ? 6 : 3;
  const auto add = [&](const std::array<double, 6>& v) {
    raw.cloud.points.emplace_back(v[0], v[1], v[2]);
    if (values == 6) raw.cloud.normals.emplace_back(v[3], v[4], v[5]);
  };
  const auto too_short = [&](std::uint64_t room) {
    return bad_input(name + ": expected " + std::to_string(count) + " points, found room for " + std::to_string(room));
  };
  std::array<double, 6> v{};
  const auto points = static_cast<std::uint64_t>(count);
  if (data == "ascii") {
    std::vector<std::string_view> words;
    for (std::uint64_t i = 0; i < points; ++i) {
      if (!lines.next_filled(rest)) return too_short(i);
      words.clear();
      for (auto word = next_word(rest); !word.empty(); word = next_word(rest)) words.push_back(word);
      for (int k = 0; k < values; ++k) {
        const auto c = static_cast<std::size_t>(column[k]);
        const auto word = c < words.size() ? words[c] : std::string_view();
        if (!to_real(word, v[k]))
          return at_line(name, lines.line, "expected " + std::to_string(columns) + " numbers, found " + shown(word));
      }
      add(v);
    }
  } else {
    const std::size_t begin = std::min(lines.at, bytes.size());
    std::string_view records = bytes.substr(begin);
    std::string expanded;
    const bool compressed = data == "binary_compressed";
    if (compressed) {
      if (records.size() < 8)
        return at_byte(name, begin, "expected two sizes of compressed data, found the end of the file");
      const auto packed = load<std::uint32_t>(records.data()), size = load<std::uint32_t>(records.data() + 4);
      if (packed > records.size() - 8)
        return at_byte(
            name, begin,
            "expected " + std::to_string(packed) + " compressed bytes, found " + std::to_string(records.size() - 8));
      // Three bytes of LZF never become more than 264; more cannot be honest.
      if (size / 88 > packed || !expand_lzf(records.substr(8, packed), size, expanded))
        return at_byte(name, begin + 8,
                       "expected compressed data of " + std::to_string(size) + " bytes, found damaged ones");
      records = expanded;
    }
    if (points > records.size() / static_cast<std::uint64_t>(stride))
      return too_short(records.size() / static_cast<std::uint64_t>(stride));
    raw.cloud.points.reserve(points);
    for (std::uint64_t i = 0; i < points; ++i) {
      for (int k = 0; k < values; ++k) {
        // Compressed data hold each field of all points together; only fields of count 1 are wanted.
        const auto begin_of = static_cast<std::uint64_t>(offset[k]);
        const auto at =
            compressed ? begin_of * points + i * size_of(type[k]) : i * static_cast<std::uint64_t>(stride) + begin_of;
        v[k] = load_real(records.data() + at, type[k], false);
      }
      add(v);
    }
  }
  if (height > 1 && width > 0 && width <= 1'000'000 && height <= 1'000'000 && width * height == count &&
      count < (std::int64_t(1) << 31)) {
    raw.width = static_cast<int>(width), raw.height = static_cast<int>(height);
    raw.cloud.pixel.resize(points);
    for (std::uint64_t i = 0; i < points; ++i) raw.cloud.pixel[i] = static_cast<std::int32_t>(i);
  }
  return raw;
}

}  // namespace partscribe::geometry::formats
