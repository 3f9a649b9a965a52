/// Attacks on the verdict: damage too small, too hidden or too much like an outlier, and true parts that look damaged.
#include <catch2/catch.hpp>

#include "scan/simulate/simulate.h"
#include "testing/meshes.h"

using namespace partscribe::scan;
using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.1;
constexpr double sigma = 0.02;

VerifyOptions at(double tolerance) {
  VerifyOptions options;
  options.tolerance = tolerance;
  return options;
}

TriangleMesh plate() { return box({-30, -30, 0}, {30, 30, 5}); }

/// 20,000 points of the plate, 0.65 mm apart.
Scan plate_scan(std::uint64_t seed = 1) { return scanned(plate(), 20000, sigma, seed); }

/// A share of the points become outliers: anywhere within 10 mm.
void add_outliers(Scan& scan, double share, std::uint64_t seed) {
  Random random(seed);
  for (auto& p : scan.cloud.points)
    if (random.uniform() < share)
      p += random.uniform(-10, 10) * Vec3(random.normal(), random.normal(), random.normal()).normalized();
}

/// A pin of that radius stands at (x, y): it hides the plate below it and shows `count` points of its own.
void add_pin(Scan& scan, double x, double y, double radius, double height, int count, std::uint64_t seed) {
  std::erase_if(scan.cloud.points,
                [&](const Vec3& p) { return p.z() > 2.5 && std::hypot(p.x() - x, p.y() - y) < radius; });
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    const double a = random.uniform(0, 2 * pi);
    const bool top = i % 2 == 0;  // half on its top, half on its side
    const double r = top ? radius * std::sqrt(random.uniform()) : radius;
    const double z = top ? height : random.uniform(0.3 * height, height);
    scan.cloud.points.push_back({x + r * std::cos(a), y + r * std::sin(a), 5 + z + sigma * random.normal()});
  }
}

}  // namespace

TEST_CASE("attack: a pin of six points does not hide among outliers") {
  struct Case {
    double outliers;
    int points;
  };
  for (const Case c : {Case{0, 6}, {0.002, 6}, {0.002, 12}, {0.01, 9}})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      auto scan = plate_scan(seed);
      add_outliers(scan, c.outliers, seed + 10);
      add_pin(scan, 7.3, -11.2, 0.85, 1.0, c.points, seed + 20);
      const auto verdict = verdict_on(plate(), scan, at(T));
      INFO(c.points << " points among " << c.outliers << " outliers, seed " << seed);
      CHECK(verdict.verdict == Outcome::out_of_tolerance);
    }
}

TEST_CASE("attack: outliers alone, up to the expected rate, refuse no true part") {
  for (const double share : {0.002, 0.01, 0.018})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      auto scan = plate_scan(seed);
      add_outliers(scan, share, seed + 30);
      const auto verdict = verdict_on(plate(), scan, at(T));
      INFO(share << " outliers, seed " << seed << "\n" << all_reasons(verdict));
      CHECK(verdict.verdict == Outcome::verified);
    }
  auto scan = plate_scan();
  add_outliers(scan, 0.05, 3);
  CHECK(verdict_on(plate(), scan, at(T)).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("attack: mixed pixels, bit errors and outliers of a real scanner refuse no true part") {
  const auto truth =
      joined(holed_plate(20, 8, 4, 5, -3), moved(turned({{0, 0}, {3, 0}, {3, 9}, {0, 9}}, 60), {-10, 8, 8.5}));
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    SimulateOptions options;
    options.resolution = 128;
    options.sigma = sigma;
    options.mixed = 0.3;
    options.bit_error = 0.001;
    options.outliers = seed % 2 ? 0 : 0.005;
    options.views = seed == 2 ? "cube" : "octahedron";
    options.seed = seed;
    Context context;
    auto scan = simulate(surface_of(truth), options, context).merged;
    for (const bool with_rays : {true, false}) {
      if (!with_rays) scan.cloud.rays.clear(), scan.cloud.view.clear(), scan.views.assign(1, {});
      const auto verdict = verdict_on(truth, scan, at(T));
      INFO("seed " << seed << (with_rays ? " with rays\n" : "\n") << all_reasons(verdict));
      CHECK(verdict.verdict == Outcome::verified);
    }
  }
}

