/// Recognises a file's format, lets its parser work, and removes what is no place in space or only repeats one.
#include "geometry/io/read_geometry.h"

#include <algorithm>
#include <cmath>

#include "geometry/io/read_formats.h"
#include "geometry/points/keep_points.h"
#include "geometry/points/place.h"
#include "geometry/points/repeated_places.h"

namespace partscribe::geometry {
namespace {

using formats::LineReader, formats::next_word, formats::suffix_of, formats::to_real;
using Parser = Result<RawGeometry> (*)(std::string_view, const std::string&);

bool starts_with(std::string_view bytes, std::string_view what) { return bytes.substr(0, what.size()) == what; }

/// Formats that people do try, with what to do instead.
std::optional<std::string> refusal(std::string_view bytes, const std::string& suffix) {
  if (starts_with(bytes, "ASTM-E57")) return "E57 files are not supported; export the scan as PLY";
  if (starts_with(bytes, "\x89PNG")) return "this is a PNG image; a range image needs a .json file of the same name";
  if (starts_with(bytes, "P5") && bytes.size() > 2 && std::isspace(static_cast<unsigned char>(bytes[2])))
    return "this is a PGM image; a range image needs a .json file of the same name";
  if (starts_with(bytes, "\x1f\x8b")) return "this is a gzip archive; unpack it first";
  if (starts_with(bytes, "\x93NUMPY")) return "NumPy arrays are not supported; export the points as PLY or text";
  if (starts_with(bytes, "LASF")) return "LAS and LAZ files are not supported; export the points as PLY or text";
  if (starts_with(bytes, "glTF")) return "glTF files are not supported; export the mesh as PLY or STL";
  if (starts_with(bytes, "ISO-10303-21")) return "this is a STEP file: CAD, not a scan; use its triangulation (STL)";
  // Lines of numbers and words: the reader of text points would find some in them.
  if (suffix == ".igs" || suffix == ".iges" || suffix == ".scad" || suffix == ".scl" || suffix == ".brep")
    return "this is CAD, not a scan; use its triangulation (STL)";
  if (bytes.substr(0, 400).find("<VTKFile") != std::string_view::npos)
    return "VTK's XML files are not supported; save as legacy .vtk, PLY or STL";
  if (starts_with(bytes, "{\n") || starts_with(bytes, "{\r") || starts_with(bytes, "{\""))
    return "this is a JSON document, not points or a mesh";
  return {};
}

bool looks_like_off(std::string_view bytes) {
  std::string_view head = bytes.substr(0, 80);
  if (const auto end = head.find_first_of("\r\n"); end != std::string_view::npos) head = head.substr(0, end);
  const auto word = next_word(head);
  return word == "OFF" || (word.size() <= 7 && word.size() > 3 && word.substr(word.size() - 3) == "OFF" &&
                           word.find_first_not_of("STCNOF4n") == std::string_view::npos);
}

bool looks_like_obj(std::string_view bytes) {
  LineReader lines{bytes.substr(0, 4096)};
  std::string_view line;
  while (lines.next_filled(line)) {
    const auto word = next_word(line);
    double value;
    if (word.front() == '#' || word == "mtllib" || word == "o" || word == "g" || word == "usemtl") continue;
    return word == "v" && to_real(next_word(line), value);
  }
  return false;
}

Parser parser_for(std::string_view bytes, const std::string& name) {
  using namespace formats;
  const auto suffix = suffix_of(name);
  if (starts_with(bytes, "ply\n") || starts_with(bytes, "ply\r") || starts_with(bytes, "ply ")) return parse_ply;
  if (starts_with(bytes, "PK\x03\x04")) return parse_3mf;
  if (starts_with(bytes, "# .PCD")) return parse_pcd;
  if (starts_with(bytes, "# vtk DataFile")) return parse_vtk;
  if (looks_like_off(bytes)) return parse_off;
  if (suffix == ".stl") return parse_stl;
  if (lower_case(bytes.substr(0, 6)) == "solid " &&
      lower_case(bytes.substr(0, 4096)).find("facet") != std::string::npos)
    return parse_stl;
  if (suffix == ".ply") return parse_ply;
  if (suffix == ".obj") return parse_obj;
  if (suffix == ".off") return parse_off;
  if (suffix == ".pcd") return parse_pcd;
  if (suffix == ".vtk") return parse_vtk;
  if (suffix == ".3mf") return parse_3mf;
  const bool binary = bytes.substr(0, 4096).find('\0') != std::string_view::npos;
  if (binary) return is_binary_stl(bytes) ? parse_stl : nullptr;
  if (suffix == ".xyz" || suffix == ".asc" || suffix == ".pts" || suffix == ".txt" || suffix == ".csv")
    return parse_xyz;
  return looks_like_obj(bytes) ? parse_obj : parse_xyz;
}

/// Drops the other points and the triangles on them.
void keep(RawGeometry& raw, const std::vector<std::uint8_t>& good) {
  std::vector<std::uint32_t> index(good.size());
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < good.size(); ++i) index[i] = next, next += good[i] != 0;
  std::erase_if(raw.mesh.triangles, [&](const auto& t) { return !good[t[0]] || !good[t[1]] || !good[t[2]]; });
  for (auto& t : raw.mesh.triangles)
    for (auto& corner : t) corner = index[corner];
  keep_points(raw.cloud, good);
  if (!raw.mesh.vertices.empty()) raw.mesh.vertices = raw.cloud.points;
}

/// An organised cloud is an image of a sensor.
bool organised(const RawGeometry& raw) { return raw.width > 0; }

/// Drops points that are no places.
std::optional<Error> drop_no_places(RawGeometry& raw, const std::string& name) {
  const auto& points = raw.cloud.points;
  std::vector<std::uint8_t> good(points.size());
  std::size_t bad = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    good[i] = is_place(points[i]);
    bad += !good[i];
  }
  if (bad == 0) return {};
  const auto count = std::to_string(bad) + " of " + std::to_string(points.size());
  if (bad == points.size() || (2 * bad >= points.size() && !organised(raw)))
    return bad_input(name + ": expected finite coordinates, found none in " + count + " points");
  // In an image NaN is the ordinary mark of a pixel without return.
  if (!organised(raw)) raw.warnings.push_back(name + ": " + count + " points without finite coordinates left out");
  keep(raw, good);
  return {};
}

