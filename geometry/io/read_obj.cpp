/// OBJ: vertices, normals and polygons; materials, textures and curves are passed over.
#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

/// The vertex index in "7", "7/1", "7//3", "-2/..."; 0-based.
bool corner_index(std::string_view word, std::size_t vertices, std::int64_t& index) {
  const auto slash = word.find('/');
  if (!to_integer(word.substr(0, slash), index) || index == 0) return false;
  index = index > 0 ? index - 1 : static_cast<std::int64_t>(vertices) + index;
  return index >= 0;
}

}  // namespace

Result<RawGeometry> parse_obj(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  raw.format = "OBJ";
  FilePolygons faces;
  std::vector<Vec3> normals;
  LineReader lines{bytes};
  std::string_view line;
  std::string joined;
  std::size_t known = 0, other = 0;
  while (lines.next_filled(line)) {
    if (line.back() == '\\') {  // continued on the next line
      joined.clear();
      std::string_view part = line;
      while (!part.empty() && part.back() == '\\') {
        joined.append(part.substr(0, part.size() - 1)).push_back(' ');
        if (!lines.next(part)) part = {};
      }
      joined.append(part);
      line = joined;
    }
    const auto key = next_word(line);
    if (key == "v" || key == "vn") {
      Vec3 p;
      for (int k = 0; k < 3; ++k) {
        const auto word = next_word(line);
        if (!to_real(word, p[k]))
          return at_line(name, lines.line, "expected 3 numbers after '" + std::string(key) + "', found " + shown(word));
      }
      (key == "v" ? raw.cloud.points : normals).push_back(p);
      ++known;
    } else if (key == "f" || key == "fo") {
      for (auto word = next_word(line); !word.empty() && word.front() != '#'; word = next_word(line)) {
        std::int64_t index = 0;
        if (!corner_index(word, raw.cloud.size(), index) || !faces.add_corner(index))
          return at_line(name, lines.line,
                         "expected a vertex index from 1 to " + std::to_string(raw.cloud.size()) +
                             " or a negative one back to the first, found " + shown(word));
      }
      faces.end_face();
      ++known;
    } else if (key.front() != '#') {
      static constexpr std::string_view others[] = {"vt", "vp", "o", "g", "s", "usemtl", "mtllib", "l", "p"};
      bool expected = false;
      for (const auto& o : others) expected = expected || key == o;
      if (!expected && ++other > 100 + known)
        return at_line(name, lines.line, "expected OBJ statements (v, vn, f, ...), found " + shown(key));
    }
  }
  if (raw.cloud.empty()) return bad_input(name + ": expected vertex lines ('v x y z'), found none");
  if (faces.ends.empty() && normals.size() == raw.cloud.size()) raw.cloud.normals = std::move(normals);
  if (auto error = cut_faces(faces, name, raw)) return *error;
  return raw;
}

}  // namespace partscribe::geometry::formats
