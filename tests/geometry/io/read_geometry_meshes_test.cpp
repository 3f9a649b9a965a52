/// Mesh files: every format gives back the solid that was written.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "core/number.h"
#include "geometry/io/read_geometry.h"
#include "testing/zip.h"

using namespace partscribe::geometry;
using partscribe::testing::zip;

namespace {

template <class T>
void put(std::string& out, T value, bool big_endian = false) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof value);
  if (big_endian) std::reverse(bytes, bytes + sizeof(T));
  out.append(bytes, sizeof(T));
}

RawGeometry parsed(const std::string& bytes, const std::string& name) {
  auto result = parse_geometry(bytes, name);
  INFO((result.ok() ? std::string() : result.error().message));
  REQUIRE(result.ok());
  return *result;
}

const std::vector<Vec3> corners = {{0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0},
                                   {0, 0, 4}, {2, 0, 4}, {2, 3, 4}, {0, 3, 4}};
const std::vector<std::array<int, 4>> sides = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                               {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// A block of 2 x 3 x 4, its faces outward.
TriangleMesh block(const Vec3& at = Vec3(0, 0, 0)) {
  TriangleMesh mesh;
  for (const auto& c : corners) mesh.vertices.push_back(c + at);
  for (const auto& s : sides)
    for (const int k : {1, 2})
      mesh.triangles.push_back({std::uint32_t(s[0]), std::uint32_t(s[k]), std::uint32_t(s[k + 1])});
  return mesh;
}

std::string vertex_lines(const std::string& before, const std::string& after = "") {
  std::string text;
  for (const auto& c : corners)
    text += before + print_number(c.x()) + " " + print_number(c.y()) + " " + print_number(c.z()) + after + "\n";
  return text;
}

std::string side_lines(const std::string& before, int first, const std::string& after = "") {
  std::string text;
  for (const auto& s : sides) {
    text += before;
    for (const int i : s) text += " " + std::to_string(i + first) + after;
    text += "\n";
  }
  return text;
}

void check_block(const RawGeometry& raw, double scale = 1) {
  CHECK(raw.mesh.vertices.size() == 8);
  CHECK(raw.mesh.triangles.size() == 12);
  CHECK(raw.cloud.points == raw.mesh.vertices);
  CHECK(topology(raw.mesh).closed());
  CHECK(volume(raw.mesh) == Approx(24 * scale * scale * scale));
}

std::string facet(const Vec3& a, const Vec3& b, const Vec3& c) {
  std::string text = "  facet normal nan 0 0\n    outer loop\n";
  for (const auto& p : {a, b, c})
    text += "      VERTEX " + print_number(p.x()) + " " + print_number(p.y()) + " " + print_number(p.z()) + "\n";
  return text + "    endloop\n  endfacet\n";
}

std::string ascii_stl(const TriangleMesh& mesh) {
  std::string text;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t == 0) text += "solid first vertex of a name\n";
    if (t == 6) text += "endsolid\nsolid second facet\n";  // several solids in one file
    text += facet(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
  }
  return text + "endsolid second\n";
}

std::string block_xml(const std::string& id) {
  std::string text = "<object id=\"" + id + "\" type='model'><mesh><vertices>";
  for (const auto& c : corners)
    text += "<vertex x=\"" + print_number(c.x()) + "\" y=\"" + print_number(c.y()) + "\" z=\"" + print_number(c.z()) +
            "\" />";
  text += "</vertices><triangles>";
  for (const auto& t : block().triangles)
    text += "<triangle v1=\"" + std::to_string(t[0]) + "\" v2=\"" + std::to_string(t[1]) + "\" v3=\"" +
            std::to_string(t[2]) + "\"/>";
  return text + "</triangles></mesh></object>";
}

const std::string model_head =
    "<?xml version=\"1.0\"?><!-- <object id='9'> --><model unit=\"inch\" xmlns=\"x\"><resources>";

}  // namespace

