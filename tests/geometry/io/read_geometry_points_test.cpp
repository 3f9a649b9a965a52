/// Point files: every format gives back the points that were written, wherever they lie.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>

#include "core/number.h"
#include "core/random.h"
#include "geometry/io/read_geometry.h"

using namespace partscribe::geometry;

namespace {

template <class T>
void put(std::string& out, T value, bool big_endian = false) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof value);
  if (big_endian) std::reverse(bytes, bytes + sizeof(T));
  out.append(bytes, sizeof(T));
}

std::vector<Vec3> random_points(std::size_t count, const Vec3& center, double size, std::uint64_t seed = 3) {
  Random random(seed);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = center[k] + random.uniform(-size, size);
    points.push_back(p);
  }
  return points;
}

std::string lines(const std::vector<Vec3>& points, const std::string& separator, const std::string& tail = "") {
  std::string text;
  for (const auto& p : points)
    text += print_number(p.x()) + separator + print_number(p.y()) + separator + print_number(p.z()) + tail + "\n";
  return text;
}

RawGeometry parsed(const std::string& bytes, const std::string& name) {
  auto result = parse_geometry(bytes, name);
  INFO((result.ok() ? std::string() : result.error().message));
  REQUIRE(result.ok());
  return *result;
}

// 500 km from the origin, where single precision knows only every 30 mm.
const auto far_points = random_points(200, Vec3(5.6e8, -6.1e8, 2.4e5), 50);

}  // namespace

TEST_CASE("read text points: nothing is lost far from the origin, whatever parts the columns") {
  const auto& p = far_points;
  CHECK(parsed(lines(p, " "), "a.xyz").cloud.points == p);
  CHECK(parsed(lines(p, "\t"), "a.asc").cloud.points == p);
  CHECK(parsed(lines(p, ","), "a.csv").cloud.points == p);
  CHECK(parsed(lines(p, ", "), "a.csv").cloud.points == p);
  CHECK(parsed(lines(p, ";"), "a.txt").cloud.points == p);
  CHECK(parsed("x,y,z\n" + lines(p, ","), "a.csv").cloud.points == p);
  CHECK(parsed("# a scan\n// X Y Z\n" + lines(p, " "), "a.xyz").cloud.points == p);
  CHECK(parsed(lines(p, " ", " 117 73 49"), "a.xyz").cloud.points == p);
  CHECK(parsed(std::to_string(p.size()) + "\n" + lines(p, " ", " -1203 117 73 49"), "a.pts").cloud.points == p);
  CHECK(parsed(lines(p, " ", " 6.000000000000000000e+00"), "labelled.txt").cloud.points == p);
  CHECK(parsed("\xEF\xBB\xBF" + lines(p, " "), "a.xyz").cloud.points == p);
  CHECK(parsed(lines(p, " "), "unknown.suffix").cloud.points == p);
}

TEST_CASE("read text points: Windows and old Macintosh line ends mean the same") {
  const std::string unix_text = "1 2 3\n4 5 6\n7 8 9\n";
  for (const std::string end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : unix_text) text += c == '\n' ? end : std::string(1, c);
    CHECK(parsed(text, "a.xyz").cloud.points == parsed(unix_text, "a.xyz").cloud.points);
  }
}

TEST_CASE("read text points: decimal commas between semicolons or blanks are decimal points") {
  const std::vector<Vec3> expected = {{1.5, -2.25, 3}, {4, 5.5, 6}};
  CHECK(parsed("1,5;-2,25;3\n4;5,5;6\n", "a.csv").cloud.points == expected);
  CHECK(parsed("1,5 -2,25 3,0\n4,0 5,5 6,0\n", "a.txt").cloud.points == expected);
}

TEST_CASE("read text points: the header's names say which columns are coordinates and normals") {
  const auto raw = parsed("id;nx;ny;nz;Z [mm];Y [mm];X [mm]\n7;0;0;1;30;20;10\n8;0;1;0;33;22;11\n", "a.csv");
  CHECK(raw.cloud.points == std::vector<Vec3>{{10, 20, 30}, {11, 22, 33}});
  CHECK(raw.cloud.normals == std::vector<Vec3>{{0, 0, 1}, {0, 1, 0}});
}

