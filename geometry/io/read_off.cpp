/// OFF, with the normals, colours and texture coordinates of its relatives passed over or read.
#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {

Result<RawGeometry> parse_off(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  raw.format = "OFF";
  LineReader lines{bytes};
  std::string_view rest;
  // Delivers lines that hold more than a comment, the comment cut off.
  const auto next = [&] {
    while (lines.next_filled(rest)) {
      rest = rest.substr(0, rest.find('#'));
      if (rest.find_first_not_of(" \t") != std::string_view::npos) return true;
    }
    return false;
  };
  if (!next()) return bad_input(name + ": expected 'OFF', found nothing");
  bool normals = false;
  auto word = next_word(rest);
  if (const auto key = word; key.size() >= 3 && key.substr(key.size() - 3) == "OFF") {
    const auto prefix = key.substr(0, key.size() - 3);
    if (prefix.find_first_of("4n") != std::string_view::npos)
      return at_line(name, lines.line, "expected points in space, found " + shown(key));
    normals = prefix.find('N') != std::string_view::npos;
    word = next_word(rest);
    if (word == "BINARY")
      return at_line(name, lines.line, "binary OFF files are not supported; save as text, PLY or STL");
    if (word.empty()) {
      if (!next()) return bad_input(name + ": expected the numbers of vertices and faces, found the end of the file");
      word = next_word(rest);
    }
  }
  std::int64_t vertices = 0, faces = 0;
  if (!to_integer(word, vertices) || vertices < 0)
    return at_line(name, lines.line, "expected the number of vertices, found " + shown(word));
  word = next_word(rest);
  if (!to_integer(word, faces) || faces < 0)
    return at_line(name, lines.line, "expected the number of faces, found " + shown(word));
  for (std::int64_t i = 0; i < vertices; ++i) {
    if (!next())
      return at_line(
          name, lines.line,
          "expected " + std::to_string(vertices) + " vertices, found the end of the file after " + std::to_string(i));
    Vec3 p, n;
    for (int k = 0; k < 3; ++k)
      if (word = next_word(rest); !to_real(word, p[k]))
        return at_line(name, lines.line, "expected 3 coordinates, found " + shown(word));
    raw.cloud.points.push_back(p);
    if (!normals) continue;
    for (int k = 0; k < 3; ++k)
      if (word = next_word(rest); !to_real(word, n[k]))
        return at_line(name, lines.line, "expected a normal after the coordinates, found " + shown(word));
    raw.cloud.normals.push_back(n);
  }
  FilePolygons polygons;
  for (std::int64_t f = 0; f < faces; ++f) {
    if (!next())
      return at_line(
          name, lines.line,
          "expected " + std::to_string(faces) + " faces, found the end of the file after " + std::to_string(f));
    std::int64_t count = 0, index = 0;
    word = next_word(rest);
    if (!to_integer(word, count) || count < 0)
      return at_line(name, lines.line, "expected a number of corners, found " + shown(word));
    for (std::int64_t k = 0; k < count; ++k)
      if (word = next_word(rest); !to_integer(word, index) || !polygons.add_corner(index))
        return at_line(name, lines.line,
                       "expected a vertex index from 0 to " + std::to_string(vertices - 1) + ", found " + shown(word));
    polygons.end_face();
  }
  if (auto error = cut_faces(polygons, name, raw)) return *error;
  return raw;
}

}  // namespace partscribe::geometry::formats
