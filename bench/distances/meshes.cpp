// Exact distances from points to triangle meshes: ours beside Embree and CGAL, by processor time.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>

#include "core/number.h"
#include "core/random.h"
#include "core/statistics.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/spatial_order.h"
#include "measure.h"
#include "peers.h"

using namespace partscribe::geometry;

namespace bench {
namespace {

/// A closed body of revolution about z through (radius, height) pairs that start and end on the axis.
void add_turned(TriangleMesh& mesh, const std::vector<Vec2>& profile, int around, const Vec3& at) {
  std::vector<std::uint32_t> row;
  for (const auto& p : profile) {
    row.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    const int copies = p.x() == 0 ? 1 : around;
    for (int j = 0; j < copies; ++j) {
      const double a = 2 * pi * j / around;
      mesh.vertices.push_back(at + Vec3(p.x() * std::cos(a), p.x() * std::sin(a), p.y()));
    }
  }
  auto id = [&](std::size_t i, int j) {
    return profile[i].x() == 0 ? row[i] : row[i] + static_cast<std::uint32_t>(j % around);
  };
  for (std::size_t i = 0; i + 1 < profile.size(); ++i)
    for (int j = 0; j < around; ++j) {
      if (profile[i].x() > 0) mesh.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j)});
      if (profile[i + 1].x() > 0) mesh.triangles.push_back({id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)});
    }
}

/// Pins with rounded shoulders on a plate-like grid: long thin triangles beside small ones, as exporters write them.
TriangleMesh cad_mesh(std::size_t triangles) {
  TriangleMesh mesh;
  const int pins = 36;
  // A pin has rows of `around` quads: 2 rows of cylinder, 3 quarter rounds of `steps`.
  const double per_pin = static_cast<double>(triangles) / pins;
  const int steps = std::max(2, static_cast<int>(std::sqrt(per_pin / 24)));
  const int around = std::max(8, static_cast<int>(per_pin / (2.0 * (3 * steps + 4))));
  for (int i = 0; i < pins; ++i) {
    const Vec3 at(20.0 * (i % 6), 20.0 * (i / 6), 0.5 * (i % 5));
    const double r = 4 + 0.4 * (i % 7), h = 10 + 3.0 * (i % 4);
    std::vector<Vec2> profile{{0, 0}, {r + 3, 0}, {r + 3, 2}};
    auto round = [&](const Vec2& center, double radius, double from, double to) {
      for (int s = 0; s <= steps; ++s) {
        const double a = from + (to - from) * s / steps;
        profile.push_back(center + radius * Vec2(std::cos(a), std::sin(a)));
      }
    };
    round({r + 2, 2}, 1, 0, pi / 2);            // the edge of the flange
    round({r + 1, 4}, 1, -pi / 2, -pi);         // the fillet
    round({r - 1.5, h - 1.5}, 1.5, 0, pi / 2);  // the rounded top
    profile.push_back({0, h});
    add_turned(mesh, profile, around, at);
  }
  return mesh;
}

std::vector<Vec3> near_points(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  std::vector<double> sum(mesh.triangles.size());
  double total = 0;
  for (std::size_t t = 0; t < sum.size(); ++t) {
    total += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    sum[t] = total;
  }
  const double noise = 1e-3 * mesh.bounds().diagonal();
  Random random(seed);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = std::min(
        sum.size() - 1, std::size_t(std::lower_bound(sum.begin(), sum.end(), random.uniform(0, total)) - sum.begin()));
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 a = mesh.corner(t, 0);
    points.push_back(a + u * (mesh.corner(t, 1) - a) + v * (mesh.corner(t, 2) - a) +
                     noise * Vec3(random.normal(), random.normal(), random.normal()));
  }
  return points;
}

std::vector<Vec3> far_points(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  const Box3 box = mesh.bounds();
  const Vec3 size = box.size();
  Random random(seed);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = box.low[k] + size[k] * random.uniform(-1, 2);
    points.push_back(p);
  }
  return points;
}

