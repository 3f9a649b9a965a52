/// Networks of curves over bodies of several topologies, filled by patches without a crease at any joint.
#include "geometry/surfaces/curve_network.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "core/number.h"
#include "geometry/surfaces/trimmed_surface.h"

using namespace partscribe::geometry;

namespace {

using QuadFaces = std::vector<std::array<std::uint32_t, 4>>;
using OnSurface = std::function<Vec3(const Vec3&)>;

/// Nodes of quadrilaterals before they are put on a surface.
struct QuadMesh {
  std::vector<Vec3> nodes;
  QuadFaces faces;
};

/// Three meet in each node.
QuadMesh cube_of_quads() {
  QuadMesh cube;
  for (int k = 0; k < 8; ++k) cube.nodes.emplace_back(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
  cube.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  return cube;
}

/// Every face with n corners becomes n quadrilaterals about its middle: nodes of as many faces as it has corners.
QuadMesh in_quads(const std::vector<Vec3>& nodes, const std::vector<std::vector<std::uint32_t>>& faces) {
  QuadMesh result{nodes, {}};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, fresh] = middles.try_emplace({std::min(a, b), std::max(a, b)}, std::uint32_t(result.nodes.size()));
    if (fresh) result.nodes.push_back(0.5 * (nodes[a] + nodes[b]));
    return at->second;
  };
  for (const auto& face : faces) {
    Vec3 sum = Vec3::Zero();
    for (const auto v : face) sum += nodes[v] / double(face.size());
    const auto centre = std::uint32_t(result.nodes.size());
    result.nodes.push_back(sum);
    for (std::size_t k = 0; k < face.size(); ++k) {
      const auto a = face[k], before = face[(k + face.size() - 1) % face.size()], after = face[(k + 1) % face.size()];
      result.faces.push_back({a, middle(a, after), centre, middle(before, a)});
    }
  }
  return result;
}

QuadMesh finer(const QuadMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> faces;
  for (const auto& f : mesh.faces) faces.emplace_back(f.begin(), f.end());
  return in_quads(mesh.nodes, faces);
}

/// Nodes where three, four and five faces meet.
QuadMesh icosahedron_of_quads() {
  const double g = 0.5 * (1 + std::sqrt(5.0));
  const std::vector<Vec3> nodes = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  return in_quads(nodes, {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                          {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                          {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}});
}

/// Of the places that `on` gives in directions near n.
Vec3 normal_of(const OnSurface& on, const Vec3& n) {
  const Vec3 x = n.unitOrthogonal(), y = n.cross(x);
  constexpr double h = 1e-5;
  return Vec3(on((n + h * x).normalized()) - on((n - h * x).normalized()))
      .cross(Vec3(on((n + h * y).normalized()) - on((n - h * y).normalized())))
      .normalized();
}

CurveNetwork network_on(const QuadMesh& mesh, const OnSurface& on) {
  std::vector<Vec3> nodes, normals;
  for (const Vec3& p : mesh.nodes)
    nodes.push_back(on(p.normalized())), normals.push_back(normal_of(on, p.normalized()));
  return network_through(nodes, normals, mesh.faces);
}

Vec3 on_ball(const Vec3& n) { return 20 * n; }
Vec3 on_lump(const Vec3& n) {
  const double r = 20 + 2.5 * std::sin(2.2 * n.x() + 1) + 2.2 * n.x() * n.y() - 2 * std::cos(2.6 * n.z() + n.x());
  return r * n;
}

CurveNetwork ring_network() {
  std::vector<Vec3> nodes, normals;
  QuadFaces faces;
  constexpr std::uint32_t around = 8, tube = 5;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < tube; ++j) {
      const double u = 2 * partscribe::core::pi * i / around, v = 2 * partscribe::core::pi * j / tube;
      const Vec3 out(std::cos(u), std::sin(u), 0), n = std::cos(v) * out + std::sin(v) * Vec3::UnitZ();
      nodes.push_back(30 * out + 9 * n + 2 * std::sin(3 * u) * Vec3::UnitZ());
      normals.push_back((n + 0.1 * std::cos(2 * u) * Vec3::UnitZ()).normalized());
      const auto at = [&](std::uint32_t a, std::uint32_t b) { return (a % around) * tube + b % tube; };
      faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return network_through(nodes, normals, faces);
}

/// Where a patch is and which way it faces.
struct PlaceAndNormal {
  Vec3 place, normal;
};
using Evaluated = std::function<PlaceAndNormal(std::size_t face, double u, double v)>;

/// The largest gap (mm) and sine of an angle between normals along all joints of two faces, from so many
/// fortieths of their length on; how many these are.
struct Joints {
  int count = 0;
  double gap = 0, sine = 0;
};

Joints joints_of(const QuadFaces& faces, const Evaluated& at, int from = 0) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::pair<std::size_t, std::size_t>>> sides;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 4; ++k) {
      const auto a = faces[f][k], b = faces[f][(k + 1) % 4];
      sides[{std::min(a, b), std::max(a, b)}].emplace_back(f, k);
    }
  const auto on_side = [&](const std::pair<std::size_t, std::size_t>& side, double t) {
    const std::size_t f = side.first, k = side.second;
    if (faces[f][k] > faces[f][(k + 1) % 4]) t = 1 - t;
    return k == 0 ? at(f, t, 0) : k == 1 ? at(f, 1, t) : k == 2 ? at(f, 1 - t, 1) : at(f, 0, 1 - t);
  };
  Joints joints;
  for (const auto& [nodes, two] : sides) {
    if (two.size() != 2) continue;
    ++joints.count;
    for (int i = from; i <= 40 - from; ++i) {
      const auto a = on_side(two[0], i / 40.0), b = on_side(two[1], i / 40.0);
      joints.gap = std::max(joints.gap, (a.place - b.place).norm());
      joints.sine = std::max(joints.sine, a.normal.cross(b.normal).norm());
      if (a.normal.dot(b.normal) <= 0) joints.sine = 2;
    }
  }
  return joints;
}

