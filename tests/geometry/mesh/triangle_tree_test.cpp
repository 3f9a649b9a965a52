/// Claims about the search in trees of triangles: exact to the bit, whatever the mesh, the query and the machine.
#include "geometry/mesh/triangle_tree.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "core/random.h"
#include "geometry/mesh/mesh_distance.h"

using namespace partscribe::geometry;

namespace {

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double sq_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a, pa = p - a, pb = p - b;
  const double along = dot(ab, pa), length2 = dot(ab, ab);
  if (along >= length2) return dot(pb, pb);
  const Vec3 d = pa - (along > 0 ? along / length2 : 0) * ab;
  return dot(d, d);
}

/// What the search promises, one triangle after the other: the same expressions on the same sorted corners.
NearestSlot tried_in_turn(const TriangleMesh& mesh, const Vec3& p) {
  NearestSlot best;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Vec3 c[3] = {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
    std::sort(c, c + 3, [](const Vec3& a, const Vec3& b) {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    });
    double sq = std::min({sq_to_segment(p, c[0], c[1]), sq_to_segment(p, c[0], c[2]), sq_to_segment(p, c[1], c[2])});
    const Vec3 ab = c[1] - c[0], ac = c[2] - c[0], pa = p - c[0], n = cross(ab, ac);
    const double of_c = dot(n, cross(ab, pa)), of_b = dot(n, cross(pa, ac)), nn = dot(n, n), height = dot(n, pa);
    if (of_c > 0 && of_b > 0 && of_b + of_c < nn) sq = height * height / nn;
    if (sq < best.sq_distance) best.sq_distance = sq, best.triangle = t;
  }
  return best;
}

struct Trial {
  std::string name;
  TriangleMesh mesh;
  std::vector<Vec3> queries;
};

/// Soups and surfaces at every scale and place, and queries where a bound could fail.
std::vector<Trial> trials() {
  std::vector<Trial> all;
  Random random(11);
  auto anywhere = [&](double reach) {
    return Vec3(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
  };
  auto soup = [&](std::size_t count, double reach, double edge, double thin) {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vec3 a = anywhere(reach), b = a + anywhere(edge),
                 c = a + random.uniform() * (b - a) + thin * anywhere(edge);
      mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
  };
  auto waves = [&](int rows, double size) {
    TriangleMesh mesh;
    for (int i = 0; i <= rows; ++i)
      for (int j = 0; j <= rows; ++j)
        mesh.vertices.push_back(size / rows * Vec3(i, j, 2 * std::sin(0.7 * i) * std::cos(0.4 * j)));
    auto id = [&](int i, int j) { return static_cast<std::uint32_t>(i * (rows + 1) + j); };
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < rows; ++j) {
        mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
        mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
      }
    return mesh;
  };
  auto moved = [](TriangleMesh mesh, const Vec3& by) {
    for (auto& v : mesh.vertices) v += by;
    return mesh;
  };
  auto scaled = [](TriangleMesh mesh, double by) {
    for (auto& v : mesh.vertices) v *= by;
    return mesh;
  };
  all.push_back({"a surface", waves(24, 10), {}});
  all.push_back({"a soup without shared vertices", soup(900, 5, 2, 1), {}});
  all.push_back({"slivers", soup(900, 5, 2, 1e-9), {}});
  all.push_back({"triangles without area", soup(500, 5, 2, 0), {}});
  all.push_back({"small triangles far apart", soup(500, 1e3, 1e-4, 1), {}});
  all.push_back({"far from the origin", moved(waves(20, 10), {1e6, -3e6, 2e5}), {}});
  all.push_back({"a thousandth, a thousand metres away", moved(soup(600, 1e-2, 1e-3, 1), {1e6, 1e6, -1e6}), {}});
  all.push_back({"both at the origin and far from it", waves(16, 1e-3), {}});
  {
    auto& mesh = all.back().mesh;
    const auto other = moved(waves(16, 1), {1e7, 0, 0});
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  all.push_back({"smaller than a float can be", scaled(waves(16, 1), 1e-42), {}});
  all.push_back({"squares that are hardly floats", scaled(waves(16, 1), 1e-21), {}});
  all.push_back({"squares that vanish", scaled(waves(12, 1), 1e-170), {}});
  all.push_back({"larger than the square of a float can be", scaled(waves(16, 1), 1e25), {}});
  // Each triangle four times: ties everywhere.
  all.push_back({"copies", waves(10, 10), {}});
  {
    auto& triangles = all.back().mesh.triangles;
    const auto once = triangles;
    for (int copy = 0; copy < 3; ++copy) triangles.insert(triangles.end(), once.rbegin(), once.rend());
  }
  // Unwelded: vertices of the same place, some of them the other zero.
  all.push_back({"unwelded", {}, {}});
  {
    const auto welded = waves(12, 10);
    auto& mesh = all.back().mesh;
    for (std::uint32_t t = 0; t < welded.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        Vec3 v = welded.corner(t, k);
        for (int j = 0; j < 3; ++j)
          if (v[j] == 0 && t % 2) v[j] = -0.0;
        mesh.vertices.push_back(v);
      }
      mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
  }
  for (auto& trial : all) {
    const Box3 box = trial.mesh.bounds();
    const double size = box.diagonal();
    const auto triangles = trial.mesh.triangles.size();
    for (int i = 0; i < 150; ++i) {
      const auto t = random.below(triangles);
      const Vec3 a = trial.mesh.corner(t, 0), b = trial.mesh.corner(t, 1), c = trial.mesh.corner(t, 2);
      const double u = random.uniform(), v = random.uniform() * (1 - u);
      trial.queries.push_back(a);                              // on a corner
      trial.queries.push_back(0.5 * (a + b));                  // on an edge
      trial.queries.push_back(a + u * (b - a) + v * (c - a));  // inside
      trial.queries.push_back(a + u * (b - a) + anywhere(1e-3 * size));
      trial.queries.push_back(box.center() + anywhere(size));
    }
    for (int i = 0; i < 20; ++i) {
      trial.queries.push_back(box.center() + anywhere(1e3 * size));
      trial.queries.push_back(box.center() + anywhere(1e6));  // a thousand metres away
      trial.queries.push_back(box.center() + anywhere(1e12 * size));
    }
  }
  return all;
}

}  // namespace

