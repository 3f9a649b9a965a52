// From points to a model: the right procedure, the true numbers inside their stated uncertainty, and the same bytes
// whatever the order of the points and the number of threads.
#include "fit/build.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "model/distance/distance.h"
#include "model/json.h"
#include "testing/models.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

Model placed(Model model, const Vec3& move, const Vec3& turn) {
  model.scan_from_part = {move.x(), move.y(), move.z(), turn.x(), turn.y(), turn.z()};
  return model;
}

Model built(Scan scan, double tolerance, int threads = 1) {
  Context context;
  context.threads = threads;
  context.log = [](const std::string& line) { UNSCOPED_INFO(line); };
  BuildOptions options;
  options.tolerance = tolerance;
  auto model = build_model(scan, options, context);
  REQUIRE(model.ok());
  return **model;
}

std::string kind(const Model& m) { return std::string(kind_of(m.objects.back().shape)); }

/// The parameter nearest to a true value must hold it within three sigma.
void expect_value(const Model& m, double truth) {
  const auto best = std::min_element(
      m.parameters.begin(), m.parameters.end(),
      [&](const Parameter& a, const Parameter& b) { return std::abs(a.fitted - truth) < std::abs(b.fitted - truth); });
  REQUIRE(best != m.parameters.end());
  INFO(best->name << " " << best->fitted << " +- " << best->sigma << ", truth " << truth);
  CHECK(std::abs(best->fitted - truth) < 3 * best->sigma + 1e-9);
  CHECK(best->sigma < 0.05);
}

/// No point of the truth's surface is farther than the tolerance from the fitted one.
void expect_same_surface(const Model& truth, const Model& fitted, double tolerance) {
  Sampling exact;
  exact.points = 3000, exact.noise = 0, exact.seed = 99;
  const auto points = sampled(truth, exact);
  const ModelDistance distance(fitted);
  double worst = 0;
  for (const auto& p : points.cloud.points) worst = std::max(worst, std::abs(distance(p).distance));
  CHECK(worst < tolerance);
}

}  // namespace

TEST_CASE("build: a noisy ball becomes a sphere with the true diameter") {
  const Model truth = placed(model_with(Sphere{17.3}), {100, -50, 20}, {0, 0, 0});
  const Model m = built(sampled(truth, {}), 0.1);
  CHECK(kind(m) == "sphere");
  expect_value(m, 34.6);
  expect_same_surface(truth, m, 0.01);
}

TEST_CASE("build: a tilted cylinder keeps diameter and height") {
  const Model truth = placed(model_with(Cylinder{8, 25}), {5, 6, 7}, {0.4, -0.7, 0});
  const Model m = built(sampled(truth, {}), 0.1);
  CHECK(kind(m) == "cylinder");
  expect_value(m, 16);
  expect_value(m, 25);
  expect_same_surface(truth, m, 0.02);
}

TEST_CASE("build: a frustum is a cone, a torus a torus") {
  const Model cone = placed(model_with(Cone{12, 5, 20}), {1, 2, 3}, {1.1, 0.2, 0});
  const Model fitted_cone = built(sampled(cone, {}), 0.1);
  CHECK(kind(fitted_cone) == "cone");
  expect_same_surface(cone, fitted_cone, 0.03);
  const Model torus = placed(model_with(Torus{20, 6}), {1, 2, 3}, {0.3, 0.9, 0});
  const Model fitted_torus = built(sampled(torus, {}), 0.1);
  CHECK(kind(fitted_torus) == "torus");
  expect_value(fitted_torus, 40);
  expect_value(fitted_torus, 12);
}

TEST_CASE("build: a box has three sizes, at any attitude") {
  const Model truth = placed(model_with(Box{30, 20, 10}), {-10, 4, 9}, {0.5, 0.3, 1.2});
  const Model m = built(sampled(truth, {}), 0.1);
  CHECK(kind(m) == "box");
  for (const double size : {30.0, 20.0, 10.0}) expect_value(m, size);
  expect_same_surface(truth, m, 0.03);
}

TEST_CASE("build: a pin is turned, its round hangs on the head's radius") {
  Model truth = placed(pin(), {30, 30, -15}, {0.2, 0.1, 0});
  Sampling s;
  s.reach = 70, s.points = 40000, s.noise = 0.03;
  const Model m = built(sampled(truth, s), 0.15);
  CHECK(kind(m) == "revolve");
  CHECK(m.parameters.size() == 5);
  for (const double v : {40.0, 10.0, 15.0, 18.0, 65.0}) expect_value(m, v);
  expect_same_surface(truth, m, 0.05);
}