TEST_CASE("read text points: columns four to six, or the last three, are normals only when they are unit vectors") {
  const auto normals = parsed("1 2 3 0 0 1\n4 5 6 0.6 0.8 0\n", "a.xyz").cloud.normals;
  REQUIRE(normals.size() == 2);
  CHECK((normals[1] - Vec3(0.6, 0.8, 0)).norm() < 1e-15);
  CHECK(parsed("1 2 3 10 20 30 0 0 1\n4 5 6 9 9 9 1 0 0\n", "a.xyz").cloud.normals ==
        std::vector<Vec3>{{0, 0, 1}, {1, 0, 0}});
  CHECK(parsed("1 2 3 0 0 1\n4 5 6 255 10 3\n", "a.xyz").cloud.normals.empty());
}

TEST_CASE("read text points: a few bad lines are left out with a warning that names the first") {
  const auto raw = parsed("1 2 3\n4 5 6\noops\n7 8 9\n1 2\n", "a.xyz");
  CHECK(raw.cloud.size() == 3);
  REQUIRE(raw.warnings.size() == 1);
  CHECK(raw.warnings[0] == "a.xyz: 2 lines left out, the first of them line 3 ('oops')");
}

TEST_CASE("read PLY points: ascii, little-endian and big-endian hold the same points") {
  const auto& p = far_points;
  const std::string head =
      "\nelement vertex 200\nproperty uchar red\nproperty double x\nproperty double y\nproperty list uchar short "
      "extra\nproperty double z\nend_header\n";
  CHECK(parsed(
            "ply\nformat ascii 1.0\ncomment made by hand" + head +
                [&] {
                  std::string text;
                  for (const auto& q : p)
                    text += "255 " + print_number(q.x()) + " " + print_number(q.y()) + " 2 7 8 " + print_number(q.z()) +
                            "\n";
                  return text;
                }(),
            "a.ply")
            .cloud.points == p);
  for (const bool big : {false, true}) {
    std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0" + head;
    for (const auto& q : p) {
      put<std::uint8_t>(bytes, 255), put(bytes, q.x(), big), put(bytes, q.y(), big);
      put<std::uint8_t>(bytes, 2), put<std::int16_t>(bytes, 7, big), put<std::int16_t>(bytes, 8, big),
          put(bytes, q.z(), big);
    }
    CHECK(parsed(bytes, "a.ply").cloud.points == p);
  }
}

TEST_CASE("read PLY points: a range grid tells every point its pixel") {
  const std::string text =
      "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\nelement vertex 3\nproperty float x\nproperty "
      "float y\n"
      "property float z\nelement range_grid 6\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 1\n1 0 2\n1 1 3\n1 0\n0\n1 1\n0\n0\n1 2\n";
  const auto raw = parsed(text, "bun.ply");
  CHECK(raw.width == 3);
  CHECK(raw.height == 2);
  CHECK(raw.cloud.pixel == std::vector<std::int32_t>{0, 2, 5});
}

TEST_CASE("write_cloud_ply: every column reads back equal to the last bit") {
  PointCloud cloud;
  cloud.points = far_points;
  Random random(5);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.normals.push_back(i == 7 ? Vec3(0, 0, 0)
                                   : Vec3(random.normal(), random.normal(), random.normal()).normalized());
    cloud.rays.push_back(Vec3(random.normal(), random.normal(), random.normal()).normalized());
    cloud.sigma.push_back(static_cast<float>(random.uniform()));
    cloud.view.push_back(static_cast<std::int32_t>(i % 5) - 1);
    cloud.pixel.push_back(static_cast<std::int32_t>(i * 7919) - 1);
    cloud.rejected.push_back(i % 3 == 0);
  }
  const auto all = parsed(write_cloud_ply(cloud), "cloud.ply").cloud;
  CHECK(all.points == cloud.points);
  CHECK(all.normals == cloud.normals);
  CHECK(all.rays == cloud.rays);
  CHECK(all.sigma == cloud.sigma);
  CHECK(all.view == cloud.view);
  CHECK(all.pixel == cloud.pixel);
  CHECK(all.rejected == cloud.rejected);
  CHECK(parsed(write_cloud_ply(cloud), "cloud.ply").unit == "mm");
  PointCloud bare;
  bare.points = cloud.points;
  const auto back = parsed(write_cloud_ply(bare), "cloud.ply").cloud;
  CHECK(back.points == cloud.points);
  CHECK(
      (back.normals.empty() && back.rays.empty() && back.sigma.empty() && back.view.empty() && back.rejected.empty()));
}

namespace {

std::string pcd_header(const std::string& data, std::size_t width, std::size_t height) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS label x y z normal_x normal_y normal_z\n"
         "SIZE 2 8 8 8 4 4 4\nTYPE U F F F F F F\nCOUNT 1 1 1 1 1 1 1\nWIDTH " +
         std::to_string(width) + "\nHEIGHT " + std::to_string(height) + "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
         std::to_string(width * height) + "\nDATA " + data + "\n";
}