/// Truth for one query, in long double.
double tried_in_turn(const TriangleMesh& mesh, const Vec3& query) {
  using V = Eigen::Matrix<long double, 3, 1>;
  const V p = query.cast<long double>();
  long double best = 1e300L;
  auto segment = [&](const V& s, const V& e) {
    const V d = e - s;
    const long double l = d.squaredNorm();
    const long double u = l > 0 ? std::clamp<long double>(d.dot(p - s) / l, 0, 1) : 0;
    return (p - s - u * d).squaredNorm();
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const V a = mesh.corner(t, 0).cast<long double>(), b = mesh.corner(t, 1).cast<long double>(),
            c = mesh.corner(t, 2).cast<long double>();
    best = std::min({best, segment(a, b), segment(b, c), segment(c, a)});
    const V n = (b - a).cross(c - a);
    if (n.squaredNorm() > 0 && n.dot((b - a).cross(p - a)) > 0 && n.dot((c - b).cross(p - b)) > 0 &&
        n.dot((a - c).cross(p - c)) > 0)
      best = std::min(best, n.dot(p - a) * n.dot(p - a) / n.squaredNorm());
  }
  return static_cast<double>(std::sqrt(best));
}

/// The same queries on several threads by equal shares.
void shared_out(std::size_t count, int threads, const std::function<void(std::size_t, std::size_t)>& work) {
  std::vector<std::thread> pool;
  for (int t = 1; t < threads; ++t)
    pool.emplace_back(work, count * std::size_t(t) / std::size_t(threads),
                      count * std::size_t(t + 1) / std::size_t(threads));
  work(0, count / std::size_t(threads));
  for (auto& thread : pool) thread.join();
}