TEST_CASE("attack: a thin wall that the model lacks is missed") {
  for (const int count : {40, 140}) {  // of 140 that the rest of the scan would have
    auto scan = plate_scan();
    std::erase_if(scan.cloud.points,
                  [](const Vec3& p) { return p.z() > 2.5 && std::abs(p.x() - 10) < 0.5 && std::abs(p.y()) < 5; });
    Random random(4);
    for (int i = 0; i < count; ++i)
      scan.cloud.points.push_back(
          {10 + (i % 2 ? 0.5 : -0.5) + sigma * random.normal(), random.uniform(-5, 5), random.uniform(5.2, 8)});
    INFO(count);
    CHECK(verdict_on(plate(), scan, at(T)).verdict == Outcome::out_of_tolerance);
  }
}

TEST_CASE("attack: a lid on a hole of a few pixels is refused, because points behind it were seen") {
  const double thick = 8, radius = 3, lid = 1.5;
  const auto truth = holed_plate(25, thick, radius, 5, -3);
  // The wall ends below the lid, which closes the hole at its top.
  TriangleMesh closed = truth;
  const auto n = static_cast<std::uint32_t>(truth.vertices.size() / 4);
  for (std::uint32_t j = n; j-- > 0;)
    closed.triangles.erase(closed.triangles.begin() + 8 * j + 6, closed.triangles.begin() + 8 * j + 8);
  const auto below = static_cast<std::uint32_t>(closed.vertices.size()), bottom = below + n, top = bottom + 1;
  for (std::uint32_t j = 0; j < n; ++j) closed.vertices.push_back(truth.vertices[2 * n + j] - lid * Vec3::UnitZ());
  closed.vertices.emplace_back(5, -3, thick - lid), closed.vertices.emplace_back(5, -3, thick);
  for (std::uint32_t j = 0; j < n; ++j) {
    const auto k = (j + 1) % n;
    closed.triangles.push_back({k, j, below + j}), closed.triangles.push_back({k, below + j, below + k});
    closed.triangles.push_back({below + k, below + j, bottom}), closed.triangles.push_back({2 * n + j, 2 * n + k, top});
  }
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Scan scan;
    for (int v = 0; v < 12; ++v) {
      const double a = pi * v / 6, up = v % 2 ? -1 : 1;
      add_view(scan, truth, Vec3(std::cos(a), std::sin(a), up).normalized(), 1.5, sigma, 20 * seed + std::uint64_t(v));
    }
    INFO("seed " << seed);
    const auto right = verdict_on(truth, scan, at(T)), wrong = verdict_on(closed, scan, at(T));
    INFO(all_reasons(right) << all_reasons(wrong));
    CHECK(right.verdict == Outcome::verified);
    CHECK(wrong.verdict == Outcome::out_of_tolerance);
    CHECK(all_reasons(wrong).find("seen through") != std::string::npos);
  }
}

TEST_CASE("attack: a wall whose back nobody saw hides nothing of the slot before it") {
  // A round slot beside a chamber that is closed: below the chamber's wall lies the far side of the slot, which was
  // seen from above.
  const auto block = turned({{0, 0}, {15, 0}, {15, 20}, {10.8, 20}, {10.8, 17}, {10, 17}, {10, 20}, {0, 20}}, 128);
  auto chamber = turned({{0, 16}, {8.5, 16}, {8.5, 19}, {0, 19}}, 128);
  for (auto& t : chamber.triangles) std::swap(t[1], t[2]);
  const auto truth = joined(block, chamber);
  Scan scan;
  for (int v = 0; v < 12; ++v) {
    const double a = pi * v / 6, tilt = v % 2 ? 0.3 : 0.5;
    add_view(scan, truth, Vec3(std::sin(tilt) * std::cos(a), std::sin(tilt) * std::sin(a), -std::cos(tilt)), 0.25,
             sigma, 40 + std::uint64_t(v));
  }
  const auto verdict = verdict_on(truth, scan, at(T));
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  CHECK(verdict.artifacts[0].model_to_data.contradicted == 0);
}

TEST_CASE("attack: a thin sheet inside the material is refused at any depth from half a tolerance on") {
  const auto scan = plate_scan();
  for (const double depth : {0.5 * T, T, 2 * T, 5 * T}) {
    INFO(depth);
    const auto verdict =
        verdict_on(joined(plate(), box({-10, -10, 5 - depth - 0.05}, {10, 10, 5 - depth})), scan, at(T));
    CHECK(verdict.verdict == Outcome::out_of_tolerance);
    CHECK(all_reasons(verdict).find("overlap") != std::string::npos);
  }
}

TEST_CASE("attack: a crack below the surface is at least not called scanned") {
  auto crack = box({-20, -20, 5 - 3 * T}, {20, 20, 5 - 2 * T});
  for (auto& t : crack.triangles) std::swap(t[1], t[2]);
  const auto verdict = verdict_on(joined(plate(), crack), plate_scan(), at(T));
  CHECK(verdict.artifacts[0].model_to_data.not_scanned > 3000);  // both its walls
}