Evaluated by_patches(const std::vector<GregoryPatch>& patches) {
  return [&](std::size_t f, double u, double v) {
    const auto t = patches[f].tangents(u, v);
    return PlaceAndNormal{t.p, t.normal()};
  };
}

}  // namespace

TEST_CASE("curve network: patches of cubes, icosahedra and rings have one tangent plane all along each joint") {
  const struct {
    CurveNetwork network;
    int joints;
  } cases[] = {{network_on(cube_of_quads(), on_lump), 12},
               {network_on(icosahedron_of_quads(), on_lump), 120},
               {ring_network(), 80}};
  for (const auto& [network, count] : cases) {
    const auto patches = gregory_patches(network);
    REQUIRE(patches);
    const Joints joints = joints_of(network.faces, by_patches(*patches));
    CHECK(joints.count == count);
    CHECK(joints.gap < 1e-12);
    CHECK(joints.sine < 1e-9);
    // At nodes the plane is the one that was asked for, facing outwards.
    for (std::size_t f = 0; f < patches->size(); ++f)
      CHECK((*patches)[f].tangents(0, 0).normal().dot(network.normals[network.faces[f][0]]) > 1 - 1e-9);
  }
}

TEST_CASE("curve network: twists disagree, and bicubic patches through the same network would crease") {
  const CurveNetwork network = network_on(cube_of_quads(), on_lump);
  auto patches = *gregory_patches(network);
  double twist = 0;
  for (GregoryPatch& patch : patches)
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t j = 0; j < 2; ++j) {
        twist = std::max(twist, (patch.across_u[i][j] - patch.across_v[i][j]).norm());
        patch.across_u[i][j] = patch.across_v[i][j] = 0.5 * (patch.across_u[i][j] + patch.across_v[i][j]);
      }
  CHECK(twist > 0.1);
  const Joints bicubic = joints_of(network.faces, by_patches(patches));
  CHECK(bicubic.gap < 1e-12);
  CHECK(bicubic.sine > 0.01);
  // One inner control point that is off is enough.
  patches = *gregory_patches(network);
  patches[2].across_v[0][0] += Vec3(0, 0, 0.01);
  CHECK(joints_of(network.faces, by_patches(patches)).sine > 1e-5);
}