TEST_CASE("build: a link is an extrusion with round ends and a hole") {
  Model truth = placed(link(), {0, 0, 50}, {0.7, -0.3, 0.4});
  Sampling s;
  s.reach = 55, s.points = 40000, s.noise = 0.02;
  const Model m = built(sampled(truth, s), 0.1);
  CHECK(kind(m) == "extrude");
  for (const double size : {24.0, 10.0, 8.0}) expect_value(m, size);  // width, hole, thickness
  expect_same_surface(truth, m, 0.05);
}

TEST_CASE("build: a vase follows its free profile within tolerance") {
  SketchNurbs bulge;
  bulge.knots = {0, 0, 0, 0, 0.5, 1, 1, 1, 1};
  bulge.control = {{{10, 0}}, {{22, 9}}, {{2, 22}}, {{9, 34}}, {{14, 40}}};
  Loop profile;
  profile.elements = {SketchPoint{0, 0, ""}, bulge, SketchPoint{0, 40, ""}};
  const Model truth = placed(model_with(Revolve{{{profile}}}), {3, 4, 5}, {0.2, 0.3, 0});
  Sampling s;
  s.points = 30000, s.reach = 45;
  const Model m = built(sampled(truth, s), 0.1);
  CHECK(kind(m) == "revolve");
  expect_same_surface(truth, m, 0.1);
}

TEST_CASE("build: outliers change nothing") {
  const Model truth = placed(model_with(Cylinder{8, 25}), {5, 6, 7}, {0.4, -0.7, 0});
  Sampling s;
  s.outliers = 0.05;
  const Model m = built(sampled(truth, s), 0.1);
  CHECK(kind(m) == "cylinder");
  expect_same_surface(truth, m, 0.03);
}

TEST_CASE("build: order of the points and number of threads leave every byte alone") {
  const Model truth = placed(pin(), {30, 30, -15}, {0.2, 0.1, 0});
  Sampling s;
  s.reach = 70, s.points = 15000;
  const Scan scan = sampled(truth, s);
  Scan shuffled = scan;
  Random random(5);
  for (std::size_t i = shuffled.cloud.points.size(); i > 1; --i)
    std::swap(shuffled.cloud.points[i - 1], shuffled.cloud.points[random.below(i)]);
  const std::string first = write_model_json(built(scan, 0.15, 1));
  CHECK(write_model_json(built(scan, 0.15, 2)) == first);
  CHECK(write_model_json(built(shuffled, 0.15, 1)) == first);
}

TEST_CASE("build: moving the part moves the model, and nothing else") {
  const Model here = placed(model_with(Cylinder{8, 25}), {0, 0, 0}, {0.4, -0.7, 0});
  const Model there = placed(model_with(Cylinder{8, 25}), {1e5, -2e5, 3e5}, {0.4, -0.7, 0});
  const Model a = built(sampled(here, {}), 0.1), b = built(sampled(there, {}), 0.1);
  REQUIRE(kind(b) == "cylinder");
  CHECK(a.parameters[0].fitted == Approx(b.parameters[0].fitted).margin(0.002));
  expect_same_surface(there, b, 0.02);
}

namespace {

/// A bar 20 wide with round ends and a hole in each, 12 thick: turned over or end for end it is the same bar.
Model tie_bar(const Vec3& turn) {
  Loop outline;
  outline.elements = {SketchArc{60, 0, 10, -pi / 2, pi / 2, "", ""}, SketchArc{0, 0, 10, pi / 2, 3 * pi / 2, "", ""}};
  const auto hole = [](double x) {
    Loop loop;
    loop.elements = {SketchArc{x, 0, 4, 2 * pi, 0, "hole", ""}};
    return loop;
  };
  return placed(model_with(Extrude{{{outline, hole(0), hole(60)}}, Expr(12)}), {7, -3, 20}, turn);
}

Pose frame_of(const Model& m) { return evaluate(m.scan_from_part, values_of(m)); }

}  // namespace