/// Literal runs only, except that one run of equal bytes is a copy of itself: both kinds of LZF codes.
std::string packed(const std::string& bytes) {
  std::string out;
  std::size_t at = 0;
  while (at < bytes.size()) {
    std::size_t run = 1;
    while (at + run < bytes.size() && bytes[at + run] == bytes[at]) ++run;
    if (run >= 20) {
      const std::size_t length = std::min<std::size_t>(run - 1, 264);
      out += '\0', out += bytes[at];                                                        // one literal
      out += static_cast<char>(7 << 5), out += static_cast<char>(length - 9), out += '\0';  // then a copy from one back
      at += length + 1;
      continue;
    }
    const std::size_t length = std::min<std::size_t>(run, bytes.size() - at);
    for (std::size_t i = 0; i < length; ++i) out += '\0', out += bytes[at + i];
    at += length;
  }
  return out;
}

}  // namespace

TEST_CASE("read PCD: ascii, binary and binary_compressed hold the same points, organised ones know their pixels") {
  auto p = far_points;
  p.resize(60);
  for (std::size_t i = 20; i < 40; ++i) p[i].z() = 0;  // something to compress
  const Vec3 n(0, 0, 1);
  std::string ascii = pcd_header("ascii", 10, 6), binary = pcd_header("binary", 10, 6), planes;
  for (const auto& q : p) {
    ascii += "3 " + print_number(q.x()) + " " + print_number(q.y()) + " " + print_number(q.z()) + " 0 0 1\n";
    put<std::uint16_t>(binary, 3);
    for (int k = 0; k < 3; ++k) put(binary, q[k]);
    for (int k = 0; k < 3; ++k) put(binary, static_cast<float>(n[k]));
  }
  for (std::size_t i = 0; i < p.size(); ++i) put<std::uint16_t>(planes, 3);
  for (int k = 0; k < 3; ++k)
    for (const auto& q : p) put(planes, q[k]);
  for (int k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < p.size(); ++i) put(planes, static_cast<float>(n[k]));
  const auto small = packed(planes);
  std::string compressed = pcd_header("binary_compressed", 10, 6);
  put<std::uint32_t>(compressed, static_cast<std::uint32_t>(small.size()));
  put<std::uint32_t>(compressed, static_cast<std::uint32_t>(planes.size()));
  compressed += small;
  for (const auto& bytes : {ascii, binary, compressed}) {
    const auto raw = parsed(bytes, "a.pcd");
    CHECK(raw.cloud.points == p);
    CHECK(raw.cloud.normals == std::vector<Vec3>(p.size(), n));
    CHECK(raw.width == 10);
    CHECK(raw.height == 6);
    CHECK(raw.cloud.pixel.back() == 59);
  }
}

TEST_CASE("read PCD: padding fields are skipped, also those of no bytes") {
  const std::vector<Vec3> p = {{1, 2, 3}, {4, 5, 6.5}};
  const std::string head =
      "VERSION 0.7\nFIELDS x y _ z _ intensity _\nSIZE 4 4 1 4 1 4 1\nTYPE F F U F U F U\nCOUNT 1 1 4 1 0 1 3\nWIDTH "
      "2\nHEIGHT 1\nPOINTS 2\nDATA ";
  std::string ascii = head + "ascii\n", binary = head + "binary\n";
  for (const auto& v : p) {
    ascii += print_number(v.x()) + " " + print_number(v.y()) + " 9 9 9 9 " + print_number(v.z()) + " 0.5 7 7 7\n";
    put(binary, float(v.x())), put(binary, float(v.y())), binary += "pad!", put(binary, float(v.z())),
        put(binary, 0.5f), binary += "pad";
  }
  CHECK(parsed(ascii, "a.pcd").cloud.points == p);
  CHECK(parsed(binary, "a.pcd").cloud.points == p);
}

TEST_CASE("read PCD: pixels without return are no points and no cause for a warning") {
  const auto raw = parsed(
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 2\nPOINTS 4\nDATA ascii\n"
      "nan nan nan\n1 2 3\nnan nan nan\nnan nan nan\n",
      "frame.pcd");
  CHECK(raw.cloud.points == std::vector<Vec3>{{1, 2, 3}});
  CHECK(raw.cloud.pixel == std::vector<std::int32_t>{1});
  CHECK(raw.warnings.empty());
}