TEST_CASE("curve network: as NURBS the patches meet in the same places with the same tangent planes") {
  for (const auto& network : {network_on(cube_of_quads(), on_lump), ring_network()}) {
    const auto patches = gregory_patches(network);
    REQUIRE(patches);
    std::vector<NurbsSurface> surfaces;
    for (const GregoryPatch& patch : *patches) {
      surfaces.push_back(rational_bezier(patch));
      CHECK(surfaces.back().u.degree <= 7);
      for (int i = 0; i <= 16; ++i)
        for (int j = 0; j <= 16; ++j)
          CHECK((surfaces.back().at(i / 16.0, j / 16.0) - patch.at(i / 16.0, j / 16.0)).norm() < 1e-9);
    }
    const Evaluated by_surfaces = [&](std::size_t f, double u, double v) {
      return PlaceAndNormal{surfaces[f].at(u, v), normal_at(surfaces[f], u, v)};
    };
    const Joints joints = joints_of(network.faces, by_surfaces, 1);
    CHECK(joints.gap < 1e-9);
    CHECK(joints.sine < 1e-7);
  }
}

TEST_CASE("curve network: its faces as trimmed surfaces share their edges and close a body") {
  const CurveNetwork network = network_on(icosahedron_of_quads(), on_lump);
  const auto patches = gregory_patches(network);
  REQUIRE(patches);
  const auto faces = trimmed_faces(network, *patches);
  REQUIRE(faces.size() == 60);
  const SurfaceTriangles triangles = triangulated(faces, 0.02);
  CHECK(topology(triangles.mesh).closed());
  CHECK(volume(triangles.mesh) > 0);
  CHECK(triangles.deviation < 0.05);
  for (std::size_t t = 0; t < triangles.mesh.triangles.size(); ++t) {
    const Vec2 middle = (triangles.place[t][0] + triangles.place[t][1] + triangles.place[t][2]) / 3;
    const Vec3 place = (triangles.mesh.corner(t, 0) + triangles.mesh.corner(t, 1) + triangles.mesh.corner(t, 2)) / 3;
    CHECK(((*patches)[triangles.patch[t]].at(middle.x(), middle.y()) - place).norm() < 0.2);
  }
}

TEST_CASE("curve network: six patches make a ball to a tenth, and each division leaves a seventh of that") {
  double last = 1;
  QuadMesh mesh = cube_of_quads();
  for (const double most : {0.1, 0.006, 0.0008}) {
    const auto patches = gregory_patches(network_on(mesh, on_ball));
    REQUIRE(patches);
    double worst = 0;
    for (const GregoryPatch& patch : *patches)
      for (int i = 0; i <= 10; ++i)
        for (int j = 0; j <= 10; ++j) worst = std::max(worst, std::abs(patch.at(i / 10.0, j / 10.0).norm() / 20 - 1));
    INFO(patches->size() << " patches: " << worst);
    CHECK(worst < most);
    CHECK(worst < last / 6);
    last = worst;
    mesh = finer(mesh);
  }
}

TEST_CASE("curve network: bad_networks say which curve, and where") {
  CurveNetwork network = network_on(cube_of_quads(), on_ball);
  const CurveNetwork good = network;
  for (NetworkCurve& c : network.curves)
    if (std::min(c.from, c.to) == 2 && std::max(c.from, c.to) == 3) (c.from == 2 ? c.first : c.second) *= 1.05;
  const auto steep = gregory_patches(network);
  REQUIRE(!steep);
  CHECK(steep.error().message.find("expected curves in the tangent planes of their nodes, the curve between nodes ") ==
        0);
  CHECK(steep.error().message.find("leaves that of node 2 by 0.") != std::string::npos);
  network = good;
  network.curves.pop_back();
  const auto missing = gregory_patches(network);
  REQUIRE(!missing);
  CHECK(missing.error().message.find("of a face, found none") != std::string::npos);
  network = good;
  network.curves[0].first = network.nodes[network.curves[0].from];
  const auto still = gregory_patches(network);
  REQUIRE(!still);
  CHECK(still.error().message.find("has no direction at node") != std::string::npos);
}
