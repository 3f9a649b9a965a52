/// Claims about the verdict: what must be refused, what must pass, what cannot be decided.
#include <catch2/catch.hpp>
#include <chrono>

#include "geometry/mesh/mesh_distance.h"
#include "testing/meshes.h"
#include "verify/compare/source.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.1;
constexpr double sigma = 0.03;

VerifyOptions at(double tolerance) {
  VerifyOptions options;
  options.tolerance = tolerance;
  return options;
}

/// A pin with a collar that sits off the middle: no symmetry along its axis.
TriangleMesh pin(double shank = 5, double collar = 8, double lift = 12) {
  return turned(
      {{0, 0}, {shank, 0}, {shank, lift}, {collar, lift}, {collar, lift + 4}, {shank, lift + 4}, {shank, 30}, {0, 30}},
      200);
}

}  // namespace

TEST_CASE("verdict: a true model of a noisy scan is verified") {
  const auto mesh = sphere(20, 120);
  const auto verdict = verdict_on(mesh, scanned(sphere(20, 200), 60000, sigma), at(T));
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  CHECK(verdict.noise == Approx(sigma).epsilon(0.15));
  CHECK(verdict.smallest_honest_tolerance < T);
  REQUIRE(verdict.artifacts.size() == 1);
  const auto& a = verdict.artifacts[0];
  CHECK(a.data_to_model.local_max < 0.7 * T);
  CHECK(a.data_to_model.max > sigma * 3);
  CHECK(a.data_to_model.rms == Approx(sigma).epsilon(0.1));
  CHECK(a.model_to_data.supported > 0.999 * a.model_to_data.area);
  CHECK(a.point_deviation.size() == 60000);
}

TEST_CASE("verdict: far from the origin the scan has the noise that it has near it") {
  for (const double far : {0.0, 5e4, 5e6}) {
    const Vec3 shift(0.13 * far, far, 0.01 * far);
    const auto scan = scanned(moved(holed_plate(20, 6, 5, 0, 0), shift), 20000, 0.02);
    Context context;
    CHECK(prepare_source(scan, context).noise == Approx(0.02).epsilon(0.1));
    // An exact surface has none.
    CHECK(prepare_source(scanned(moved(holed_plate(20, 6, 5, 0, 0), shift), 20000, 0), context).noise == 0);
  }
}

TEST_CASE("verdict: a radius off by twice the tolerance is refused, by a tenth of it is not") {
  const auto scan = scanned(sphere(20, 200), 60000, sigma);
  for (const double sign : {-1.0, 1.0}) {
    CHECK(verdict_on(sphere(20 + sign * 2 * T, 120), scan, at(T)).verdict == Outcome::out_of_tolerance);
    CHECK(verdict_on(sphere(20 + sign * 0.1 * T, 120), scan, at(T)).verdict == Outcome::verified);
  }
}

