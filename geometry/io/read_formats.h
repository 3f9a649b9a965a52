/// What the parsers behind read_geometry share: text and byte readers, faces, and the parsers' names.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "geometry/io/read_geometry.h"

namespace partscribe::geometry::formats {

/// Walks a text line by line; knows \n, \r\n and \r.
struct LineReader {
  std::string_view text;
  std::size_t at = 0;
  std::size_t line = 0;  ///< number of the line delivered last, from 1
  bool next(std::string_view& content);
  /// The next line that is not blank.
  bool next_filled(std::string_view& content);
};

/// Takes the next word off the front of `rest`; empty at the end. Blanks and tabs separate.
std::string_view next_word(std::string_view& rest);

/// Walks a text word by word across lines.
struct WordReader {
  std::string_view text;
  std::size_t at = 0;
  std::size_t line = 1;  ///< of the word delivered last
  std::string_view next();
  void skip_line();
};

/// The number that a whole word spells; NaN and infinities (in the spellings of several libraries) are numbers here.
bool to_real(std::string_view word, double& value);
bool to_integer(std::string_view word, std::int64_t& value);

std::string lower_case(std::string_view text);
/// Suffix with its dot, in lower case.
std::string suffix_of(const std::string& name);
/// A short printable quotation of what was found.
std::string shown(std::string_view found);
Error at_line(const std::string& name, std::size_t line, const std::string& message);
Error at_byte(const std::string& name, std::size_t byte, const std::string& message);

/// A number as it lies in memory.
template <class T>
T load(const char* from, bool swapped = false) {
  T value;
  if (!swapped) {
    std::memcpy(&value, from, sizeof value);
    return value;
  }
  char turned[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) turned[i] = from[sizeof(T) - 1 - i];
  std::memcpy(&value, turned, sizeof value);
  return value;
}

/// Types of numbers in binary files.
enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };
std::size_t size_of(NumberType type);
double load_real(const char* from, NumberType type, bool swapped);
std::int64_t load_integer(const char* from, NumberType type, bool swapped);

/// Polygons as a file lists them, before they are cut.
struct FilePolygons {
  std::vector<std::uint32_t> corners;
  std::vector<std::size_t> ends;  ///< one past the last corner of each face
  /// False if the index fits no mesh; other faces stay.
  bool add_corner(std::int64_t index);
  void end_face() { ends.push_back(corners.size()); }
  /// Triangles of a strip; false as add_corner.
  bool add_strip(const std::vector<std::int64_t>& strip);
};

/// Makes `raw.mesh` of `raw.cloud.points` and the faces. Convex polygons are cut into fans, others by ears.
std::optional<Error> cut_faces(const FilePolygons& faces, const std::string& name, RawGeometry& raw);

Result<RawGeometry> parse_ply(std::string_view bytes, const std::string& name);
Result<RawGeometry> parse_stl(std::string_view bytes, const std::string& name);
Result<RawGeometry> parse_obj(std::string_view bytes, const std::string& name);
Result<RawGeometry> parse_off(std::string_view bytes, const std::string& name);
Result<RawGeometry> parse_pcd(std::string_view bytes, const std::string& name);
Result<RawGeometry> parse_xyz(std::string_view bytes, const std::string& name);
Result<RawGeometry> parse_vtk(std::string_view bytes, const std::string& name);
Result<RawGeometry> parse_3mf(std::string_view bytes, const std::string& name);

/// True for bytes whose length is exactly that of a binary STL file.
bool is_binary_stl(std::string_view bytes);

}  // namespace partscribe::geometry::formats
