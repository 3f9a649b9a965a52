/// Damages of a triangle mesh file: what exporters, converters and repairers do to an STL.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/number.h"
#include "core/random.h"
#include "geometry/io/read_geometry.h"
#include "testing/damage/file_damage.h"

namespace partscribe::testing {
namespace {

const std::vector<std::string> torn = {"open", "edges", "boundary", "facet", "torn"};
const std::vector<std::string> turned_over = {"inside out", "opposite", "same direction",
                                              "orient",     "inverted", "edges"};

TriangleMesh mapped(TriangleMesh mesh, const std::function<Vec3(const Vec3&)>& map) {
  for (auto& v : mesh.vertices) v = map(v);
  return mesh;
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return a;
}

TriangleMesh flipped(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// A block about `center` with axes u, v and n.
TriangleMesh block(const Vec3& center, const Vec3& u, const Vec3& v, const Vec3& n) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(center + (i & 1 ? u : Vec3(-u)) + (i & 2 ? v : Vec3(-v)) + (i & 4 ? n : Vec3(-n)));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

std::string ascii(const TriangleMesh& mesh) {
  std::string text = "solid part\n";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = mesh.corner(t, k);
      text += "      vertex " + print_number(p.x()) + " " + print_number(p.y()) + " " + print_number(p.z()) + "\n";
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid part\n";
}

void put_float(std::string& bytes, std::size_t facet, std::size_t number, float value) {
  std::memcpy(bytes.data() + 84 + 50 * facet + 12 + 4 * number, &value, 4);
}

}  // namespace

void damage_facets(const FileSubject& s, std::vector<FileDamage>& damages) {
  if (s.backend != "mesh") return;
  const TriangleMesh& mesh = s.mesh;
  const double T = s.model.tolerance;
  const std::size_t count = mesh.triangles.size();
  const Box3 box = mesh.bounds();
  auto add = [&](const char* kind, const std::string& name, const TriangleMesh& damaged,
                 std::vector<std::string> says) {
    damages.push_back({kind, name, write_stl(damaged), std::move(says)});
  };
  for (const auto& [factor, name] :
       {std::pair{25.4, "25.4 times"}, {1 / 25.4, "a 25.4th"}, {1000.0, "um for mm"}, {0.1, "cm for mm"}})
    add("units swapped", name, mapped(mesh, [f = factor](const Vec3& p) { return Vec3(f * p); }),
        factor > 100    ? std::vector<std::string>{"1000"}
        : factor == 0.1 ? std::vector<std::string>{"10 times", "0.1", "tenth"}
                        : std::vector<std::string>{"25.4", "inch"});
  const Mat3 cycled = rotation_of(2 * pi / 3 * Vec3::Ones().normalized());
  add("axes swapped", "x and y, turned over", mapped(mesh, [](const Vec3& p) { return Vec3(p.y(), p.x(), p.z()); }),
      {"inside out", "mirror"});
  add("axes swapped", "x and y", flipped(mapped(mesh, [](const Vec3& p) { return Vec3(p.y(), p.x(), p.z()); })),
      {"mirror", "whole part"});
  add("axes swapped", "x to y to z", mapped(mesh, [&](const Vec3& p) { return Vec3(cycled * p); }), {"whole part"});
  add("wrong frame", "centred at the origin", mapped(mesh, [&](const Vec3& p) { return Vec3(p - box.center()); }),
      {"whole part"});
  add("wrong frame", "standing on z = 0",
      mapped(mesh, [&](const Vec3& p) { return Vec3(p - box.low.z() * Vec3::UnitZ()); }), {"whole part"});
  add("sheared", "axes off a right angle",
      mapped(mesh,
             [&](const Vec3& p) {
               return Vec3(p + 12 * T / box.diagonal() * (p.z() - box.center().z()) * Vec3::UnitX());
             }),
      {});
  add("wall tapered", "all over",
      mapped(mesh,
             [&](const Vec3& p) {
               const double grow = std::max(0.01, 10 * T / box.diagonal()) * (p.z() - box.low.z()) / box.size().z();
               return Vec3(p.x() + grow * (p.x() - box.center().x()), p.y() + grow * (p.y() - box.center().y()), p.z());
             }),
      {});
  add("inverted facets", "all", flipped(mesh), turned_over);
  auto one = mesh;
  std::swap(one.triangles[count / 2][1], one.triangles[count / 2][2]);
  add("inverted facets", "one", one, turned_over);
  auto some = mesh;
  for (std::size_t t = 0; t < count; t += 3) std::swap(some.triangles[t][1], some.triangles[t][2]);
  add("inverted facets", "a third", some, turned_over);
  auto fewer = mesh;
  fewer.triangles.erase(fewer.triangles.begin() + long(count / 2));
  add("missing facet", "one", fewer, torn);
  auto open = mesh;
  const Vec3 n = triangle_normal(mesh, count / 3);
  std::erase_if(open.triangles, [&](const auto& t) {
    const Vec3 m =
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).normalized();
    return m.dot(n) > 0.9;
  });
  if (!open.triangles.empty()) add("open shell", "all facets that look one way missing", open, torn);
  auto doubled = mesh;
  doubled.triangles.insert(doubled.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  add("duplicated body", "every facet twice", doubled,
      {"edges", "twice", "facets", "overlap", "duplicate", "same place"});
  auto twice = mesh;
  twice.triangles.push_back(mesh.triangles[count / 2]);
  add("duplicated body", "one facet twice", twice, {"edges", "twice", "facets", "overlap", "duplicate", "same place"});
  add("shifted duplicate", "along x",
      joined(mesh, mapped(mesh, [&](const Vec3& p) { return Vec3(p + 6 * T * Vec3::UnitX()); })), {"overlap"});
  add("shifted duplicate", "beside",
      joined(mesh, mapped(mesh, [&](const Vec3& p) { return Vec3(p + 2 * s.extent * Vec3::UnitX()); })),
      {"separate body", "too much", "invented", "no scanned point"});
  // On the largest facet, of its own size.
  std::size_t largest = 0;
  double most = 0;
  for (std::size_t t = 0; t < count; ++t) {
    const double a = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    if (a > most) most = a, largest = t;
  }
  const Vec3 up = triangle_normal(mesh, largest), u = up.unitOrthogonal(), v = up.cross(u);
  const Vec3 middle = (mesh.corner(largest, 0) + mesh.corner(largest, 1) + mesh.corner(largest, 2)) / 3;
  const double half = std::max(0.06 * s.extent, 6 * T);
  add("thin spurious sheet", "lying above the surface",
      joined(mesh, block(middle + half * up, half * u, half * v, T / 8 * up)), {});
  TriangleMesh flap;
  flap.vertices = {middle + half * up, middle + half * (up + u), middle + half * (up + v)};
  flap.triangles = {{0, 1, 2}};
  add("thin spurious sheet", "one loose facet", joined(mesh, flap), torn);
  for (const int k : {0, 1, 2}) {
    auto dented = mesh;
    const Vec3 at = mesh.vertices[mesh.vertices.size() * std::size_t(k) / 3];
    for (auto& p : dented.vertices)
      if ((p - at).norm() < 0.08 * s.extent) p += std::max(4 * T, 0.02 * s.extent) * (box.center() - p).normalized();
    add("dent", "at vertex " + print_number(double(mesh.vertices.size() * std::size_t(k) / 3)), dented, {});
  }
  auto rough = mesh;
  const double grid = 10 * T;
  for (auto& p : rough.vertices)
    for (int k = 0; k < 3; ++k) p[k] = std::round(p[k] / grid) * grid;
  add("numbers cut short", "to 10 T", rough, {});
  const std::string bytes = write_stl(mesh);
  const float nan = std::nanf(""), inf = INFINITY;
  for (const auto& [value, name] : {std::pair{nan, "NaN"}, {inf, "infinite"}, {1e30f, "1e30"}}) {
    auto damaged = bytes;
    put_float(damaged, count / 2, 4, value);
    damages.push_back({"not a number", name, damaged, {"number", "finite", "nan", "inf", "open", "edges", "large"}});
  }
  for (const double share : {0.0, 0.1, 0.5, 0.9, 0.999}) {
    const auto length = 84 + static_cast<std::size_t>(share * double(bytes.size() - 84));
    if (length < bytes.size())
      damages.push_back({"truncated file",
                         "after " + print_number(double(length)) + " bytes",
                         bytes.substr(0, length),
                         {"expected", "ends", "bytes", "facets", "open"}});
  }
  damages.push_back(
      {"truncated file", "in its head", bytes.substr(0, 60), {"expected", "ends", "bytes", "holds", "format"}});
  const std::string text = ascii(mesh);
  damages.push_back(
      {"truncated file", "text, half", text.substr(0, text.size() / 2), {"expected", "ends", "open", "line"}});
  damages.push_back({"truncated file",
                     "text, without the end",
                     text.substr(0, text.rfind("endsolid")),
                     {"expected", "ends", "endsolid", "line"}});
  damages.push_back({"decimal comma", "in text", with_all(text, ".", ","), {"expected", "number", "line"}});
  damages.push_back({"line missing", "a vertex", with(text, "      vertex", "      verte"), {"expected", "line"}});
  damages.push_back({"empty geometry", "no facet", write_stl({}), {"no triangle", "triangles", "holds", "empty"}});
  damages.push_back({"empty geometry",
                     "no facet in text",
                     "solid part\nendsolid part\n",
                     {"no triangle", "triangles", "holds", "empty"}});

  auto reordered = mesh;
  std::reverse(reordered.triangles.begin(), reordered.triangles.end());
  for (auto& t : reordered.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
  damages.push_back({"harmless edits", "facets in another order", write_stl(reordered), {}, true});
  damages.push_back({"harmless edits", "as text", text, {}, true});
  damages.push_back(
      {"harmless edits", "text in capitals", with_all(with_all(text, "facet", "FACET"), "vertex", "VERTEX"), {}, true});
  auto titled = bytes;
  titled.replace(0, 20, "made by a colleague ");
  damages.push_back({"harmless edits", "another title", titled, {}, true});
  auto split = mesh;
  const auto corner = split.triangles[largest];
  const auto extra = static_cast<std::uint32_t>(split.vertices.size());
  split.vertices.push_back(middle);
  split.triangles[largest] = {corner[0], corner[1], extra};
  split.triangles.push_back({corner[1], corner[2], extra});
  split.triangles.push_back({corner[2], corner[0], extra});
  damages.push_back({"harmless edits", "a facet split in three", write_stl(split), {}, true});
}

}  // namespace partscribe::testing