TEST_CASE("build: which of equal faces, ends and holes comes first is the scan's frame's to say, not noise's") {
  std::map<std::string, double> first;
  for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(0, 0, pi / 2), Vec3(2.6, 0.3, 0.9)}) {
    std::optional<Pose> known;
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
      const Model m =
          built(sampled(tie_bar(turn), {.points = seed % 2 ? 15000u : 9000u, .noise = 0.03, .reach = 80, .seed = seed}),
                0.15);
      REQUIRE(kind(m) == "extrude");
      const Pose frame = frame_of(m);
      INFO("seed " << seed << ", z " << frame.rotation.col(2).transpose() << ", x "
                   << frame.rotation.col(0).transpose());
      CHECK(frame.rotation(2, 2) > 0);
      if (turn.x() == 0) CHECK(frame.rotation.col(0)[turn.z() == 0 ? 0 : 1] > 0.99);
      if (!known) known = frame;
      CHECK((known->rotation - frame.rotation).norm() < 0.02);
      CHECK((known->translation - frame.translation).norm() < 0.1);
      // The same numbers under the same names, however it lies.
      for (const auto& p : m.parameters) {
        const double truth = first.emplace(p.name, p.fitted).first->second;
        CHECK(p.fitted == Approx(truth).margin(0.03));
      }
    }
  }
}

TEST_CASE("build: too few points are one line of bad news") {
  Scan scan;
  scan.files = {"tiny.xyz"};
  for (int i = 0; i < 10; ++i) scan.cloud.points.push_back(Vec3(i, 0, 0));
  Context context;
  const auto result = build_model(scan, {}, context);
  REQUIRE_FALSE(result.ok());
  CHECK(result.error().message.find("tiny.xyz: expected at least 50 points, found 10") == 0);
}

TEST_CASE("build: forcing a procedure changes the script") {
  const Model truth = placed(model_with(Box{30, 20, 10}), {0, 0, 0}, {0, 0, 0});
  Scan scan = sampled(truth, {});
  Context context;
  BuildOptions options;
  options.force = "half_spaces";
  const auto model = build_model(scan, options, context);
  REQUIRE(model.ok());
  CHECK(kind(**model) != "box");
  // A triangulation that was asked for is no fallback, and nothing else is tried.
  options.force = "triangulation";
  const auto mesh = build_model(scan, options, context);
  REQUIRE(mesh.ok());
  CHECK(kind(**mesh) == "tri_surface");
  CHECK_FALSE((*mesh)->fallback);
  CHECK((*mesh)->rivals.empty());
}

namespace {

/// Builds a box's scan and refuses what `refuses` names.
Model built_unless(const std::function<bool(const Model&)>& refuses) {
  Scan scan = sampled(placed(model_with(Box{30, 20, 10}), {0, 0, 0}, {0, 0, 0}), {.points = 6000});
  Context context;
  BuildOptions options;
  options.refusal = [&](const CheckedModel& m) { return Result<std::string>(refuses(*m) ? "it will not do" : ""); };
  const auto model = build_model(scan, options, context);
  REQUIRE(model.ok());
  return **model;
}

}  // namespace

TEST_CASE("build: what is refused after the fit gives way to the next, and is named with the reason") {
  const Model next = built_unless([](const Model& m) { return kind(m) == "box"; });
  CHECK(kind(next) != "box");
  CHECK_FALSE(next.fallback);
  REQUIRE_FALSE(next.rivals.empty());
  CHECK(next.rivals.front().procedure == "box");
  CHECK(next.rivals.front().reason == "refused: it will not do");
}

TEST_CASE("build: where every procedure is refused a triangulation is the answer") {
  const Model mesh = built_unless([](const Model& m) { return kind(m) != "tri_surface"; });
  CHECK(kind(mesh) == "tri_surface");
  CHECK(mesh.fallback);
  CHECK(mesh.rivals.front().reason == "refused: it will not do");
}

TEST_CASE("build: where everything is refused the first model is the answer") {
  CHECK(kind(built_unless([](const Model&) { return true; })) == "box");
}

TEST_CASE("build: what was asked after the fit and failed ends the build") {
  Scan scan = sampled(placed(model_with(Sphere{10}), {0, 0, 0}, {0, 0, 0}), {.points = 2000});
  Context context;
  BuildOptions options;
  options.refusal = [](const CheckedModel&) { return Result<std::string>(Error{"no space", ErrorKind::stopped}); };
  const auto model = build_model(scan, options, context);
  REQUIRE_FALSE(model.ok());
  CHECK(model.error().message == "no space");
}