void compare_on(const std::string& name, const TriangleMesh& mesh, std::size_t count, int repetitions, bool with_cgal) {
  std::printf("\n%s: %zu triangles, %zu queries; millions of queries per second of processor time (wall)\n",
              name.c_str(), mesh.triangles.size(), count);
  std::unique_ptr<MeshDistance> ours;
  std::unique_ptr<peers::Peer> embree, cgal;
  std::vector<double> our_build, embree_build;
  for (int i = 0; i < repetitions; ++i) {
    our_build.push_back(seconds_of([&] { ours = std::make_unique<MeshDistance>(mesh, 1); }).cpu);
    embree.reset();
    embree_build.push_back(seconds_of([&] { embree = peers::embree(mesh); }).cpu);
  }
  const double n = static_cast<double>(mesh.triangles.size());
  std::printf("  build s: ours %.3f", median(our_build));
  if (embree) std::printf(", Embree %.3f", median(embree_build));
  if (with_cgal) std::printf(", CGAL %.3f", seconds_of([&] { cgal = peers::cgal(mesh); }).cpu);
  std::printf("; bytes per triangle: ours %.0f", static_cast<double>(ours->tree_bytes()) / n);
  if (embree) std::printf(", Embree %.0f", static_cast<double>(embree->bytes()) / n);
  std::printf("\n");

  for (const bool near : {true, false}) {
    const auto queries = near ? near_points(mesh, count, 1) : far_points(mesh, count, 2);
    const auto order = spatial_order(queries, 1);
    std::vector<Vec3> sorted;
    for (const auto i : order) sorted.push_back(queries[i]);
    std::vector<double> answer(count), other(count);
    struct Row {
      std::string name;
      std::function<void()> run;
      double queries;
      std::vector<double> cpu, wall;
    };
    std::vector<Row> rows;
    const auto all = static_cast<double>(count);
    for (const int threads : {1, 2}) {
      const std::string suffix = threads == 1 ? "" : ", 2 threads";
      rows.push_back({"ours, batch" + suffix,
                      [&, threads] {
                        ours->for_each_closest(queries, threads, Sign::none,
                                               [&](std::size_t i, const MeshHit& hit) { answer[i] = hit.distance; });
                      },
                      all,
                      {},
                      {}});
      rows.push_back({"ours, batch, signed" + suffix,
                      [&, threads] {
                        ours->for_each_closest(queries, threads, Sign::inside_negative,
                                               [&](std::size_t i, const MeshHit& hit) { other[i] = hit.distance; });
                      },
                      all,
                      {},
                      {}});
      rows.push_back({"ours, batch, sorted (not counted)" + suffix,
                      [&, threads] {
                        ours->for_each_closest(sorted, threads, Sign::none,
                                               [&](std::size_t i, const MeshHit& hit) { other[i] = hit.distance; });
                      },
                      all,
                      {},
                      {}});
      if (embree)
        rows.push_back({"Embree, sorted (not counted), warm" + suffix,
                        [&, threads] {
                          shared_out(count, threads, [&](std::size_t b, std::size_t e) {
                            embree->distances(sorted, b, e, true, other.data());
                          });
                        },
                        all,
                        {},
                        {}});
    }
    if (embree) {
      rows.push_back({"Embree, sorted (not counted)",
                      [&] { embree->distances(sorted, 0, count, false, other.data()); },
                      all,
                      {},
                      {}});
      rows.push_back(
          {"Embree, one by one", [&] { embree->distances(queries, 0, count, false, other.data()); }, all, {}, {}});
    }
    rows.push_back({"ours, one by one",
                    [&] {
                      for (std::size_t i = 0; i < count; ++i) other[i] = ours->closest(queries[i]).distance;
                    },
                    all,
                    {},
                    {}});
    if (cgal) {
      const std::size_t some = std::min<std::size_t>(count, 5000);
      rows.push_back({"CGAL, sorted (not counted), warm",
                      [&, some] { cgal->distances(sorted, 0, some, true, other.data()); },
                      static_cast<double>(some),
                      {},
                      {}});
    }
    ours->signed_distance(queries[0]);  // signs are made once
    for (auto& row : rows) row.run();
    for (int i = 0; i < repetitions; ++i) {
      for (std::size_t r = 0; r < rows.size(); ++r) {
        auto& row = rows[i % 2 ? rows.size() - 1 - r : r];
        const auto time = seconds_of(row.run);
        row.cpu.push_back(time.cpu), row.wall.push_back(time.wall);
      }
    }
    double best_peer = 0;
    for (const auto& row : rows)
      if (row.name.find("Embree, sorted (not counted), warm") == 0 && row.name.find("2 threads") == std::string::npos)
        best_peer = row.queries / median(row.cpu);
    std::printf("  %s\n", near ? "near (0.1 % of the size off the surface)" : "far (uniform in three times the box)");
    for (const auto& row : rows) {
      const double rate = row.queries / median(row.cpu);
      std::printf("    %-46s %7.3f (%.3f)", row.name.c_str(), rate / 1e6, row.queries / median(row.wall) / 1e6);
      if (best_peer > 0) std::printf("   %5.2f x", rate / best_peer);
      std::printf("\n");
    }
    // Answers: beside the peer's everywhere, beside every triangle tried in turn on a sample.
    double apart = 0, wrong = 0;
    if (embree) {
      embree->distances(queries, 0, count, false, other.data());
      for (std::size_t i = 0; i < count; ++i) apart = std::max(apart, std::abs(other[i] - answer[i]));
    }
    const std::size_t sample = std::max<std::size_t>(20, 20000000 / mesh.triangles.size() / 10);
    for (std::size_t i = 0; i < std::min(sample, count); ++i)
      wrong = std::max(wrong, std::abs(tried_in_turn(mesh, queries[i]) - answer[i]));
    std::printf("    largest difference from Embree %.2g mm, from all triangles tried in turn %.2g mm\n", apart, wrong);
    std::fflush(stdout);
  }
}

}  // namespace

void meshes(const std::vector<std::pair<std::string, TriangleMesh>>& given, int repetitions, std::size_t largest) {
  for (const std::size_t size : {10000u, 100000u, 1000000u}) {
    if (size > largest) continue;
    const auto mesh = cad_mesh(size);
    for (const std::size_t count : {100000u, 1000000u})
      compare_on("pins with rounds", mesh, count, count > 100000 ? std::max(1, repetitions / 2) : repetitions,
                 count == 100000);
  }
  for (const auto& [name, mesh] : given) compare_on(name, mesh, 100000, repetitions, true);
}

}  // namespace bench
