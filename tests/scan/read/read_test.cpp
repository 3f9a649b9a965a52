/// Scans from files: units, poses, sidecars, several files in one frame.
#include "scan/read/read.h"

#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"
#include "geometry/io/read_geometry.h"
#include "scan/read/range_file.h"

using namespace partscribe::scan;

namespace {

struct Folder {
  TemporaryDirectory directory;
  Path put(const std::string& name, const std::string& bytes) const {
    const auto path = directory.path() / name;
    REQUIRE(write_file(path, bytes).ok());
    return path;
  }
};

Scan scan_of(const std::vector<Path>& inputs, const ReadOptions& options = {}) {
  Context context;
  auto scan = read_scan(inputs, options, context);
  INFO((scan.ok() ? std::string() : scan.error().message));
  REQUIRE(scan.ok());
  return *scan;
}

std::string failure_of(const std::vector<Path>& inputs, const ReadOptions& options = {}) {
  Context context;
  const auto scan = read_scan(inputs, options, context);
  REQUIRE(!scan.ok());
  CHECK(scan.error().message.find('\n') == std::string::npos);
  return scan.error().message;
}

TriangleMesh block(const Vec3& size) {
  TriangleMesh mesh;
  for (int c = 0; c < 8; ++c) mesh.vertices.push_back(size.cwiseProduct(Vec3(c & 1, c >> 1 & 1, c >> 2 & 1)));
  const std::array<std::array<std::uint32_t, 4>, 6> sides = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}}};
  for (const auto& s : sides)
    mesh.triangles.push_back({s[0], s[1], s[2]}), mesh.triangles.push_back({s[0], s[2], s[3]});
  return mesh;
}

/// A ball of many small triangles.
TriangleMesh ball(double radius, int rings) {
  TriangleMesh mesh;
  const int around = 2 * rings;
  for (int r = 0; r <= rings; ++r)
    for (int a = 0; a < around; ++a) {
      const double polar = pi * r / rings, across = r == rings ? 0 : std::sin(polar), turn = 2 * pi * a / around;
      mesh.vertices.emplace_back(radius * across * std::cos(turn), radius * across * std::sin(turn),
                                 radius * std::cos(polar));
    }
  for (int r = 0; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      const auto i = std::uint32_t(r * around + a), j = std::uint32_t(r * around + (a + 1) % around);
      if (r > 0) mesh.triangles.push_back({i, i + std::uint32_t(around), j});
      if (r + 1 < rings) mesh.triangles.push_back({j, i + std::uint32_t(around), j + std::uint32_t(around)});
    }
  return mesh;
}

bool warns(const Scan& scan, const std::string& what) {
  for (const auto& line : scan.warnings)
    if (line.find(what) != std::string::npos) return true;
  return false;
}

const std::string turned = "[[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]]";  // 90 degrees about z

}  // namespace