TEST_CASE("attack: a second body inside the part, shifted, is refused") {
  const auto truth = sphere(20, 90);
  const auto scan = scanned(sphere(20, 200), 60000, sigma);
  CHECK(verdict_on(joined(truth, scaled(truth, 0.5)), scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_on(joined(truth, moved(truth, {0.05, 0.02, 0})), scan, at(T)).verdict == Outcome::out_of_tolerance);
  // Bodies that only touch are a matter of taste.
  const auto two = joined(plate(), box({-5, -5, 5}, {5, 5, 8}));
  auto seen = scanned(two, 60000, sigma);
  std::erase_if(seen.cloud.points, [](const Vec3& p) {
    return std::abs(p.x()) < 4.9 && std::abs(p.y()) < 4.9 && std::abs(p.z() - 5) < 0.2;
  });
  const auto verdict = verdict_on(two, seen, at(T));
  CHECK(all_reasons(verdict).find("overlap") == std::string::npos);
}

TEST_CASE("attack: a sheet outside, where nobody looked, is refused as a body without data") {
  auto scan = plate_scan();
  std::erase_if(scan.cloud.points, [](const Vec3& p) { return p.z() < 2; });
  REQUIRE(verdict_on(plate(), scan, at(T)).verdict == Outcome::verified);
  const auto verdict = verdict_on(joined(plate(), box({-30, -30, -0.5}, {30, 30, -0.3})), scan, at(T));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
}

TEST_CASE("attack: a blind hole too deep is refused by the few points of its real bottom") {
  // A block with a bore of radius 2 down to z = `bottom`.
  auto block = [](double bottom) {
    return turned({{0, 0}, {12, 0}, {12, 20}, {2, 20}, {2, bottom}, {0, bottom}}, 128);
  };
  for (const int count : {8, 12, 20}) {
    auto scan = scanned(block(10), 20000, sigma);
    std::erase_if(scan.cloud.points,
                  [](const Vec3& p) { return std::hypot(p.x(), p.y()) < 2.5 && p.z() < 18 && p.z() > 1; });
    Random random(7);
    for (int i = 0; i < count; ++i) {
      const double a = random.uniform(0, 2 * pi), r = 0.9 * std::sqrt(random.uniform());
      scan.cloud.points.push_back({r * std::cos(a), r * std::sin(a), 10 + sigma * random.normal()});
    }
    INFO(count);
    CHECK(verdict_on(block(10), scan, at(T)).verdict == Outcome::verified);
    CHECK(verdict_on(block(5), scan, at(T)).verdict == Outcome::out_of_tolerance);
  }
}

TEST_CASE("attack: holes in a dense mesh refuse no true part and hide no damage") {
  Scan scan;
  scan.mesh = sphere(20, 100);
  Random random(9);
  std::vector<Vec3> middles;
  for (int i = 0; i < 40; ++i)
    middles.push_back(20 * Vec3(random.normal(), random.normal(), random.normal()).normalized());
  std::size_t t = 0;
  std::erase_if(scan.mesh.triangles, [&](const auto& triangle) {
    const Vec3 at = scan.mesh.vertices[triangle[0]];
    ++t;
    return std::any_of(middles.begin(), middles.end(), [&](const Vec3& m) { return (m - at).norm() < 1.2; });
  });
  scan.mesh = welded(scan.mesh, 0);
  scan.cloud.points = scan.mesh.vertices;
  for (auto& p : scan.cloud.points) p += 0.01 * random.normal() * p.normalized();
  scan.mesh.vertices = scan.cloud.points;
  scan.views.push_back({});
  const auto truth = verdict_on(sphere(20, 120), scan, at(T));
  INFO(all_reasons(truth));
  CHECK(truth.verdict == Outcome::verified);
  CHECK(verdict_on(sphere(20 + 2 * T, 120), scan, at(T)).verdict == Outcome::out_of_tolerance);
  // A knob of a few vertices that the model lacks.
  Scan knobbed = scan;
  for (auto* list : {&knobbed.mesh.vertices, &knobbed.cloud.points})
    for (auto& p : *list)
      if ((p - Vec3(20, 0, 0)).norm() < 1.2) p *= 1.05;
  CHECK(verdict_on(sphere(20, 120), knobbed, at(T)).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("attack: a deviation of twice the tolerance is found on a face of a few points, or called undecided") {
  // A disc with a stud of 2 mm radius, 2 T too low in the model; the scan shows ever fewer points of its top.
  auto disc = [](double stud) { return turned({{0, 0}, {25, 0}, {25, 5}, {2, 5}, {2, 5 + stud}, {0, 5 + stud}}, 128); };
  for (const int count : {6, 10, 30}) {
    auto scan = scanned(disc(2), 20000, sigma);
    std::erase_if(scan.cloud.points, [](const Vec3& p) { return p.z() > 5.3 && std::hypot(p.x(), p.y()) < 2.5; });
    Random random(7);
    for (int i = 0; i < count; ++i) {
      const double a = random.uniform(0, 2 * pi), r = 2 * std::sqrt(random.uniform());
      scan.cloud.points.push_back({r * std::cos(a), r * std::sin(a), 7 + sigma * random.normal()});
    }
    INFO(count);
    CHECK(verdict_on(disc(2), scan, at(T)).verdict == Outcome::verified);
    CHECK(verdict_on(disc(2 - 2 * T), scan, at(T)).verdict == Outcome::out_of_tolerance);
  }
}

TEST_CASE("attack: views that lie farther apart than the tolerance cannot decide, and the reason gives the offset") {
  const auto truth = box({-15, -12, 0}, {15, 12, 9});
  SimulateOptions options;
  options.resolution = 96;
  options.sigma = sigma;
  options.views = "icosahedron";
  Context context;
  auto scan = simulate(surface_of(truth), options, context).merged;
  CHECK(verdict_on(truth, scan, at(T)).verdict == Outcome::verified);
  Random random(5);
  std::vector<Vec3> shift;
  for (std::size_t v = 0; v < scan.views.size(); ++v)
    shift.push_back(0.3 * Vec3(random.normal(), random.normal(), random.normal()));
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) scan.cloud.points[i] += shift[std::size_t(scan.cloud.view[i])];
  const auto verdict = verdict_on(truth, scan, at(T));
  INFO(verdict.smallest_honest_tolerance);
  CHECK(verdict.verdict == Outcome::cannot_decide);
  CHECK(all_reasons(verdict).find("views lie 0.") != std::string::npos);
}

TEST_CASE("attack: at the smallest honest tolerance a true part is not refused") {
  // Six scans here; bench/verdict runs hundreds.
  const auto truth = holed_plate(20, 8, 4, 5, -3);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto scan = scanned(truth, 8000, 0.05, seed);
    const double honest = verdict_on(truth, scan, at(1)).smallest_honest_tolerance;
    const auto verdict = verdict_on(truth, scan, at(1.0001 * honest));
    INFO("seed " << seed << ", T " << honest << "\n" << all_reasons(verdict));
    CHECK(verdict.verdict == Outcome::verified);
  }
}

TEST_CASE("attack: a hole that the model fills is missed where views look at it and see nothing") {
  // A plate on nothing: through the hole no ray returns.
  const auto holed = holed_plate(20, 4, 6, 3, -2);
  Context context;
  SimulateOptions options;
  options.resolution = 96;
  options.sigma = sigma;
  options.views = "icosahedron";
  auto scan = simulate(surface_of(holed), options, context).merged;
  const auto good = verdict_on(holed, scan, at(T));
  INFO(all_reasons(good));
  CHECK(good.verdict == Outcome::verified);
  // Only the rim was seen: nothing of the hole's wall.
  auto rim = scan;
  std::vector<char> drop(scan.cloud.size(), 0);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    drop[i] = std::hypot(scan.cloud.points[i].x() - 3, scan.cloud.points[i].y() + 2) < 6.3;
  PointCloud kept;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    if (!drop[i]) {
      kept.points.push_back(scan.cloud.points[i]), kept.rays.push_back(scan.cloud.rays[i]);
      kept.view.push_back(scan.cloud.view[i]);
    }
  rim.cloud = kept;
  const auto filled = verdict_on(box({-20, -20, 0}, {20, 20, 4}), rim, at(T));
  CHECK(filled.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(filled).find("contradict") != std::string::npos);
  // A place that the scanner lost (dark, shiny) is no such hole.
  auto dark = rim;
  dark.cloud = {};
  const auto whole = simulate(surface_of(box({-20, -20, 0}, {20, 20, 4})), options, context).merged;
  for (std::size_t i = 0; i < whole.cloud.size(); ++i)
    if ((whole.cloud.points[i] - Vec3(5, 5, 4)).norm() > 1.6) {
      dark.cloud.points.push_back(whole.cloud.points[i]), dark.cloud.rays.push_back(whole.cloud.rays[i]);
      dark.cloud.view.push_back(whole.cloud.view[i]);
    }
  dark.views = whole.views;
  CHECK(verdict_on(box({-20, -20, 0}, {20, 20, 4}), dark, at(T)).verdict == Outcome::verified);
}
