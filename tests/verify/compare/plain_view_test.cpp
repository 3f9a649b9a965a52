/// What sticks out of a part in plain view and was not scanned is refused; what a scanner cannot see is not.
#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "testing/meshes.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

using Boxes = std::vector<Box3>;

Box3 span(const Vec3& low, const Vec3& high) {
  Box3 box;
  box.add(low), box.add(high);
  return box;
}

/// The union of `solids` without the union of `holes`.
TriangleMesh made_of(const Boxes& solids, const Boxes& holes = {}) {
  std::array<std::vector<double>, 3> cuts;
  for (std::size_t k = 0; k < 3; ++k) {
    std::set<double> values;
    for (const auto* list : {&solids, &holes})
      for (const auto& b : *list) values.insert(b.low[Eigen::Index(k)]), values.insert(b.high[Eigen::Index(k)]);
    cuts[k].assign(values.begin(), values.end());
  }
  using Cell = std::array<int, 3>;
  auto at = [&](const Cell& c) {
    return Vec3(cuts[0][std::size_t(c[0])], cuts[1][std::size_t(c[1])], cuts[2][std::size_t(c[2])]);
  };
  auto filled = [&](const Cell& c) {
    for (std::size_t k = 0; k < 3; ++k)
      if (c[k] < 0 || c[k] + 1 >= int(cuts[k].size())) return false;
    const Vec3 middle = 0.5 * (at(c) + at({c[0] + 1, c[1] + 1, c[2] + 1}));
    auto inside = [&](const Box3& b) { return (middle - b.low).minCoeff() > 0 && (b.high - middle).minCoeff() > 0; };
    return std::any_of(solids.begin(), solids.end(), inside) && std::none_of(holes.begin(), holes.end(), inside);
  };
  TriangleMesh mesh;
  std::map<Cell, std::uint32_t> ids;
  auto id = [&](const Cell& c) {
    const auto [place, fresh] = ids.emplace(c, std::uint32_t(mesh.vertices.size()));
    if (fresh) mesh.vertices.push_back(at(c));
    return place->second;
  };
  Cell c;
  for (c[0] = 0; c[0] + 1 < int(cuts[0].size()); ++c[0])
    for (c[1] = 0; c[1] + 1 < int(cuts[1].size()); ++c[1])
      for (c[2] = 0; c[2] + 1 < int(cuts[2].size()); ++c[2])
        for (std::size_t k = 0; filled(c) && k < 3; ++k)
          for (const int up : {0, 1}) {
            Cell beside = c;
            beside[k] += up ? 1 : -1;
            if (filled(beside)) continue;
            const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
            std::array<Cell, 4> corners = {c, c, c, c};
            for (auto& corner : corners) corner[k] += up;
            ++corners[1][u], ++corners[2][u], ++corners[2][v], ++corners[3][v];
            if (!up) std::swap(corners[1], corners[3]);
            mesh.triangles.push_back({id(corners[0]), id(corners[1]), id(corners[2])});
            mesh.triangles.push_back({id(corners[0]), id(corners[2]), id(corners[3])});
          }
  return mesh;
}

const std::vector<Vec3> around = {{1, 1, 1},  {1, 1, -1},  {1, -1, 1},  {1, -1, -1},
                                  {-1, 1, 1}, {-1, 1, -1}, {-1, -1, 1}, {-1, -1, -1}};

/// Views along `directions`, turned a little, so that none looks along an axis.
Scan seen_along(const TriangleMesh& mesh, const std::vector<Vec3>& directions, double pitch = 0.7) {
  Scan scan;
  const Mat3 turn = rotation_of(Vec3(0.11, 0.07, 0.13));
  for (std::size_t i = 0; i < directions.size(); ++i)
    add_view(scan, mesh, turn * directions[i].normalized(), pitch, 0.03, i + 1);
  return scan;
}

Scan without_rays(Scan scan) {
  scan.cloud.rays.clear(), scan.cloud.view.clear();
  scan.views = {View{}};
  return scan;
}

