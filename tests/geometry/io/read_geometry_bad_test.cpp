/// Files that cannot be used end in one line that says why, and never in a crash or a stall.
#include <catch2/catch.hpp>
#include <cstring>

#include "core/random.h"
#include "geometry/io/read_geometry.h"

using namespace partscribe::geometry;

namespace {

struct Bad {
  const char* name;
  std::string bytes;
  const char* message;  ///< must be part of the error
};

const std::string ply =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string binary_ply =
    "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty "
    "float z\nend_header\n";
const std::string pcd = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\nPOINTS 4\n";

std::string truncated_stl() {
  std::string bytes(84 + 50, '\0');
  const std::uint32_t count = 1'000'000'000;
  std::memcpy(bytes.data() + 80, &count, 4);
  return bytes;
}

std::vector<Bad> bad_files() {
  return {
      {"bad_empty.ply", "", "expected points or a mesh, found an empty file"},
      {"bad_magic.ply", "plyx\nformat ascii 1.0\n", "line 1: expected 'ply', found 'plyx'"},
      {"bad_no_end.ply", ply, "expected 'end_header', found the end of the file"},
      {"bad_format.ply", "ply\nformat text 1.0\n",
       "line 2: expected ascii, binary_little_endian or binary_big_endian, found 'text'"},
      {"bad_no_format.ply", "ply\nelement vertex 1\nend_header\n", "expected a 'format' line"},
      {"bad_type.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n",
       "line 4: expected a number type, found 'real'"},
      {"bad_count.ply", "ply\nformat ascii 1.0\nelement vertex -4\n",
       "line 3: expected a number of 'vertex', found '-4'"},
      {"bad_no_vertex.ply", "ply\nformat ascii 1.0\nend_header\n", "expected an element 'vertex'"},
      {"bad_no_z.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n",
       "expected the vertex properties x, y and z"},
      {"bad_zero.ply",
       "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
       "expected points, found none"},
      {"bad_word.ply", ply + "end_header\n1 2 3\n4 five 6\n7 8 9\n",
       "line 9: expected 3 numbers of a vertex, found 'five'"},
      {"bad_short.ply", ply + "end_header\n1 2 3\n4 5 6.25\n",
       "expected 3 vertex records, found the end of the file after 2"},
      {"bad_huge.ply", binary_ply + std::string(120, 'x'), "expected 4000000000 vertex records, found room for 10"},
      {"bad_index.ply",
       ply + "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
       "face 1: expected a vertex index below 3, found 3"},
      {"bad_negative.ply",
       ply + "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
       "expected vertex indices that are not negative in face 1"},
      {"bad_list.ply",
       ply +
           "element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n",
       "list entries, found a count of 4000000000"},
      {"bad_nan.ply", ply + "end_header\nnan 0 0\n0 nan 0\n0 inf 0\n",
       "expected finite coordinates, found none in 3 of 3 points"},
      {"bad_short.stl", "binary\x01\x02" + std::string(20, '\0'),
       "expected at least 84 bytes of a binary STL file, found 28"},
      {"bad_cut.stl", truncated_stl(), "expected 1000000000 triangles, found room for 1"},
      {"bad_none.stl", "solid Empty\nendsolid Empty", "expected triangles, found none"},
      {"bad_word.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n",
       "line 4: expected 3 coordinates of a vertex, found 'zero'"},
      {"bad_loop.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
       "line 6: expected 3 vertices in a loop, found 2"},
      {"bad_end.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n",
       "expected 'endloop', found the end of the file"},
      {"bad_text.stl", "hello\nworld\n",
       "line 1: expected 'solid' or a binary STL file of matching length, found 'hello'"},
      {"bad_point.stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 "
       "0\nendloop\nendfacet\nendsolid\n",
       "found only collapsed ones"},
      {"bad_index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "face 1: expected a vertex index below 3, found 3"},
      {"bad_zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
       "line 4: expected a vertex index from 1 to 3 or a negative one back to the first, found '0'"},
      {"bad_back.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", "line 4: expected a vertex index"},
      {"bad_number.obj", "v 0 0 o\n", "line 1: expected 3 numbers after 'v', found 'o'"},
      {"bad_none.obj", "# nothing\n", "expected vertex lines"},
      {"bad_counts.off", "OFF\nmany\n", "line 2: expected the number of vertices, found 'many'"},
      {"bad_short.off", "OFF\n1000000000000 1 0\n0 0 0\n",
       "expected 1000000000000 vertices, found the end of the file after 1"},
      {"bad_index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
       "face 1: expected a vertex index below 3, found 7"},
      {"bad_corners.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n900000000 0 1 2\n",
       "expected a vertex index from 0 to 2, found nothing"},
      {"bad_binary.off", "OFF BINARY\n\x01", "binary OFF files are not supported"},
      {"bad_data.pcd", pcd + "DATA base64\n", "expected 'DATA ascii', 'binary' or 'binary_compressed', found 'base64'"},
      {"bad_short.pcd", pcd + "DATA binary\n0123456789", "expected 4 points, found room for 0"},
      {"bad_lzf.pcd",
       pcd + "DATA binary_compressed\n" + std::string("\x08\0\0\0\x30\0\0\0\xff\xff\xff\xff\xff\xff\xff\xff", 16),
       "expected compressed data of 48 bytes, found damaged ones"},
      {"bad_bomb.pcd", pcd + "DATA binary_compressed\n" + std::string("\x04\0\0\0\xff\xff\xff\xff\0\0\0\0", 12),
       "found damaged ones"},
      {"bad_fields.pcd", "FIELDS a b\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2\n",
       "expected the fields x, y and z"},
      {"bad_words.pcd", pcd + "DATA ascii\n1 2 3\n1 2\n", "line 11: expected 3 numbers, found nothing"},
      {"bad_words.xyz", "these are no\nnumbers at all\n", "expected a line with three coordinates, found none"},
      {"bad_two.xyz", "1 2\n3 4\n5 6\n", "expected a line with three coordinates, found none"},
      {"bad_mostly.xyz", "1 2 3\na\nb\nc\n", "line 2: expected at least 3 numbers, found 'a'"},
      {"bad_zero.xyz", std::string("1 2 3\n\0\n", 8), "binary data of no known format"},
      {"bad_grid.asc", "ncols 4\nnrows 4\n1 2 3 4\n", "found an ESRI grid, which is not supported"},
      {"bad_dataset.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_GRID\n",
       "expected a POLYDATA or UNSTRUCTURED_GRID dataset, found 'STRUCTURED_GRID'; save the surface as PolyData"},
      {"bad_cells.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 "
       "1\nCELLS 4 18\n4 0 1 2 3\n3 0 1 2\n4 0 1 2 3\n3 0 1 2\nCELL_TYPES 4\n10 5 10 22\n",
       "expected triangles, quadrilaterals or polygons only, found 2 tetrahedra, 1 cell of type 22; extract the "
       "surface and save it as PolyData"},
      {"bad_types.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nCELLS 1 "
       "4\n3 0 1 2\n",
       "expected a type for each of 1 cells, found 0"},
      {"bad_huge.vtk", "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\nPOINTS 900000000 float\n1234",
       "expected 2700000000 numbers, found room for 1"},
      {"bad_index.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 "
       "9\n",
       "face 1: expected a vertex index below 3, found 9"},
      {"bad_zip.3mf", "PK\x03\x04 and nothing more, not even a directory",
       "expected a ZIP archive with a directory at its end, found none"},
      {"bad_e57.e57", "ASTM-E57 and more", "E57 files are not supported; export the scan as PLY"},
      {"bad_gzip.ply", "\x1f\x8b and more", "this is a gzip archive; unpack it first"},
      {"bad_png.png", "\x89PNG\r\n", "a range image needs a .json file of the same name"},
      {"bad_step.stp", "ISO-10303-21;\n", "this is a STEP file"},
      {"bad_cad.igs", "1 2 3\n4 5 6\n", "this is CAD, not a scan"},
      {"bad_unknown.bin", std::string("\1\2\3\0\4", 5), "found binary data of no known format"},
  };
}

}  // namespace

TEST_CASE("read bad files: one line says what was expected and found") {
  for (const auto& bad : bad_files()) {
    const auto result = parse_geometry(bad.bytes, bad.name);
    CAPTURE(bad.name);
    REQUIRE(!result.ok());
    CHECK(result.error().kind == ErrorKind::bad_input);
    CHECK_THAT(result.error().message, Catch::StartsWith(bad.name) && Catch::Contains(bad.message));
    CHECK(result.error().message.find('\n') == std::string::npos);
  }
}

TEST_CASE("read bad files: a missing one is named") {
  Context context;
  const auto result = read_geometry("/nowhere/part.stl", context);
  REQUIRE(!result.ok());
  CHECK_THAT(result.error().message, Catch::Contains("/nowhere/part.stl"));
}

TEST_CASE("read bad files: damage anywhere never crashes, and what is read is sound") {
  TriangleMesh mesh;
  for (int i = 0; i < 30; ++i) mesh.vertices.emplace_back(i % 5, i / 5, i * 0.1);
  for (std::uint32_t i = 0; i + 6 < 30; ++i) mesh.triangles.push_back({i, i + 1, i + 6});
  PointCloud cloud;
  cloud.points = mesh.vertices;
  std::string obj, off = "OFF\n30 24 0\n", stl = "solid s\n";
  for (const auto& v : mesh.vertices) {
    const auto line = std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
    obj += "v " + line, off += line;
  }
  for (const auto& t : mesh.triangles) {
    obj += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
    off += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
    stl += "facet normal 0 0 1\nouter loop\n";
    for (const auto c : t) {
      const auto& v = mesh.vertices[c];
      stl += "vertex " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
    }
    stl += "endloop\nendfacet\n";
  }
  std::string pcd_bytes =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 2\nPOINTS 8\nDATA "
      "binary_compressed\n";
  pcd_bytes += std::string("\x08\0\0\0\x60\0\0\0\0\0\xe0\x56\0", 13);
  const std::vector<std::pair<std::string, std::string>> good = {
      {"a.ply", write_mesh_ply(mesh)},
      {"b.ply", write_cloud_ply(cloud)},
      {"a.stl", write_stl(mesh)},
      {"b.stl", stl + "endsolid\n"},
      {"a.obj", obj},
      {"a.off", off},
      {"a.pcd", pcd_bytes},
      {"a.xyz", off.substr(12)},
      {"a.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 "
       "2\n"}};
  Random random(11);
  for (const auto& [name, bytes] : good)
    for (int trial = 0; trial < 400; ++trial) {
      auto damaged = bytes;
      if (trial % 3 == 0) damaged.resize(random.below(bytes.size()));
      for (std::uint64_t i = random.below(4) + (trial % 3 != 0); i > 0 && !damaged.empty(); --i)
        damaged[random.below(damaged.size())] = static_cast<char>(random.below(256));
      const auto result = parse_geometry(damaged, name);
      if (!result.ok()) {
        CHECK(!result.error().message.empty());
        continue;
      }
      const auto& raw = *result;
      REQUIRE(!raw.cloud.empty());
      for (const auto& p : raw.cloud.points) REQUIRE(p.allFinite());
      for (const auto& t : raw.mesh.triangles)
        for (const auto c : t) REQUIRE(c < raw.mesh.vertices.size());
      REQUIRE((raw.cloud.normals.empty() || raw.cloud.normals.size() == raw.cloud.size()));
      REQUIRE((raw.cloud.pixel.empty() || raw.cloud.pixel.size() == raw.cloud.size()));
    }
}