TEST_CASE("read STL: ascii with several solids and binary give the same welded block") {
  const auto ascii = parsed(ascii_stl(block()), "a.stl");
  check_block(ascii);
  CHECK(ascii.warnings.empty());
  auto binary = write_stl(block());
  check_block(parsed(binary, "a.stl"));
  binary.replace(0, 5, "solid");  // many programs write binary files that begin like text
  check_block(parsed(binary, "a.stl"));
  CHECK(parsed(binary, "a.stl").mesh.vertices == ascii.mesh.vertices);
  check_block(parsed(binary, "without_suffix"));
}

TEST_CASE("read STL: a count that was never filled in is counted, bytes at the end are ignored aloud") {
  auto bytes = write_stl(block());
  std::memset(bytes.data() + 80, 0, 4);
  const auto counted = parsed(bytes, "a.stl");
  check_block(counted);
  CHECK(counted.warnings.size() == 1);
  const auto longer = parsed(write_stl(block()) + "trailing", "a.stl");
  check_block(longer);
  CHECK(longer.warnings == std::vector<std::string>{"a.stl: 8 bytes after the last triangle ignored"});
}

TEST_CASE("read STL: a text cut off between two facets says so") {
  auto text = ascii_stl(block());
  text.resize(text.rfind("  facet"));
  CHECK(parsed(text, "a.stl").warnings ==
        std::vector<std::string>{"a.stl: ends without 'endsolid'; it may have been cut off"});
}

TEST_CASE("read STL: endings parted into two words or shortened to 'end' close what is open") {
  const auto text = ascii_stl(block());
  const auto with = [&](const std::string& loop, const std::string& facet, const std::string& solid) {
    std::string changed = text;
    for (const auto& [from, to] :
         {std::pair<std::string, std::string>{"endloop", loop}, {"endfacet", facet}, {"endsolid", solid}})
      for (std::size_t at = 0; (at = changed.find(from, at)) != std::string::npos; at += to.size())
        changed.replace(at, from.size(), to);
    return changed;
  };
  for (const auto& bytes :
       {with("end loop", "end facet", "end solid"), with("END LOOP", "End Facet", "END SOLID"),
        with("end", "end", "end"), with("endloop", "endfacet", "end"), with("end", "end facet", "ENDSOLID")}) {
    const auto raw = parsed(bytes, "a.stl");
    check_block(raw);
    CHECK(raw.warnings.empty());
  }
}

TEST_CASE("read OBJ: plain, with textures and normals, and negative indices mean the same block") {
  const auto vertices = vertex_lines("v ") + "vt 0 0\nvn 0 0 1\n";
  check_block(parsed("mtllib a.mtl\no block\n" + vertices + side_lines("f", 1), "a.obj"));
  check_block(parsed(vertices + side_lines("f", 1, "/1"), "a.obj"));
  check_block(parsed(vertices + side_lines("f", 1, "//1"), "a.obj"));
  check_block(parsed(vertices + side_lines("f", 1, "/1/1"), "a.obj"));
  check_block(parsed(vertices + side_lines("f", -8, "/-1/-1"), "a.obj"));
  check_block(parsed(vertices + side_lines("f", 1), "no_suffix"));
  std::string wrapped = side_lines("f", 1);
  wrapped.insert(wrapped.find(' ', 3), " \\\n");
  check_block(parsed(vertices + wrapped, "a.obj"));
}

TEST_CASE("read OFF: comments, colours, normals and counts on the first line are understood") {
  check_block(
      parsed("OFF\n# a block\n\n8 6 0 # counts\n" + vertex_lines("", " # corner") + side_lines("4", 0, ""), "a.off"));
  check_block(parsed("OFF 8 6 12\n" + vertex_lines("") + side_lines("4", 0), "a.off"));
  check_block(parsed("COFF\n8 6 0\n" + vertex_lines("", " 255 0 0 255") + side_lines("4", 0), "a.off"));
  const auto raw = parsed("NOFF\n8 6 0\n" + vertex_lines("", " 0 0 1") + side_lines("4", 0), "a.off");
  check_block(raw);
  CHECK(raw.cloud.normals == std::vector<Vec3>(8, Vec3(0, 0, 1)));
}

