#include "geometry/mesh/handles.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"

using namespace partscribe::core;
using namespace partscribe::geometry;

namespace {

/// A torus about z, or a part of it without its last rings.
TriangleMesh torus(double ring, double tube, std::uint32_t around, std::uint32_t across, std::uint32_t left_out = 0) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double a = 2 * pi * i / around, b = 2 * pi * j / across, r = ring + tube * std::cos(b);
      mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), tube * std::sin(b));
    }
  const auto id = [&](std::uint32_t i, std::uint32_t j) { return i % around * across + j % across; };
  for (std::uint32_t i = 0; i + left_out < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  return welded(mesh, 0);
}

long handles(const TriangleMesh& mesh) {
  const long faces = long(mesh.triangles.size());
  return (2 * long(topology(mesh).components) - (long(mesh.vertices.size()) - 3 * faces / 2 + faces)) / 2;
}

double length_of(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (mesh.vertices[loop[i]] - mesh.vertices[loop[(i + 1) % loop.size()]]).norm();
  return sum;
}

}  // namespace

TEST_CASE("handles: the shortest loop of a torus runs around its tube, or through its hole") {
  const auto thin = torus(10, 2, 60, 16);
  const auto loops = handle_loops(thin, 100);
  REQUIRE(loops.size() == 1);
  CHECK(length_of(thin, loops[0]) == Approx(2 * pi * 2).epsilon(0.02));
  CHECK(handle_loops(thin, 12).empty());  // it is longer

  const auto narrow = torus(10, 8, 60, 60);
  CHECK(length_of(narrow, handle_loops(narrow, 100).at(0)) == Approx(2 * pi * 2).epsilon(0.02));
}

TEST_CASE("handles: cut and filled, a torus is a ball that is closed") {
  const auto mesh = torus(10, 2, 60, 16);
  REQUIRE(handles(mesh) == 1);
  const auto cut = without_handles(mesh, 13);
  const auto after = topology(cut);
  CHECK(after.closed());
  CHECK(after.components == 1);
  CHECK(handles(cut) == 0);
  CHECK(volume(cut) == Approx(volume(mesh)).epsilon(1e-6));
  CHECK(without_handles(mesh, 12).triangles == mesh.triangles);  // a real handle stays
}

TEST_CASE("handles: of several bodies, those that are short") {
  auto mesh = torus(10, 2, 60, 16);
  for (const double at : {40.0, 80.0}) {
    const auto small = torus(4, 1, 40, 12);
    const auto first = std::uint32_t(mesh.vertices.size());
    for (const Vec3& v : small.vertices) mesh.vertices.emplace_back(v + Vec3(at, 0, 0));
    for (const auto& t : small.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  CHECK(handle_loops(mesh, 7).size() == 2);
  const auto cut = without_handles(mesh, 7);
  CHECK(handles(cut) == 1);
  CHECK(topology(cut).components == 3);
}

TEST_CASE("handles: a border counts as filled") {
  const auto pipe = torus(10, 2, 60, 16, 20);
  CHECK(handle_loops(pipe, 100).empty());
}

TEST_CASE("handles: a mesh whose border touches itself is left as it is") {
  // Two triangles that share a corner only.
  TriangleMesh bow;
  bow.vertices = {{0, 0, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}};
  bow.triangles = {{0, 1, 2}, {0, 3, 4}};
  CHECK(handle_loops(bow, 10).empty());
  CHECK(without_handles(bow, 10).triangles == bow.triangles);
}