TEST_CASE("read points: few that are no places are left out with a warning, many are an error") {
  const auto raw = parsed("1 2 3\n4 nan 6\n7 8 9\n1 2 1e300\n1 1 1\n", "a.xyz");
  CHECK(raw.cloud.points == std::vector<Vec3>{{1, 2, 3}, {7, 8, 9}, {1, 1, 1}});
  CHECK(raw.warnings == std::vector<std::string>{"a.xyz: 2 of 5 points without finite coordinates left out"});
  const auto bad = parse_geometry("nan 2 3\n4 inf 6\n7 8 9\n", "a.xyz");
  REQUIRE(!bad.ok());
  CHECK(bad.error().message == "a.xyz: expected finite coordinates, found none in 2 of 3 points");
}

TEST_CASE("read points: returns that are missing, written as zeros, are left out and counted in one line") {
  const std::vector<Vec3> real = random_points(300, Vec3(80, 50, 20), 10);
  const auto with = [&](std::vector<Vec3> more) {
    more.insert(more.end(), real.begin(), real.end());
    return parsed(lines(more, " "), "a.xyz");
  };
  const auto many = with(std::vector<Vec3>(1000, Vec3::Zero()));
  CHECK(many.cloud.points == real);
  CHECK(many.warnings ==
        std::vector<std::string>{
            "a.xyz: 1000 of 1300 points are exactly 0 0 0, as sensors write missing returns; left out"});
  CHECK(with(std::vector<Vec3>(2, Vec3::Zero())).cloud.points == real);
  // One point there may be true; so may several where the file repeats other places as often.
  CHECK(with({Vec3::Zero()}).cloud.size() == 301);
  CHECK(with({Vec3::Zero(), Vec3::Zero(), real[0], real[1], real[1]}).cloud.size() == 305);
  CHECK(with({Vec3::Zero()}).warnings.empty());
  // An image in the frame of its sensor has no point there.
  const auto image = parsed(
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 2\nPOINTS 4\nDATA ascii\n"
      "0 0 0\n1 2 3\n4 5 6\nnan nan nan\n",
      "frame.pcd");
  CHECK(image.cloud.points == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
  CHECK(image.cloud.pixel == std::vector<std::int32_t>{1, 2});
  // A mesh's vertex at the origin is a vertex.
  CHECK(parsed("v 0 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 4\n", "a.obj").mesh.triangles.size() == 1);
  const auto none = parse_geometry("0 0 0\n0 0 0\n0 0 0\n", "a.xyz");
  REQUIRE(!none.ok());
  CHECK(none.error().message == "a.xyz: expected points, found only 3 that are exactly 0 0 0");
}

TEST_CASE("read points: of a place that is repeated again and again one point stays") {
  const std::vector<Vec3> real = random_points(300, Vec3(80, 50, 20), 10);
  std::vector<Vec3> all(500, Vec3(1, 2, 3));
  all.insert(all.end(), real.begin(), real.end());
  all.insert(all.end(), 400, Vec3(1, 2, 4));
  const auto raw = parsed(lines(all, " "), "a.xyz");
  CHECK(raw.cloud.size() == 302);
  CHECK(raw.warnings ==
        std::vector<std::string>{"a.xyz: 898 of 1200 points repeat 2 places exactly; one is kept of each"});
  // Coarse numbers repeat many places: each is a measurement.
  std::vector<Vec3> coarse;
  for (const auto& p : random_points(20'000, Vec3(0, 0, 0), 4))
    coarse.emplace_back(std::round(p.x()), std::round(p.y()), 5);
  CHECK(parsed(lines(coarse, " "), "a.xyz").cloud.size() == coarse.size());
}

TEST_CASE("read points: a million points take seconds at most") {
  const auto points = random_points(1'000'000, Vec3(0, 0, 0), 100);
  PointCloud cloud;
  cloud.points = points;
  const auto binary = write_cloud_ply(cloud);
  const auto text = lines(points, " ");
  const auto seconds = [](const std::string& bytes, const std::string& name, std::size_t count) {
    const auto begin = std::chrono::steady_clock::now();
    const auto result = parse_geometry(bytes, name);
    REQUIRE(result.ok());
    CHECK(result->cloud.size() == count);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  // Generous: other work may share the machine; a quadratic reader would take hours.
  const double ply = seconds(binary, "a.ply", points.size()), xyz = seconds(text, "a.xyz", points.size());
  CAPTURE(ply, xyz);
  CHECK(ply < 5);
  CHECK(xyz < 15);
}