TEST_CASE("read PLY meshes: polygons, strips and what write_mesh_ply writes") {
  const std::string head = "element vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
  check_block(parsed("ply\r\nformat ascii 1.0\r\n" + head +
                         "element face 6\nproperty uchar flag\nproperty list uchar int vertex_index\nend_header\n" +
                         vertex_lines("") + side_lines("7 4", 0),
                     "a.ply"));
  const auto mesh = block(Vec3(1e9 + 0.1, -1e9, 1e-9));
  const auto back = parsed(write_mesh_ply(mesh), "a.ply");
  CHECK(back.mesh.vertices == mesh.vertices);
  CHECK(back.mesh.triangles == mesh.triangles);
  // A tetrahedron as one strip, and again as two strips parted by -1.
  const std::string four =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
      "tristrips 1\n"
      "property list int int vertex_indices\nend_header\n0 0 0\n0 3 0\n3 0 0\n0 0 3\n";
  for (const std::string strip : {"6 0 1 2 3 0 1\n", "9 0 1 2 3 -1 2 3 0 1\n"}) {
    const auto raw = parsed(four + strip, "a.ply");
    CHECK(topology(raw.mesh).closed());
    CHECK(std::abs(volume(raw.mesh)) == Approx(4.5));
  }
}

TEST_CASE("read VTK polydata: ascii, binary and the form of version 5 give the same block") {
  const std::string head = "# vtk DataFile Version 3.0\nblock\n";
  check_block(parsed(
      head + "ASCII\nDATASET POLYDATA\nPOINTS 8 float\n" + vertex_lines("") + "POLYGONS 6 30\n" + side_lines("4", 0),
      "a.vtk"));
  std::string binary = head + "BINARY\nDATASET POLYDATA\nPOINTS 8 double\n";
  for (const auto& c : corners)
    for (int k = 0; k < 3; ++k) put(binary, c[k], true);
  std::string five = "# vtk DataFile Version 5.1" + binary.substr(26);
  binary += "\nPOLYGONS 6 30\n";
  for (const auto& s : sides) {
    put<std::int32_t>(binary, 4, true);
    for (const int i : s) put<std::int32_t>(binary, i, true);
  }
  binary += "\nPOINT_DATA 8\nNORMALS n float\n";
  for (int i = 0; i < 8; ++i) put(binary, 0.0f, true), put(binary, 0.0f, true), put(binary, 1.0f, true);
  const auto raw = parsed(binary, "a.vtk");
  check_block(raw);
  CHECK(raw.cloud.normals == std::vector<Vec3>(8, Vec3(0, 0, 1)));
  five += "\nMETADATA\nINFORMATION 0\n\nPOLYGONS 7 24\nOFFSETS vtktypeint64\n";
  for (std::int64_t i = 0; i <= 6; ++i) put(five, 4 * i, true);
  five += "\nCONNECTIVITY vtktypeint64\n";
  for (const auto& s : sides)
    for (const std::int64_t i : s) put(five, i, true);
  check_block(parsed(five, "a.vtk"));
}