TEST_CASE(
    "triangle tree: every search gives the answer of all triangles in turn, to the bit, on every instruction set") {
  for (const auto& trial : trials()) {
    INFO(trial.name);
    // The second in another form: by threads, and with leaves that suit other instructions.
    const TriangleTree tree = build_triangle_tree(trial.mesh, 1, Instructions::avx512),
                       by_three = build_triangle_tree(trial.mesh, 3, Instructions::avx2);
    std::vector<NearestSlot> truth;
    for (const auto& q : trial.queries) truth.push_back(tried_in_turn(trial.mesh, q));
    std::vector<Vec3> points(truth.size());
    for (const auto instructions : {Instructions::baseline, Instructions::avx2, Instructions::avx512}) {
      if (instructions > widest_instructions()) continue;
      std::vector<NearestSlot> found(truth.size()), shuffled(truth.size());
      search_nearest(tree, trial.queries, found.data(), instructions);
      // In another order and another tree.
      std::vector<std::size_t> order(truth.size());
      Random random(12);
      for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
      std::vector<Vec3> mixed;
      for (const auto i : order) mixed.push_back(trial.queries[i]);
      search_nearest(by_three, mixed, shuffled.data(), instructions);
      std::vector<Vec3> feet(truth.size());
      nearest_points(tree, trial.queries, found.data(), feet.data(), instructions);
      if (instructions == Instructions::baseline) points = feet;
      std::size_t wrong = 0, wrong_in_turn = 0, wrong_shuffled = 0, wrong_points = 0;
      auto same = [](const NearestSlot& a, const NearestSlot& b) {
        return a.sq_distance == b.sq_distance && a.triangle == b.triangle;
      };
      for (std::size_t i = 0; i < truth.size(); ++i) {
        NearestSlot one;
        search_nearest(tree, trial.queries[i], one, instructions);
        wrong += !same(found[i], truth[i]), wrong_in_turn += !same(one, truth[i]);
        wrong_shuffled += !same(shuffled[i], truth[order[i]]), wrong_points += feet[i] != points[i];
      }
      INFO("instructions " << static_cast<int>(instructions));
      CHECK(wrong == 0);
      CHECK(wrong_in_turn == 0);
      CHECK(wrong_shuffled == 0);
      CHECK(wrong_points == 0);
    }
  }
}

TEST_CASE("triangle tree: all triangles within a distance are found and no other") {
  for (const auto& trial : trials()) {
    INFO(trial.name);
    const TriangleTree tree = build_triangle_tree(trial.mesh, 1);
    for (std::size_t i = 0; i < trial.queries.size(); i += 31) {
      // As far as the nearest one, which must be among them.
      const NearestSlot nearest = tried_in_turn(trial.mesh, trial.queries[i]);
      std::vector<NearSlot> found;
      triangles_within(tree, trial.queries[i], std::sqrt(nearest.sq_distance) * (1 + 1e-12), found);
      CHECK((nearest.sq_distance < 1e-300 || std::any_of(found.begin(), found.end(), [&](const NearSlot& f) {
               return f.triangle == nearest.triangle;
             })));
      for (const auto& f : found) CHECK(f.sq_distance >= nearest.sq_distance);
    }
  }
}

TEST_CASE("triangle tree: a leaf keeps each vertex once") {
  const auto bytes_of = [](const TriangleMesh& mesh, Instructions instructions) {
    return static_cast<double>(build_triangle_tree(mesh, 1, instructions).bytes()) /
           static_cast<double>(mesh.triangles.size());
  };
  for (const auto& trial : trials()) {
    if (trial.name != "a surface" && trial.name != "unwelded") continue;
    CHECK(bytes_of(trial.mesh, Instructions::avx512) < 70);
    CHECK(bytes_of(trial.mesh, Instructions::avx2) < 100);  // half as many triangles share a head
  }
}

TEST_CASE("triangle tree: where squares overflow nothing is nearest, beside queries that have an answer") {
  const TriangleMesh mesh = trials().front().mesh;
  const TriangleTree tree = build_triangle_tree(mesh, 1);
  for (const auto instructions : {Instructions::baseline, Instructions::avx2, Instructions::avx512}) {
    if (instructions > widest_instructions()) continue;
    const std::vector<Vec3> far(40, Vec3(1e200, 1e200, -1e200));
    std::vector<NearestSlot> found(41);
    search_nearest(tree, far, found.data(), instructions);
    for (int i = 0; i < 40; ++i) CHECK(found[static_cast<std::size_t>(i)].triangle == no_triangle);
    std::vector<Vec3> mixed = far;
    mixed.emplace_back(1, 2, 3);
    search_nearest(tree, mixed, found.data(), instructions);
    CHECK(found[0].triangle == no_triangle);
    CHECK(found[40].sq_distance == tried_in_turn(mesh, {1, 2, 3}).sq_distance);
  }
}