TEST_CASE("read_scan: several files are several views in the order given, each with its sum") {
  Folder folder;
  const auto b = folder.put("b.xyz", "1 0 0\n2 0 0\n"), a = folder.put("a.xyz", "3 0 0\n");
  const auto scan = scan_of({b, a});
  CHECK(scan.cloud.points == std::vector<Vec3>{{1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  CHECK(scan.cloud.view == std::vector<std::int32_t>{0, 0, 1});
  CHECK(scan.files == std::vector<std::string>{"b.xyz", "a.xyz"});
  CHECK(scan.sha256 == std::vector<std::string>{sha256("1 0 0\n2 0 0\n"), sha256("3 0 0\n")});
  REQUIRE(scan.views.size() == 2);
  CHECK(scan.views[1].file == "a.xyz");
  CHECK(!scan.views[1].has_sensor);
  CHECK(scan.cloud.rays.empty());
}

TEST_CASE("read_scan: columns that one file lacks are filled with unknowns") {
  Folder folder;
  PointCloud cloud;
  cloud.points = {{1, 0, 0}};
  cloud.normals = {{0, 0, 1}};
  cloud.rays = {{0, 0, -1}};
  cloud.view = {3};
  const auto scan = scan_of({folder.put("plain.xyz", "5 5 5\n"), folder.put("full.ply", write_cloud_ply(cloud))});
  CHECK(scan.cloud.normals == std::vector<Vec3>{{0, 0, 0}, {0, 0, 1}});
  CHECK(scan.cloud.rays == std::vector<Vec3>{{0, 0, 0}, {0, 0, -1}});
  CHECK(scan.cloud.view == std::vector<std::int32_t>{0, 4});
  CHECK(scan.views.size() == 5);
}

TEST_CASE("read_scan: the user's unit beats the sidecar's, which beats millimetres") {
  Folder folder;
  folder.put("p.xyz", "0.1 0.2 0.3\n0.2 0.4 0.6\n");
  const auto json = folder.put("scan.json", R"({"unit": "m", "views": [{"file": "p.xyz"}]})");
  CHECK((scan_of({json}).cloud.points[0] - Vec3(100, 200, 300)).norm() < 1e-12);
  CHECK(scan_of({json}).unit_scale == 1000);
  ReadOptions inch;
  inch.unit = parse_unit("Inches");
  REQUIRE(inch.unit);
  CHECK((scan_of({json}, inch).cloud.points[0] - 25.4 * Vec3(0.1, 0.2, 0.3)).norm() < 1e-12);
  CHECK(scan_of({folder.directory.path() / "p.xyz"}).cloud.points[0] == Vec3(0.1, 0.2, 0.3));
  CHECK(failure_of({folder.put("odd.json", R"({"unit": "ell", "views": [{"file": "p.xyz"}]})")}) ==
        "p.xyz: expected the unit um, mm, cm, m, inch or foot, found 'ell'");
}

TEST_CASE("read_scan: a unit that cannot be right is questioned, one that the user gave is not") {
  Folder folder;
  const auto small = folder.put("small.xyz", "0 0 0\n0.1 0.05 0.02\n"),
             large = folder.put("large.xyz", "0 0 0\n20000 100 100\n");
  CHECK(warns(scan_of({small}), "only 0.1 mm large; if its numbers are metres, say --units m"));
  ReadOptions metres;
  metres.unit = parse_unit("m");
  CHECK(scan_of({small}, metres).warnings.empty());
  CHECK(warns(scan_of({large}), "20 m large"));
  CHECK(scan_of({folder.put("usual.xyz", "0 0 0\n20 100 100\n")}).warnings.empty());
  CHECK(warns(scan_of({folder.put("few.xyz", "0 0 0\n3.3 2.1 1.02\n")}), "only 3.3 mm large; inches? --units inch"));
  CHECK(warns(scan_of({folder.put("quarters.stl", write_stl(block({12.25, 8.5, 0.75})))}),
              "x 8.5 x 0.75 are round in inches and not in mm"));
  CHECK(scan_of({folder.put("halves.stl", write_stl(block({12.5, 8.5, 30})))}).warnings.empty());
  // 5 x 2 1/2 x 1 3/8: nobody makes 1.375 mm; 50 x 20 x 10 mm told in inches; and ordinary millimetres.
  CHECK(warns(scan_of({folder.put("inch.stl", write_stl(block({5, 2.5, 1.375})))}), "inches? --units inch"));
  auto told = write_mesh_ply(block(Vec3(50, 20, 10) / 25.4));
  CHECK(scan_of({folder.put("stated.ply", told)}).warnings.empty());  // it says millimetres
  told.replace(told.find("millimetres"), 11, "no unit    ");
  CHECK(warns(scan_of({folder.put("told.ply", told)}), "inches? --units inch"));
  CHECK(scan_of({folder.put("mm.stl", write_stl(block({5, 2.5, 1.35})))}).warnings.empty());
  CHECK(scan_of({folder.put("odd.stl", write_stl(block({5.317, 2.41, 1.377})))}).warnings.empty());
}

TEST_CASE("read_scan: a coarse mesh is covered evenly by samples on its faces, after its vertices") {
  Folder folder;
  const Vec3 size(40, 30, 20);
  const auto scan = scan_of({folder.put("block.stl", write_stl(block(size)))});
  CHECK(scan.mesh.triangles.size() == 12);
  REQUIRE(scan.cloud.size() > 10'000);
  for (std::size_t i = 0; i < 8; ++i) CHECK(scan.cloud.points[i] == scan.mesh.vertices[i]);
  const double spacing = size.norm() / 250;
  std::array<double, 3> on_face{};
  for (std::size_t i = 8; i < scan.cloud.size(); ++i) {
    const Vec3 &p = scan.cloud.points[i], &n = scan.cloud.normals[i];
    int axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    REQUIRE(std::abs(n[axis]) == Approx(1));
    REQUIRE(p[axis] == Approx(n[axis] > 0 ? size[axis] : 0).margin(1e-9));
    on_face[static_cast<std::size_t>(axis)] += spacing * spacing;
  }
  for (int k = 0; k < 3; ++k)
    CHECK(on_face[std::size_t(k)] == Approx(2 * size[(k + 1) % 3] * size[(k + 2) % 3]).epsilon(0.01));
  CHECK(scan_of({folder.directory.path() / "block.stl"}).cloud.points == scan.cloud.points);
}

TEST_CASE("read_scan: a mesh as dense as a scan stays as it is, its normals point outward, unused points go") {
  Folder folder;
  auto mesh = ball(30, 120);
  const auto used = welded(mesh, 0).vertices.size();
  mesh.vertices.push_back(Vec3(500, 500, 500));
  const auto scan = scan_of({folder.put("ball.ply", write_mesh_ply(mesh))});
  CHECK(scan.cloud.size() == used);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) REQUIRE(scan.cloud.normals[i].dot(scan.cloud.points[i]) > 29);
  // Inside out, it is turned.
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  const auto inverted = scan_of({folder.put("inside_out.ply", write_mesh_ply(mesh))});
  CHECK(warns(inverted, "face inward; they were turned"));
  CHECK(volume(inverted.mesh) > 0);
}

TEST_CASE("read_scan: facets of the wrong sense are turned, and counted in one line with those of no area") {
  Folder folder;
  TriangleMesh mesh = ball(30, 40);
  mesh = welded(mesh, 0);
  const double whole = volume(mesh);
  const std::string count = std::to_string(mesh.triangles.size());
  CHECK(scan_of({folder.put("right.ply", write_mesh_ply(mesh))}).warnings.empty());
  for (const std::size_t t : {7, 200, 201}) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  const auto mended = scan_of({folder.put("flipped.ply", write_mesh_ply(mesh))});
  CHECK(mended.warnings ==
        std::vector<std::string>{"flipped.ply: of " + count + " facets 3 face the wrong way and were turned"});
  CHECK(topology(mended.mesh).closed());
  CHECK(volume(mended.mesh) == Approx(whole));
  // A vertex in the middle of an edge of one facet: the one beyond is cut in two, and a facet without area lies
  // between.
  auto t = mesh.triangles[30];
  mesh.vertices.push_back(0.5 * (mesh.vertices[t[0]] + mesh.vertices[t[1]]));
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  mesh.triangles[30] = {t[0], middle, t[2]};
  mesh.triangles.push_back({middle, t[1], t[2]}), mesh.triangles.push_back({t[0], t[1], middle});
  const auto both = scan_of({folder.put("both.ply", write_mesh_ply(mesh))});
  const std::string more = std::to_string(mesh.triangles.size());
  CHECK(both.warnings == std::vector<std::string>{"both.ply: of " + more +
                                                  " facets 3 face the wrong way and were turned, 1 has no area"});
  CHECK(topology(both.mesh).closed());
}

TEST_CASE("read_scan: poses of a scan.json move points, normals and rays, its guesses only when asked for") {
  Folder folder;
  PointCloud cloud;
  cloud.points = {{1, 2, 3}};
  cloud.normals = {{1, 0, 0}};
  cloud.rays = {{0, 1, 0}};
  folder.put("v.ply", write_cloud_ply(cloud));
  folder.put("scan.json", R"({"views": [{"ply": "v.ply", "camera_to_world": )" + turned +
                              R"(, "initial_guess": [[1,0,0,7],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
  const auto scan = scan_of({folder.directory.path()});
  CHECK(scan.cloud.points[0] == Vec3(8, 21, 33));
  CHECK(scan.cloud.normals[0] == Vec3(0, 1, 0));
  CHECK(scan.cloud.rays[0] == Vec3(-1, 0, 0));
  CHECK(scan.views[0].world_from_view.translation == Vec3(10, 20, 30));
  ReadOptions guess;
  guess.initial_guess = true;
  CHECK(scan_of({folder.directory.path()}, guess).cloud.points[0] == Vec3(8, 2, 3));
}

TEST_CASE("read_scan: a height map grows towards its sensor, and no return is no point") {
  Folder folder;
  folder.put("range_0.png", write_png({3, 2, {0, 10, 0, 0, 0, 20}}));
  folder.put("scan.json",
             R"({"unit": "mm", "projection": "orthographic", "images": [{"index": 0, "width": 3, "height": 2,
    "pixel_size": {"x": 0.5, "y": 0.25, "z": 0.1}, "origin": {"x": -4, "y": 1, "z": 2}}]})");
  const auto scan = scan_of({folder.directory.path()});
  REQUIRE(scan.cloud.size() == 2);
  CHECK((scan.cloud.points[0] - Vec3(-3.5, 1, 3)).norm() < 1e-12);
  CHECK((scan.cloud.points[1] - Vec3(-3, 1.25, 4)).norm() < 1e-12);
  CHECK(scan.cloud.rays == std::vector<Vec3>(2, Vec3(0, 0, -1)));
  CHECK(scan.cloud.pixel == std::vector<std::int32_t>{1, 5});
  CHECK(!scan.views[0].has_sensor);
}

TEST_CASE("read_scan: poses.json beside a cloud says how sure its views are, if it speaks of this cloud") {
  const Folder folder;
  PointCloud cloud;
  for (int i = 0; i < 20; ++i) cloud.points.emplace_back(i, i * i, 1), cloud.view.push_back(i % 2);
  const std::string bytes = write_cloud_ply(cloud), sum = sha256(bytes);
  const Path path = folder.put("cloud.ply", bytes);
  CHECK(scan_of({path}).pose_covariance.matrix.size() == 0);
  const auto poses = [](const std::string& of, const std::string& last) {
    std::string rows;
    for (int r = 0; r < 12; ++r) {
      rows += r == 0 ? "[" : ", [";
      for (int c = 0; c <= r; ++c)
        rows += (c == 0 ? "" : ", ") + (r == 11 && c == 11 ? last : std::to_string(r == c ? 2 + r : c));
      rows += "]";
    }
    return R"({"center": [1, 2, 3], "cloud_sha256": ")" + of + R"(", "covariance_between_views": [)" + rows + "]}";
  };
  folder.put("poses.json", poses(sum, "13"));
  const Scan scan = scan_of({path});
  CHECK(scan.files == std::vector<std::string>{"cloud.ply", "poses.json"});
  CHECK(scan.pose_covariance.center == Vec3(1, 2, 3));
  REQUIRE(scan.pose_covariance.matrix.rows() == 12);
  CHECK(scan.pose_covariance.matrix(11, 11) == 13);
  CHECK(scan.pose_covariance.matrix(7, 3) == 3);
  CHECK(scan.pose_covariance.matrix(3, 7) == 3);

  folder.put("poses.json", poses(sha256("another cloud"), "13"));
  CHECK(scan_of({path}).pose_covariance.matrix.size() == 0);
  for (const std::string wrong : {"-1", "\"much\"", "1, 2"}) {
    folder.put("poses.json", poses(sum, wrong));
    const Scan without = scan_of({path});
    CHECK(without.pose_covariance.matrix.size() == 0);
    REQUIRE(without.warnings.size() == 1);
    CHECK(without.warnings[0].find("poses.json: expected a center and the lower triangle") != std::string::npos);
  }
  folder.put("poses.json", poses(sum, std::string(1'000'000, '[') + std::string(1'000'000, ']')));
  CHECK(scan_of({path}).pose_covariance.matrix.size() == 0);
  ReadOptions inches;
  inches.unit = parse_unit("inch");
  folder.put("poses.json", poses(sum, "13"));
  CHECK(scan_of({path}, inches).pose_covariance.matrix.size() == 0);
}

TEST_CASE("read_scan: an image with a sidecar, orthographic or pinhole") {
  Folder folder;
  const auto png = folder.put("part.png", write_png({2, 2, {9, 1, 3, 9}}));
  folder.put("part.json",
             R"({"unit": "cm", "invalid_code": 9, "scale": 0.5, "offset": 10,
          "x0": 1, "y0": 2, "pitch_x": 0.1, "pitch_y": 0.2})");
  const auto flat = scan_of({png});
  REQUIRE(flat.cloud.size() == 2);
  CHECK((flat.cloud.points[0] - Vec3(11, 20, 105)).norm() < 1e-12);  // z = 10 + 0.5 cm
  CHECK((flat.cloud.points[1] - Vec3(10, 22, 115)).norm() < 1e-12);
  CHECK(flat.cloud.rays[0] == Vec3(0, 0, 1));
  CHECK(flat.files == std::vector<std::string>{"part.json", "part.png"});
  folder.put("part.json",
             R"({"K": [[100, 0, 0], [0, 50, 1], [0, 0, 1]], "invalid": 9, "z0": 200, "q": 2, "camera_to_world": )" +
                 turned + "}");
  const auto pinhole = scan_of({png});
  // Code 1 in column 1, row 0: (2, -4, 200) in the sensor's frame.
  CHECK((pinhole.cloud.points[0] - Vec3(14, 22, 230)).norm() < 1e-12);
  CHECK(pinhole.views[0].has_sensor);
  const Vec3 sensor = pinhole.views[0].world_from_view.translation;
  for (std::size_t i = 0; i < 2; ++i)
    CHECK((pinhole.cloud.rays[i] - (pinhole.cloud.points[i] - sensor).normalized()).norm() < 1e-15);
}