VerifyOptions at(double tolerance) {
  VerifyOptions options;
  options.tolerance = tolerance;
  return options;
}

const Boxes bracket = {span({0, 0, 0}, {40, 30, 5}), span({0, 0, 0}, {5, 30, 30})};

Boxes with(Boxes solids, const Box3& more) {
  solids.push_back(more);
  return solids;
}

}  // namespace

TEST_CASE("verify: a fin, a pin and a lug that stick out where the scanner looked are refused, with and without rays") {
  const Scan scan = seen_along(made_of(bracket), around), merged = without_rays(scan);
  CHECK(verdict_on(made_of(bracket), scan, at(0.2)).verdict == Outcome::verified);
  CHECK(verdict_on(made_of(bracket), merged, at(0.2)).verdict == Outcome::verified);
  const Box3 fin = span({15, 12, 4}, {35, 12.2, 13}), pin = span({30, 20, 4}, {31, 21, 12}),
             lug = span({18, -6, 1}, {24, 1, 4});
  for (const auto& invented : {fin, pin, lug})
    for (const auto* s : {&scan, &merged}) {
      const Verdict verdict = verdict_on(made_of(with(bracket, invented)), *s, at(0.2));
      INFO(invented.low.transpose() << (s == &scan ? ", with rays" : ", without"));
      CHECK(verdict.verdict == Outcome::out_of_tolerance);
      const auto& findings = verdict.artifacts.front().findings;
      CHECK(std::any_of(findings.begin(), findings.end(),
                        [](const Finding& f) { return f.kind == Finding::Kind::invented_material; }));
    }
}

TEST_CASE("verify: the deep walls of screw holes in bosses are not scanned, and nothing says that they are not there") {
  Boxes solids = {span({0, 0, 0}, {40, 40, 3}), span({0, 0, 0}, {3, 40, 30}), span({37, 0, 0}, {40, 40, 30}),
                  span({0, 0, 0}, {40, 3, 30}), span({0, 37, 0}, {40, 40, 30})};
  for (const double x : {5.5, 26.5}) solids.push_back(span({x, 5.5, 1}, {x + 8, 13.5, 28}));
  const TriangleMesh housing = made_of(solids, {span({8, 8, 4}, {11, 11, 30}), span({29, 8, 4}, {32, 11, 30})});
  std::vector<Vec3> directions = around;
  for (const Vec3& d : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)})
    directions.push_back(d);
  const Scan scan = seen_along(housing, directions);
  for (const Scan& s : {scan, without_rays(scan)}) {
    const Verdict verdict = verdict_on(housing, s, at(0.2));
    INFO(all_reasons(verdict));
    CHECK(verdict.verdict == Outcome::verified);
    CHECK(verdict.artifacts.front().model_to_data.contradicted < 20);
    CHECK(verdict.artifacts.front().model_to_data.not_scanned > 100);
  }
}

TEST_CASE("verify: the sides that one view never saw are not scanned, with and without rays") {
  const TriangleMesh stepped =
      made_of({span({0, 0, 0}, {40, 30, 4}), span({5, 5, 0}, {12, 12, 14}), span({22, 8, 0}, {36, 12, 9})});
  const Scan scan = seen_along(stepped, {{0, 0, -1}});
  for (const Scan& s : {scan, without_rays(scan)}) {
    const Verdict verdict = verdict_on(stepped, s, at(0.2));
    INFO(all_reasons(verdict));
    CHECK(verdict.verdict == Outcome::verified);
    CHECK(verdict.artifacts.front().model_to_data.not_scanned > 1200);
  }
}

TEST_CASE("verify: the walls of a pocket that six views along the axes pass by are not scanned") {
  const TriangleMesh pocketed = made_of({span({0, 0, 0}, {50, 40, 12})}, {span({15, 12, 6}, {35, 28, 12})});
  const std::vector<Vec3> axes = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  const Verdict verdict = verdict_on(pocketed, without_rays(seen_along(pocketed, axes)), at(0.2));
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  CHECK(verdict.artifacts.front().model_to_data.contradicted == 0);
}
