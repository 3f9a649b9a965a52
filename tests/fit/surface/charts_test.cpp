#include "fit/surface/charts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <set>

#include "core/number.h"
#include "testing/free_forms.h"
#include "testing/meshes.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

/// What must hold of any charts: every chart is seen from its side, and its borders are closed lines.
void check_charts(const TriangleMesh& mesh, const Charts& charts) {
  REQUIRE(charts.of.size() == mesh.triangles.size());
  std::vector<Vec3> direction(std::size_t(charts.count), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    REQUIRE((charts.of[t] >= 0 && charts.of[t] < charts.count));
    direction[std::size_t(charts.of[t])] +=
        (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
  }
  double steep = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (triangle_normal(mesh, t).dot(direction[std::size_t(charts.of[t])].normalized()) < std::cos(65 * pi / 180))
      ++steep;
  CHECK(steep < 0.005 * double(mesh.triangles.size()));
  // Each end of a border is the beginning of another of the same chart, on either side.
  std::map<int, std::multiset<std::uint32_t>> from, to;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& b : charts.borders) {
    CHECK(b.left != b.right);
    from[b.left].insert(b.vertices.front()), to[b.left].insert(b.vertices.back());
    from[b.right].insert(b.vertices.back()), to[b.right].insert(b.vertices.front());
    for (std::size_t i = 1; i < b.vertices.size(); ++i)
      CHECK(edges.insert(std::minmax(b.vertices[i - 1], b.vertices[i])).second);
  }
  for (int c = 0; c < charts.count; ++c) {
    CHECK(from[c] == to[c]);
    CHECK(std::set(from[c].begin(), from[c].end()).size() == from[c].size());  // it touches itself nowhere
  }
}

}  // namespace

TEST_CASE("charts: a lump and a ring are cut into few charts that each lie open") {
  Context context;
  const auto lump = partscribe::testing::pebble(40), ring = partscribe::testing::wavy_ring(120);
  const Charts of_lump = charts_of(lump, 1, context), of_ring = charts_of(ring, 1, context);
  check_charts(lump, of_lump), check_charts(ring, of_ring);
  CHECK(of_lump.count >= 4);
  CHECK(of_lump.count <= 12);
  CHECK(of_ring.count >= 8);
  CHECK(of_ring.count <= 32);
  for (const auto& b : of_ring.borders) CHECK((b.right >= 0 && !b.crease));
}

TEST_CASE("charts: the faces of a block are charts, all its edges creases") {
  Context context;
  const Charts charts = charts_of(partscribe::testing::box({0, 0, 0}, {30, 20, 10}), 1, context);
  CHECK(charts.count == 6);
  CHECK(charts.borders.size() == 12);
  for (const auto& b : charts.borders) CHECK(b.crease);
}

TEST_CASE("charts: a sheet that lies open is one chart with its two borders") {
  Context context;
  const auto sheet = partscribe::testing::hood();
  const Charts charts = charts_of(sheet, 1, context);
  CHECK(charts.count == 1);
  REQUIRE(charts.borders.size() == 2);
  for (const auto& b : charts.borders) {
    CHECK(b.right == -1);
    CHECK(b.vertices.front() == b.vertices.back());
  }
}

TEST_CASE("charts: a chart is split across its longest direction, the others stay") {
  Context context;
  const auto mesh = partscribe::testing::pebble(40);
  const Charts charts = charts_of(mesh, 1, context), more = with_chart_split(mesh, charts, 1);
  check_charts(mesh, more);
  CHECK(more.count == charts.count + 1);
  // What was together elsewhere is together still, but for a few triangles beside the cut.
  std::map<std::pair<int, int>, int> shared;
  for (std::size_t t = 0; t < charts.of.size(); ++t) shared[{charts.of[t], more.of[t]}] += 1;
  int most[2] = {0, 0};
  for (const auto& [pair, count] : shared)
    if (pair.first == 1 && count > most[1]) most[1] = count, std::sort(most, most + 2, std::greater<>());
  CHECK(most[1] > most[0] / 3);
}