TEST_CASE("verdict: the wrong size, hand or place is refused") {
  const auto part = joined(pin(), moved(box({-1, 6, 13}, {1, 11, 15}), {0, 3, 0}));  // an ear marks one side
  auto marked = part;
  const auto scan = scanned(joined(pin(), moved(box({-1, 6, 13}, {1, 11, 15}), {4, 3, 0})), 60000, sigma);
  const auto truth = joined(pin(), moved(box({-1, 6, 13}, {1, 11, 15}), {4, 3, 0}));
  CHECK(verdict_on(truth, scan, at(T)).verdict == Outcome::verified);
  CHECK(verdict_on(mirrored(truth), scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_on(scaled(truth, 1.02), scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_on(scaled(truth, 25.4), scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_on(moved(truth, {0, 0, 2 * T}), scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_on(moved(truth, {0, 0.1 * T, 0}), scan, at(T)).verdict == Outcome::verified);
  CHECK(verdict_on(part, scan, at(T)).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("verdict: half a percent of scale is refused") {
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  const auto scan = scanned(truth, 60000, sigma);
  CHECK(verdict_on(truth, scan, at(T)).verdict == Outcome::verified);
  CHECK(verdict_on(scaled(truth, 1.005), scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_on(scaled(truth, 0.995), scan, at(T)).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("verdict: a hole moved by twice the tolerance is refused in its own row") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 60000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10, 6, 5 + 2 * T, -8), scan, at(T));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  int bad = 0;
  for (const auto& row : verdict.artifacts[0].objects)
    if (row.verdict == Outcome::out_of_tolerance) {
      ++bad;
      CHECK(row.max == Approx(2 * T).margin(0.6 * T));
      CHECK(row.points < 10000);  // the hole's wall, not the plate
    }
  CHECK(bad == 1);
  CHECK(verdict_on(holed_plate(40, 10, 6, 5 + 0.1 * T, -8), scan, at(T)).verdict == Outcome::verified);
}

TEST_CASE("verdict: a missing feature is refused, also a small one") {
  const auto plate = box({-30, -30, 0}, {30, 30, 5});
  const auto with_pin = joined(plate, box({3, 3, 5}, {6, 6, 6}));
  // Points of the plate under the pin are not seen; the pin has few points of its own.
  auto scan = scanned(plate, 60000, sigma);
  std::erase_if(scan.cloud.points,
                [](const Vec3& p) { return p.z() > 4 && p.x() > 3 && p.x() < 6 && p.y() > 3 && p.y() < 6; });
  for (const auto& p : scanned(moved(box({3, 3, 5}, {6, 6, 6}), {0, 0, 0}), 160, sigma).cloud.points)
    if (p.z() > 5.1) scan.cloud.points.push_back(p);
  CHECK(verdict_on(plate, scan, at(T)).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("verdict: surface that nobody scanned is a third state, with strict a fault") {
  const auto truth = sphere(20, 120);
  auto scan = scanned(sphere(20, 200), 60000, sigma);
  std::erase_if(scan.cloud.points, [](const Vec3& p) { return p.z() < 0; });
  const auto verdict = verdict_on(truth, scan, at(T));
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  const auto& m = verdict.artifacts[0].model_to_data;
  CHECK(m.not_scanned == Approx(0.5 * m.area).epsilon(0.08));  // data reach three spacings beyond their border
  CHECK(m.contradicted == 0);
  auto strict = at(T);
  strict.strict = true;
  CHECK(verdict_on(truth, scan, strict).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_table(verdict).find("was not scanned") != std::string::npos);
}

TEST_CASE("verdict: an extra sheet over scanned surface is refused without any ray") {
  const auto plate = box({-30, -30, 0}, {30, 30, 5});
  const auto scan = scanned(plate, 60000, sigma);
  CHECK(verdict_on(plate, scan, at(T)).verdict == Outcome::verified);
  const auto verdict = verdict_on(joined(plate, box({-5, -5, 6}, {5, 5, 6.2})), scan, at(T));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(verdict).find("contradict") != std::string::npos);
}

TEST_CASE("verdict: a view that looked through invented material contradicts it") {
  const auto truth = pin();
  Scan scan;
  const Vec3 directions[] = {{1, 0, 0},
                             {-1, 0, 0},
                             {0, 1, 0},
                             {0, -1, 0},
                             {0, 0, 1},
                             {0, 0, -1},
                             Vec3(1, 1, 1).normalized(),
                             Vec3(-1, 1, -1).normalized(),
                             Vec3(1, -1, -1).normalized()};
  std::uint64_t seed = 1;
  for (const auto& d : directions) add_view(scan, truth, d, 0.25, sigma, seed++);
  const auto good = verdict_on(truth, scan, at(T));
  INFO(all_reasons(good));
  CHECK(good.verdict == Outcome::verified);
  CHECK(good.artifacts[0].model_to_data.contradicted < 0.001 * good.artifacts[0].model_to_data.area);
  // A block beside the shank: not on scanned surface, but between the sensor and the collar.
  const auto verdict = verdict_on(joined(truth, box({6, -1, 5}, {7.5, 1, 7})), scan, at(T));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(verdict).find("contradict") != std::string::npos);
}

TEST_CASE("verdict: a separate body without any data is refused") {
  const auto truth = pin();
  const auto scan = scanned(truth, 30000, sigma);
  const auto verdict = verdict_on(joined(truth, box({50, 50, 50}, {55, 55, 50.1})), scan, at(T));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(verdict).find("separate body") != std::string::npos);
}

TEST_CASE("verdict: scattered outliers do not refuse a true model, a cluster of them does") {
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  auto scan = scanned(truth, 60000, sigma);
  Random random(5);
  for (int i = 0; i < 600; ++i)
    scan.cloud.points[random.below(60000)] +=
        random.uniform(-20, 20) * Vec3(random.normal(), random.normal(), random.normal());
  const auto verdict = verdict_on(truth, scan, at(T));
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  CHECK(verdict.artifacts[0].data_to_model.rejected > 400);
  CHECK(verdict.artifacts[0].data_to_model.local_max < T);
  // The same number of points, but all of them raised together.
  auto raised = scanned(truth, 60000, sigma);
  for (auto& p : raised.cloud.points)
    if (p.z() > 5 && std::abs(p.x() + 20) < 3 && std::abs(p.y() - 20) < 3) p.z() += 1;
  CHECK(verdict_on(truth, raised, at(T)).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("verdict: what a filter rejected is not forgotten") {
  const auto plate = box({-30, -30, 0}, {30, 30, 5});
  auto scan = scanned(joined(plate, box({3, 3, 5}, {9, 9, 7})), 60000, sigma);
  std::erase_if(scan.cloud.points, [](const Vec3& p) {
    return std::abs(p.z() - 5) < 0.2 && p.x() > 3.1 && p.x() < 8.9 && p.y() > 3.1 && p.y() < 8.9;
  });
  for (const auto& p : scan.cloud.points) scan.cloud.rejected.push_back(p.z() > 5.3);  // a filter swallows the boss
  const auto verdict = verdict_on(plate, scan, at(T));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(verdict).find("of them set aside by a filter or by the fit) stand together") != std::string::npos);
}

TEST_CASE("verdict: below the noise the scan cannot decide") {
  const auto truth = sphere(20, 120);
  const auto scan = scanned(sphere(20, 200), 60000, 0.1);
  const auto verdict = verdict_on(truth, scan, at(0.02));
  CHECK(verdict.verdict == Outcome::cannot_decide);
  CHECK(verdict.smallest_honest_tolerance > 0.02);
  CHECK(all_reasons(verdict).find("smallest honest tolerance") != std::string::npos);
  CHECK(exit_code_of(verdict.verdict) == 6);
  CHECK(verdict_on(truth, scan, at(1.5 * verdict.smallest_honest_tolerance)).verdict == Outcome::verified);
}

TEST_CASE("verdict: a scan that shows next to nothing of the artifact cannot decide") {
  Scan dot = scanned(box({0, 0, 0}, {0.01, 0.01, 0.01}), 2000, 0);
  auto aligned = at(T);
  aligned.align = AlignBy::best_fit;
  const auto verdict = verdict_on(pin(), dot, aligned);
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::cannot_decide);
  CHECK(all_reasons(verdict).find("less than a hundredth") != std::string::npos);
}

TEST_CASE("verdict: an open, torn or inside-out artifact is refused") {
  const auto truth = sphere(20, 60);
  const auto scan = scanned(truth, 30000, sigma);
  REQUIRE(verdict_on(truth, scan, at(T)).verdict == Outcome::verified);
  auto open = truth;
  open.triangles.pop_back();
  CHECK(verdict_on(open, scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(verdict_on(open, scan, at(T))).find("open") != std::string::npos);
  auto torn = truth;
  for (std::size_t t = 0; t < 50; ++t) std::swap(torn.triangles[t][1], torn.triangles[t][2]);
  CHECK(verdict_on(torn, scan, at(T)).verdict == Outcome::out_of_tolerance);
  auto inside_out = truth;
  for (auto& t : inside_out.triangles) std::swap(t[1], t[2]);
  CHECK(verdict_on(inside_out, scan, at(T)).verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(verdict_on(inside_out, scan, at(T))).find("inside out") != std::string::npos);
}

TEST_CASE("verdict: an exact mesh as the scan decides any tolerance, also against invented surface") {
  Scan scan;
  scan.mesh = holed_plate(40, 10, 6, 5, -8);
  scan.cloud.points = scan.mesh.vertices;
  scan.views.push_back({});
  CHECK(verdict_on(scan.mesh, scan, at(0.001)).verdict == Outcome::verified);
  CHECK(verdict_on(scan.mesh, scan, at(0.001)).smallest_honest_tolerance == 0);
  CHECK(verdict_on(holed_plate(40, 10, 6.2, 5, -8), scan, at(T)).verdict == Outcome::out_of_tolerance);
  const auto verdict = verdict_on(joined(scan.mesh, box({100, 100, 100}, {110, 110, 110})), scan, at(T));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(verdict).find("contradict") != std::string::npos);
  auto raw = at(T);
  raw.rule = Rule::max;
  CHECK(verdict_on(scan.mesh, scan, raw).verdict == Outcome::verified);
}

TEST_CASE("verdict: the raw maximum refuses what the local mean forgives") {
  const auto truth = sphere(20, 120);
  auto scan = scanned(sphere(20, 200), 20000, 0.005);
  scan.cloud.points[777] *= 1.05;
  CHECK(verdict_on(truth, scan, at(T)).verdict == Outcome::verified);
  auto raw = at(T);
  raw.rule = Rule::max;
  CHECK(verdict_on(truth, scan, raw).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("verdict: neither threads nor the order of points change it") {
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  auto scan = scanned(truth, 30000, sigma);
  auto text = [&](const Scan& s, int threads) {
    auto verdict = verdict_on(truth, s, at(T), {}, threads);
    for (auto& a : verdict.artifacts) a.seconds = 0;
    return write_verdict_json(verdict);
  };
  const auto once = text(scan, 1);
  CHECK(text(scan, 2) == once);
  std::reverse(scan.cloud.points.begin(), scan.cloud.points.end());
  CHECK(text(scan, 2) == once);
}

TEST_CASE("verdict: two artifacts of one part must agree within a fifth of the tolerance") {
  const auto truth = sphere(20, 120);
  const auto scan = scanned(sphere(20, 200), 30000, sigma);
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "a.stl", write_stl(truth)).ok());
  REQUIRE(write_file(folder.path() / "b.stl", write_stl(sphere(20.04, 120))).ok());
  Context context;
  auto same = verify_artifacts({folder.path() / "a.stl", folder.path() / "a.stl"}, scan, {}, at(T), context);
  REQUIRE(same.ok());
  REQUIRE(same->between_backends.size() == 1);
  CHECK(same->between_backends[0].agree);
  CHECK(same->verdict == Outcome::verified);
  auto apart = verify_artifacts({folder.path() / "a.stl", folder.path() / "b.stl"}, scan, {}, at(T), context);
  REQUIRE(apart.ok());
  CHECK_FALSE(apart->between_backends[0].agree);
  CHECK(apart->verdict == Outcome::out_of_tolerance);
  CHECK(verdict_table(*apart).find("NOT VERIFIED: a.stl and b.stl differ by 0.04 mm") != std::string::npos);
}

TEST_CASE("verdict: what is wrong with one surface in several files is told once, and of whom") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 30000, sigma);
  const auto text = [&](const std::vector<double>& radii) {
    const TemporaryDirectory folder;
    std::vector<Path> files;
    for (const double radius : radii) {
      files.push_back(folder.path() / (std::string(1, char('a' + files.size())) + ".stl"));
      REQUIRE(write_file(files.back(), write_stl(holed_plate(40, 10, 6, radius, -8))).ok());
    }
    Context context;
    const auto verdict = verify_artifacts(files, scan, {}, at(T), context);
    REQUIRE(verdict.ok());
    CHECK(verdict->verdict == Outcome::out_of_tolerance);
    return verdict_table(*verdict);
  };
  const auto has = [](const std::string& all, const std::string& part) { return all.find(part) != std::string::npos; };
  const auto alike = text({5.3, 5.3, 5.3});
  CHECK(has(alike, "a.stl, what is wrong"));
  CHECK_FALSE(has(alike, "b.stl, what is wrong"));
  CHECK(has(alike, "The same is wrong with b.stl and c.stl."));
  CHECK(has(alike, "All files agree with each other: at most 0 mm apart"));
  const auto apart = text({5.3, 5.3, 5.4});
  CHECK(has(apart, "The same is wrong with b.stl."));
  CHECK(has(apart, "c.stl, what is wrong"));
  CHECK(has(apart, "a.stl and c.stl DIFFER"));
  CHECK(has(apart, "b.stl and c.stl DIFFER"));
}

TEST_CASE("verdict: bad requests say what is wrong") {
  Context context;
  const auto scan = scanned(sphere(20), 1000, 0);
  CHECK_FALSE(verify_artifacts({"nowhere.stl"}, scan, {}, at(T), context).ok());
  CHECK(verify_artifacts({"nowhere.stl"}, scan, {}, at(T), context).error().message.find("nowhere.stl") !=
        std::string::npos);
  CHECK_FALSE(verify_artifacts({"part.dwg"}, scan, {}, at(T), context).ok());
  CHECK(verify_artifacts({"part.dwg"}, scan, {}, at(T), context).error().message.find(".scad") != std::string::npos);
  CHECK_FALSE(verify_artifacts({}, scan, {}, at(T), context).ok());
  CHECK_FALSE(verify_artifacts({"part.scad"}, scan, {}, at(0), context).ok());
}

TEST_CASE("verdict: JSON, CSV, JUnit and the table say the same") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 30000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10, 6, 5.3, -8), scan, at(T));
  const auto json = write_verdict_json(verdict);
  CHECK(json.find("\"verdict\": \"out_of_tolerance\"") != std::string::npos);
  CHECK(json.find("\"between_backends\"") != std::string::npos);
  CHECK(json.find("\"hole 1\"") != std::string::npos);
  const auto csv = write_verdict_csv(verdict);
  CHECK(csv.rfind("file,backend,feature,kind,dimension,unit,nominal,measured,sigma,deviation,within,points,", 0) == 0);
  std::size_t lines = 2;  // heading and the whole artifact
  for (const auto& o : verdict.artifacts[0].objects) lines += std::max<std::size_t>(1, o.dimensions.size());
  CHECK(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')) == lines);
  const auto junit = write_verdict_junit(verdict);
  CHECK(junit.find("<failure") != std::string::npos);
  CHECK(junit.find("failures=\"2\"") != std::string::npos);  // the artifact and the hole
  const auto table = verdict_table(verdict);
  CHECK(table.find("NOT VERIFIED: hole 1 (diameter 12): centre") != std::string::npos);
  for (std::size_t at_line = 0; at_line < table.size();) {
    const auto end = table.find('\n', at_line);
    if (table.compare(at_line, 2, "  ") != 0 && table.compare(at_line, 3, "NOT") != 0) CHECK(end - at_line <= 100);
    at_line = end + 1;
  }
}

TEST_CASE("verdict: a million points against 100,000 triangles", "[.speed]") {
  const auto truth = sphere(50, 159);
  const auto scan = scanned(truth, 1000000, sigma);
  const auto start = std::chrono::steady_clock::now();
  const auto verdict = verdict_on(truth, scan, at(T));
  WARN(truth.triangles.size() << " triangles, "
                              << std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()
                              << " s\n"
                              << verdict_table(verdict));
  CHECK(verdict.verdict == Outcome::verified);
}

TEST_CASE("verdict: a few mixed pixels beside a wall that was hardly seen are no surface") {
  const auto truth = box({-40, -40, 0}, {40, 40, 10});
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    auto scan = scanned(truth, 17000, 0.03, seed);
    Random random(seed);
    auto& points = scan.cloud.points;
    const auto on_wall = [](const Vec3& p) { return p.x() > 39.5 && p.z() > 0.2 && p.z() < 9.8; };
    std::erase_if(points, [&](const Vec3& p) { return on_wall(p) && random.uniform() > 0.35; });
    // Pixels of its upper edge that fell short of what stands behind it, in four places.
    for (int place = 0; place < 4; ++place)
      for (int k = 0; k < 6; ++k)
        points.emplace_back(40 + random.uniform(0.2, 1.1), -30 + 20 * place + 1.1 * k + random.uniform(-0.3, 0.3),
                            9.8 - random.uniform(0, 0.6));
    // Elsewhere the scan has as many of them.
    for (int k = 0; k < 300; ++k)
      points.push_back(points[random.below(points.size())] +
                       random.uniform(-2, 2) * Vec3(random.normal(), random.normal(), random.normal()));
    const auto verdict = verdict_on(truth, scan, at(0.3));
    INFO(seed << "\n" << all_reasons(verdict));
    CHECK(verdict.verdict == Outcome::verified);
  }
}