/// Drops points of a cloud that only repeat a place.
std::optional<Error> drop_repeated(RawGeometry& raw, const std::string& name) {
  if (!raw.mesh.triangles.empty()) return {};
  const auto repeated = repeated_places(raw.cloud.points, organised(raw));
  if (repeated.kept.empty()) return {};
  const auto of = " of " + std::to_string(raw.cloud.size()) + " points ";
  if (repeated.zeros == raw.cloud.size())
    return bad_input(name + ": expected points, found only " + std::to_string(repeated.zeros) +
                     " that are exactly 0 0 0");
  if (repeated.zeros)
    raw.warnings.push_back(name + ": " + std::to_string(repeated.zeros) + of +
                           "are exactly 0 0 0, as sensors write missing returns; left out");
  if (repeated.copies)
    raw.warnings.push_back(
        name + ": " + std::to_string(repeated.copies) + of + "repeat " + std::to_string(repeated.places) +
        (repeated.places == 1 ? " place exactly; one is kept" : " places exactly; one is kept of each"));
  keep(raw, repeated.kept);
  return {};
}

/// Brings directions to unit length; zero where there is none.
void make_unit(std::vector<Vec3>& column) {
  for (auto& n : column) {
    const double length = n.norm();
    // A direction that is unit to single precision is brought to double precision; nearer ones stay as they are.
    if (!std::isfinite(length) || length == 0)
      n = Vec3::Zero();
    else if (std::abs(length - 1) > 1e-12)
      n /= length;
  }
}

/// Drops what is no place or says nothing.
std::optional<Error> clean(RawGeometry& raw, const std::string& name) {
  if (raw.cloud.empty()) return bad_input(name + ": expected points, found none");
  if (auto error = drop_no_places(raw, name)) return error;
  if (auto error = drop_repeated(raw, name)) return error;
  make_unit(raw.cloud.normals), make_unit(raw.cloud.rays);
  if (raw.mesh.triangles.empty()) raw.mesh.vertices.clear();
  return {};
}

}  // namespace

Result<RawGeometry> parse_geometry(std::string_view bytes, const std::string& name) {
  if (bytes.empty()) return bad_input(name + ": expected points or a mesh, found an empty file");
  if (starts_with(bytes, "\xEF\xBB\xBF")) bytes.remove_prefix(3);  // a text editor's byte order mark
  if (const auto reason = refusal(bytes, suffix_of(name))) return bad_input(name + ": " + *reason);
  const Parser parser = parser_for(bytes, name);
  if (!parser) return bad_input(name + ": expected a geometry file, found binary data of no known format");
  auto result = parser(bytes, name);
  if (!result.ok()) return result;
  if (auto error = clean(*result, name)) return *error;
  return result;
}

Result<RawGeometry> read_geometry(const Path& path, Context& context) {
  context.report("reading " + path.filename().string(), 0);
  auto bytes = read_file(path);
  if (!bytes.ok()) return bytes.error();
  auto result = parse_geometry(*bytes, path.filename().string());
  context.report("reading " + path.filename().string(), 1);
  return result;
}

}  // namespace partscribe::geometry