TEST_CASE("read VTK unstructured grids: flat cells are a surface, ascii, binary and in the form of version 5") {
  const std::string head = "# vtk DataFile Version 3.0\nblock\n";
  const std::string types = "CELL_TYPES 6\n9\n9\n9\n9\n7\n7\n";
  check_block(parsed(head + "ASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n" + vertex_lines("") + "CELLS 6 30\n" +
                         side_lines("4", 0) + types,
                     "a.vtk"));
  std::string binary = head + "BINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n";
  for (const auto& c : corners)
    for (int k = 0; k < 3; ++k) put(binary, c[k], true);
  std::string five = "# vtk DataFile Version 5.1" + binary.substr(26);
  binary += "\nCELLS 6 30\n";
  for (const auto& s : sides) {
    put<std::int32_t>(binary, 4, true);
    for (const int i : s) put<std::int32_t>(binary, i, true);
  }
  five += "\nMETADATA\nINFORMATION 0\n\nCELLS 7 24\nOFFSETS vtktypeint64\n";
  for (std::int64_t i = 0; i <= 6; ++i) put(five, 4 * i, true);
  five += "\nCONNECTIVITY vtktypeint64\n";
  for (const auto& s : sides)
    for (const std::int64_t i : s) put(five, i, true);
  for (auto* bytes : {&binary, &five}) {
    *bytes += "\nCELL_TYPES 6\n";
    for (int i = 0; i < 6; ++i) put<std::int32_t>(*bytes, i < 3 ? 9 : 7, true);
    check_block(parsed(*bytes + "\nCELL_DATA 6\n", "a.vtk"));
  }
  // Pixels are listed row by row; strips are triangles; vertices and lines are no surface.
  const auto mixed =
      parsed(head +
                 "ASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 float\n0 0 0 1 0 0 0 1 0 1 1 0 2 0 0 2 1 0\n"
                 "CELLS 4 15\n4 0 1 2 3\n4 1 4 3 5\n1 0\n2 0 1\nCELL_TYPES 4\n8 6 1 3\n",
             "a.vtk");
  CHECK(area(mixed.mesh) == Approx(2));
  for (std::size_t t = 0; t < mixed.mesh.triangles.size(); ++t) CHECK(triangle_normal(mixed.mesh, t).z() == Approx(1));
}

TEST_CASE("read 3MF: stored and deflated archives, the unit, components and build transforms") {
  const auto plain = model_head + block_xml("1") + "</resources><build><item objectid=\"1\"/></build></model>";
  for (const bool deflate_them : {false, true}) {
    const auto raw =
        parsed(zip({{"[Content_Types].xml", "<Types/>"}, {"3D/3dmodel.model", plain}}, deflate_them), "a.3mf");
    check_block(raw);
    CHECK(raw.unit == "inch");
    CHECK(raw.cloud.points == corners);
  }
  // Twice as large, turned by 90 degrees about z (rows of the file are images of the axes), moved, then mirrored.
  const auto nested =
      model_head + block_xml("1") +
      "<object id=\"2\"><components><component objectid=\"1\" transform=\"0 2 0 -2 0 0 0 0 2 10 20 "
      "30\"/></components></object>"
      "</resources><build><item objectid=\"2\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/></build></model>";
  const auto raw = parsed(zip({{"3D/3dmodel.model", nested}}, true), "a.3mf");
  check_block(raw, 2);
  CHECK((raw.cloud.points[2] - Vec3(-4, 24, 30)).norm() <
        1e-12);  // (2,3,0) -> (-6,4,0) + (10,20,30) = (4,24,30), mirrored in x
}

