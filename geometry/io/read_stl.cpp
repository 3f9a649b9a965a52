/// STL: ascii (several solids, polygons tolerated) and binary; equal vertices are united.
#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

constexpr std::size_t header_size = 84, facet_size = 50;

Result<RawGeometry> finished(RawGeometry raw, const std::string& name) {
  raw.format = "STL";
  if (raw.mesh.triangles.empty()) return bad_input(name + ": expected triangles, found none");
  const auto count = raw.mesh.triangles.size();
  raw.mesh = welded(raw.mesh, 0);
  if (raw.mesh.triangles.empty()) return bad_input(name + ": expected triangles, found only collapsed ones");
  raw.collapsed = count - raw.mesh.triangles.size();
  raw.cloud.points = raw.mesh.vertices;
  return raw;
}

bool same_word(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i)
    if ((word[i] | 0x20) != lower[i]) return false;
  return true;
}

/// What a word stands for. People's programs part the endings ("end loop") or shorten them to "end", which then closes
/// the innermost of what is open.
enum class Keyword { facet, normal, outer, loop, vertex, endloop, endfacet, solid, endsolid, unknown };

struct Inside {
  bool facet = false, loop = false;
};

Keyword keyword_of(std::string_view word, WordReader& words, const Inside& inside) {
  static constexpr std::pair<std::string_view, Keyword> names[] = {
      {"vertex", Keyword::vertex}, {"facet", Keyword::facet},       {"normal", Keyword::normal},
      {"outer", Keyword::outer},   {"loop", Keyword::loop},         {"endloop", Keyword::endloop},
      {"solid", Keyword::solid},   {"endsolid", Keyword::endsolid}, {"endfacet", Keyword::endfacet}};
  for (const auto& [name, keyword] : names)
    if (same_word(word, name)) return keyword;
  if (!same_word(word, "end")) return Keyword::unknown;
  WordReader ahead = words;
  const auto next = ahead.next();
  if (ahead.line == words.line)
    for (const auto& [name, keyword] : {std::pair{"loop", Keyword::endloop}, std::pair{"facet", Keyword::endfacet},
                                        std::pair{"solid", Keyword::endsolid}})
      if (same_word(next, name)) {
        words = ahead;
        return keyword;
      }
  return inside.loop ? Keyword::endloop : inside.facet ? Keyword::endfacet : Keyword::endsolid;
}

Result<RawGeometry> parse_ascii(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  WordReader words{bytes};
  std::vector<std::uint32_t> loop;
  Inside inside;
  bool ended = false;
  if (const auto first = words.next(); !same_word(first, "solid"))
    return at_line(name, 1, "expected 'solid' or a binary STL file of matching length, found " + shown(first));
  words.skip_line();
  for (auto word = words.next(); !word.empty(); word = words.next()) {
    const Keyword keyword = keyword_of(word, words, inside);
    switch (keyword) {
      case Keyword::vertex: {
        if (!inside.loop) return at_line(name, words.line, "expected 'outer loop' before 'vertex'");
        Vec3 p;
        for (int k = 0; k < 3; ++k) {
          const auto number = words.next();
          if (!to_real(number, p[k]))
            return at_line(name, words.line, "expected 3 coordinates of a vertex, found " + shown(number));
        }
        loop.push_back(static_cast<std::uint32_t>(raw.mesh.vertices.size()));
        raw.mesh.vertices.push_back(p);
        break;
      }
      case Keyword::loop:
        if (inside.loop) return at_line(name, words.line, "expected 'endloop' before the next 'loop'");
        inside.loop = true;
        break;
      case Keyword::endloop:
        if (loop.size() < 3)
          return at_line(name, words.line, "expected 3 vertices in a loop, found " + std::to_string(loop.size()));
        for (std::size_t i = 1; i + 1 < loop.size(); ++i) raw.mesh.triangles.push_back({loop[0], loop[i], loop[i + 1]});
        loop.clear();
        inside.loop = false;
        break;
      case Keyword::facet:
      case Keyword::endfacet:
        inside.facet = keyword == Keyword::facet;
        break;
      case Keyword::solid:
      case Keyword::endsolid:
        ended = keyword == Keyword::endsolid;
        words.skip_line();  // the name may contain anything
        break;
      case Keyword::normal:
        for (int k = 0; k < 3; ++k) words.next();
        break;  // the corners tell it better
      case Keyword::outer:
        break;
      case Keyword::unknown:
        return at_line(name, words.line, "expected an STL keyword, found " + shown(word));
    }
  }
  if (inside.loop) return at_line(name, words.line, "expected 'endloop', found the end of the file");
  if (!ended) raw.warnings.push_back(name + ": ends without 'endsolid'; it may have been cut off");
  return finished(std::move(raw), name);
}

Result<RawGeometry> parse_binary(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  if (bytes.size() < header_size)
    return bad_input(name + ": expected at least 84 bytes of a binary STL file, found " + std::to_string(bytes.size()));
  std::uint64_t count = load<std::uint32_t>(bytes.data() + 80);
  const std::uint64_t room = (bytes.size() - header_size) / facet_size;
  const bool whole = (bytes.size() - header_size) % facet_size == 0;
  if ((count == 0 || count == 0xFFFFFFFFu) && room > 0 && whole) {
    // Programs that stream never come back to fill the count in.
    raw.warnings.push_back(name + ": the triangle count was never filled in; " + std::to_string(room) + " read");
    count = room;
  }
  if (count > room)
    return bad_input(name + ": expected " + std::to_string(count) + " triangles, found room for " +
                     std::to_string(room));
  if (bytes.size() > header_size + count * facet_size)
    raw.warnings.push_back(name + ": " + std::to_string(bytes.size() - header_size - count * facet_size) +
                           " bytes after the last triangle ignored");
  raw.mesh.vertices.reserve(count * 3);
  raw.mesh.triangles.reserve(count);
  for (std::uint64_t t = 0; t < count; ++t) {
    const char* facet = bytes.data() + header_size + t * facet_size + 12;
    const auto first = static_cast<std::uint32_t>(raw.mesh.vertices.size());
    for (int k = 0; k < 3; ++k)
      raw.mesh.vertices.emplace_back(load<float>(facet + 12 * k), load<float>(facet + 12 * k + 4),
                                     load<float>(facet + 12 * k + 8));
    raw.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return finished(std::move(raw), name);
}

}  // namespace

bool is_binary_stl(std::string_view bytes) {
  return bytes.size() >= header_size &&
         bytes.size() == header_size + facet_size * std::uint64_t(load<std::uint32_t>(bytes.data() + 80));
}

Result<RawGeometry> parse_stl(std::string_view bytes, const std::string& name) {
  if (is_binary_stl(bytes) && bytes.size() > header_size) return parse_binary(bytes, name);
  // "solid" proves nothing: binary files begin with it too; zero bytes never stand in text.
  const bool text = bytes.substr(0, 4096).find('\0') == std::string_view::npos;
  return text ? parse_ascii(bytes, name) : parse_binary(bytes, name);
}

}  // namespace partscribe::geometry::formats