TEST_CASE("read_scan: depths of numpy need a camera, and no codes") {
  Folder folder;
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }";
  header.resize(117, ' ');
  const auto put_depths = [&](const std::array<float, 2>& depths) {
    return folder.put("depth.npy", std::string("\x93NUMPY\1\0\x76\0", 10) + header + "\n" +
                                       std::string(reinterpret_cast<const char*>(depths.data()), 8));
  };
  const auto npy = put_depths({0.5f, 0.25f});
  folder.put("depth.json", R"({"unit": "m", "fx": 100, "fy": 100, "cx": 0, "cy": 0})");
  const auto scan = scan_of({npy});
  REQUIRE(scan.cloud.size() == 2);
  CHECK((scan.cloud.points[0] - Vec3(0, 0, 500)).norm() < 0.01);
  CHECK((scan.cloud.points[1] - Vec3(2.5, 0, 250)).norm() < 0.01);
  CHECK(scan.views[0].has_sensor);
  CHECK_THAT(failure_of({put_depths({1e37f, 1e38f})}), Catch::Contains("expected coordinates below"));
}

TEST_CASE("read_scan: a Stanford .conf joins its views") {
  // The quaternion (i j k w) turns the world into the view, as in the published files.
  Folder folder;
  folder.put("a.xyz", "1 2 3\n");
  folder.put("b.xyz", "2 -1 3\n");  // the same place seen from a sensor turned by 90 degrees about z
  const auto conf = folder.put(
      "part.conf",
      "camera 0 0 0 0 0 0 1\nbmesh a.xyz 10 20 30 0 0 0 1\nbmesh b.xyz 10 20 30 0 0 -0.70710678 0.70710678\n\n");
  const auto scan = scan_of({conf});
  CHECK((scan.cloud.points[0] - Vec3(11, 22, 33)).norm() < 1e-12);
  CHECK((scan.cloud.points[1] - Vec3(11, 22, 33)).norm() < 1e-6);
}