TEST_CASE("read 3MF: prefixed names, entities and comments are XML, damage is named") {
  const std::string body = "<!-- <x:object id=\"7\"> --><x:model xmlns:x=\"core\" unit=\"&#105;nch\"><x:resources>" +
                           block_xml("1") + "</x:resources><x:build><x:item objectid=\"1\"/></x:build></x:model>";
  check_block(parsed(zip({{"3D/part.model", body}}, true), "a.3mf"));
  CHECK(parsed(zip({{"3D/part.model", body}}, true), "a.3mf").unit == "inch");
  const auto fault = [&](const std::string& bytes) {
    const auto raw = parse_geometry(bytes, "a.3mf");
    return raw.ok() ? std::string() : raw.error().message;
  };
  CHECK(fault(zip({{"3D/part.model", body.substr(0, body.size() - 9)}}, true))
            .find("expected whole XML in '3d/part.model', found ") != std::string::npos);
  CHECK(fault(zip({{"readme.txt", "x"}}, true)).find("expected a 3-D model") != std::string::npos);
  auto damaged = zip({{"3D/part.model", body}}, false);
  damaged[damaged.find("vertex x") + 7] = 'y';
  CHECK(fault(damaged).find("checksum") != std::string::npos);
  // Entities within entities would grow without end.
  std::string bomb = "<!DOCTYPE model [<!ENTITY a0 \"aaaaaaaaaaaaaaaa\">";
  for (int i = 1; i < 12; ++i) {
    const std::string a = "&a" + std::to_string(i - 1) + ";";
    bomb += "<!ENTITY a" + std::to_string(i) + " \"" + a + a + a + a + a + a + a + a + a + a + "\">";
  }
  CHECK(fault(zip({{"3D/part.model", bomb + "]><model>&a11;</model>"}}, true)).find("amplification") !=
        std::string::npos);
}

TEST_CASE("read 3MF: small files that would become large are refused") {
  const auto fault = [](const std::string& bytes) {
    const auto raw = parse_geometry(bytes, "a.3mf");
    return raw.ok() ? std::string() : raw.error().message;
  };
  const auto blanks = zip({{"3D/3dmodel.model", "<model>" + std::string(270u << 20, ' ') + "</model>"}}, true);
  CHECK(blanks.size() < 1u << 20);
  CHECK(fault(blanks).find("expected a credible size, found 283115535 bytes") != std::string::npos);
  std::string objects = model_head + block_xml("1");
  for (int i = 2; i < 12; ++i) {
    const std::string component = "<component objectid=\"" + std::to_string(i - 1) + "\"/>";
    objects += "<object id=\"" + std::to_string(i) + "\"><components>";
    for (int k = 0; k < 10; ++k) objects += component;
    objects += "</components></object>";
  }
  const auto many = zip({{"3D/m.model", objects + "</resources><build><item objectid=\"11\"/></build></model>"}}, true);
  CHECK(fault(many).find("expected at most 2000000 triangles, found more") != std::string::npos);
}

TEST_CASE("read polygons: a concave face is cut inside its outline") {
  // An L of area 5; a fan from its first corner would cover 6 outside it.
  const auto raw = parsed("v 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nv 0 0 0\nf 1 2 3 4 5 6\n", "l.obj");
  CHECK(raw.mesh.triangles.size() == 4);
  CHECK(area(raw.mesh) == Approx(5));
  for (std::size_t t = 0; t < raw.mesh.triangles.size(); ++t) CHECK(triangle_normal(raw.mesh, t).z() == Approx(1));
  // Far out, in a tilted plane, turned so that every corner comes first once.
  const Vec3 far(1e8, 2e8, -1e8);
  const Mat3 R = rotation_of(Vec3(0.3, 0.4, 0.5));
  const std::vector<Vec3> outline = {{3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}, {0, 0, 0}};
  for (int turn = 0; turn < 6; ++turn) {
    std::string text, face = "f";
    for (int i = 0; i < 6; ++i) {
      const Vec3 p = R * outline[std::size_t((i + turn) % 6)] + far;
      text += "v " + print_number(p.x()) + " " + print_number(p.y()) + " " + print_number(p.z()) + "\n";
      face += " " + std::to_string(i + 1);
    }
    CHECK(area(parsed(text + face + "\n", "l.obj").mesh) == Approx(5).epsilon(1e-6));
  }
}

TEST_CASE("read meshes: triangles on places that are none go with them") {
  const auto raw = parsed("v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\nf 2 5 3\n", "a.obj");
  CHECK(raw.mesh.vertices.size() == 4);
  CHECK(raw.mesh.triangles == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {1, 3, 2}});
}