TEST_CASE("read_scan: bad inputs are refused in one line that names file and place") {
  Folder folder;
  folder.put("p.xyz", "1 2 3\n");
  folder.put("r.png", write_png({1, 1, {5}}));
  folder.put("none.png", write_png({1, 1, {0}}));
  const auto view = [](const std::string& fields) { return R"({"views": [{)" + fields + "}]}"; };
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"{\"views\": [", "expected JSON, found something else"},
      {"[1, 2]", "expected a JSON object, found array"},
      {std::string(100'000, '['), "expected JSON"},
      {"{}", "expected a list \"views\" or \"images\", found nothing"},
      {R"({"views": []})", "expected a list \"views\" or \"images\", found []"},
      {R"({"views": [7]})", "views[0]: expected an object, found 7"},
      {view(""), "views[0]: expected a file (png, pgm, npy, ply or file), found {}"},
      {view(R"("ply": 5)"), "views[0].ply: expected a file name, found 5"},
      {view(R"("ply": "lost.ply")"), "lost.ply"},
      {view(R"("ply": "p.xyz", "camera_to_world": [1, 2, 3])"), "camera_to_world: expected a 4 x 4 matrix"},
      {view(R"("ply": "p.xyz", "camera_to_world": [[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]])"),
       "expected a rotation without scale or mirror"},
      {view(R"("ply": "p.xyz", "camera_to_world": [[-1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])"),
       "expected a rotation without scale or mirror"},
      {view(R"("png": "r.png", "z0": 1, "q": 1)"), "expected K or fx, fy, cx, cy (pinhole)"},
      {view(R"("png": "r.png", "q": 1)"), "views[0].z0: expected a number, found nothing"},
      {view(R"("png": "r.png", "z0": 1, "q": 0)"), "views[0].q: expected a step other than 0, found 0"},
      {view(R"("png": "r.png", "z0": 1, "q": 1, "K": [[1, 0], [0, 1]])"), "views[0].K: expected a 3 x 3 matrix"},
      {view(R"("png": "r.png", "z0": 1, "q": 1, "width": 9)"), "views[0].width: expected 1 as r.png has, found 9"},
      {view(R"("png": "r.png", "invalid_code": 70000)"), "invalid_code: expected a code from 0 to 65535"},
      {view(R"("png": "none.png", "z0": 1, "q": 1, "fx": 1, "fy": 1, "cx": 0, "cy": 0)"),
       "expected points, found not one return in all images"},
  };
  for (const auto& [text, message] : bad) {
    CAPTURE(text.substr(0, 200));
    CHECK_THAT(failure_of({folder.put("bad.json", text)}), Catch::Contains(message));
  }
  CHECK_THAT(failure_of({folder.directory.path() / "r.png"}), Catch::Contains("r.png: expected r.json beside it"));
  CHECK_THAT(failure_of({folder.directory.path() / "lost.stl"}), Catch::Contains("lost.stl"));
  CHECK_THAT(failure_of({folder.directory.path()}), Catch::Contains("expected scan.json in this folder"));
  CHECK_THAT(failure_of({folder.put("bad.conf", "bmesh p.xyz 1 2 3\n")}),
             Catch::Contains("line 1: expected a file, tx ty tz and qi qj qk qw, found 4 words"));
  CHECK_THAT(failure_of({}), Catch::Contains("expected a file or folder"));
}
