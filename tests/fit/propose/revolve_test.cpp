/// Turned parts from points whose noise is a hundredth of the part: axis, profile, square steps.
#include "fit/propose/revolve.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "fit/evidence/evidence.h"
#include "fit/input/prepare.h"
#include "fit/refine/refine.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

/// A pin of three steps, the last a small one; its edge at the bottom may be rounded.
Model stepped_pin(double round = 0) {
  Loop loop;
  loop.name = "profile";
  loop.elements = {SketchPoint{0, 0, ""},  SketchPoint{20, 0, ""},  SketchPoint{20, 30, ""}, SketchPoint{9, 30, ""},
                   SketchPoint{9, 60, ""}, SketchPoint{12, 60, ""}, SketchPoint{12, 74, ""}, SketchPoint{0, 74, ""}};
  if (round > 0) loop.elements[1] = SketchArc{20 - round, round, round, -pi / 2, 0, "", ""};
  Model model;
  model.objects.push_back({"part", Revolve{{{loop}}}, {}, {}, {}});
  model.as_scanned = false;
  return model;
}

FitInput noisy_input(Scan& scan, double noise, double tolerance, Context& context, double round = 0,
                     Vec3 seen_from = {1, 0.6, 0.7}) {
  scan = sampled(stepped_pin(round), {.points = 4000, .noise = noise, .reach = 80, .seen_from = seen_from, .seed = 3});
  auto input = prepare(scan, tolerance, context);
  REQUIRE(input);
  return *input;
}

double nearest_value(const Candidate& c, double value) {
  double best = 1e300;
  for (const auto& p : c.parameters)
    if (std::abs(p.value - value) < std::abs(best - value)) best = p.value;
  return best;
}

}  // namespace

TEST_CASE("revolve: a stepped pin seen from one side comes with square steps at noise of a hundredth of its size") {
  Context context;
  Scan scan;
  const FitInput input = noisy_input(scan, 0.7, 2.1, context);
  auto candidates = propose_revolves(input, {Vec3(0.1, 0, 1), Vec3::UnitX()}, context);
  const auto found = std::find_if(candidates.begin(), candidates.end(), [&](Candidate& c) {
    if (!std::holds_alternative<Revolve>(c.shape) || c.parameters.size() > 6) return false;
    refine(c, input, {.points = 6000, .uncertainty = false}, context);
    return std::abs(nearest_value(c, 20) - 20) < 0.3 && std::abs(nearest_value(c, 9) - 9) < 0.3 &&
           std::abs(nearest_value(c, 12) - 12) < 0.3 && evidence_of(c, input, context).local_max < input.tolerance;
  });
  CHECK(found != candidates.end());
}

TEST_CASE("revolve: steps are made square where a round edge stays") {
  Context context;
  Scan scan;
  const FitInput input = noisy_input(scan, 0.7, 2.1, context, 6, {1, 0.6, -0.7});
  auto candidates = propose_revolves(input, {Vec3(0.1, 0, 1), Vec3::UnitX()}, context);
  const auto found = std::find_if(candidates.begin(), candidates.end(), [&](Candidate& c) {
    if (!std::holds_alternative<Revolve>(c.shape) || c.parameters.size() > 7) return false;
    refine(c, input, {.points = 6000, .uncertainty = false}, context);
    return std::abs(nearest_value(c, 20) - 20) < 0.3 && std::abs(nearest_value(c, 9) - 9) < 0.3 &&
           std::abs(nearest_value(c, 12) - 12) < 0.3 && std::abs(nearest_value(c, 6) - 6) < 0.6 &&
           evidence_of(c, input, context).local_max < input.tolerance;
  });
  CHECK(found != candidates.end());
}

TEST_CASE("revolve: a wall of which few points were seen belongs to the profile") {
  Context context;
  Scan dense =
           sampled(stepped_pin(), {.points = 6000, .noise = 0.1, .reach = 80, .seen_from = {1, 0.6, -0.7}, .seed = 3}),
       scan = dense;
  scan.cloud = {};
  for (std::size_t i = 0; i < dense.cloud.size(); ++i)
    if (dense.cloud.points[i].z() < 31 || i % 12 == 0) scan.cloud.points.push_back(dense.cloud.points[i]);
  const auto input = prepare(scan, 0.3, context);
  REQUIRE(input);
  const auto candidates = propose_revolves(*input, {Vec3(0.1, 0, 1)}, context);
  CHECK(std::any_of(candidates.begin(), candidates.end(), [](const Candidate& c) {
    return std::abs(nearest_value(c, 20) - 20) < 0.1 && std::abs(nearest_value(c, 9) - 9) < 0.1 &&
           std::abs(nearest_value(c, 12) - 12) < 0.1;
  }));
}

TEST_CASE("revolve: a neck that nobody saw lies where the shoulder below it ends") {
  Context context;
  const Scan dense =
      sampled(stepped_pin(), {.points = 6000, .noise = 0.1, .reach = 80, .seen_from = {1, 0.6, 0.7}, .seed = 3});
  Scan scan = dense;
  scan.cloud = {};
  for (const Vec3& p : dense.cloud.points)
    if (p.z() < 30.5 || p.z() > 59.5 || p.head<2>().norm() > 10.5) scan.cloud.points.push_back(p);
  const auto input = prepare(scan, 0.3, context);
  REQUIRE(input);
  auto candidates = propose_revolves(*input, {Vec3(0.1, 0, 1), Vec3::UnitX()}, context);
  const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return std::abs(nearest_value(c, 20) - 20) < 0.2 && std::abs(nearest_value(c, 12) - 12) < 0.2 &&
           std::abs(nearest_value(c, 9) - 9) < 0.6 && evidence_of(c, *input, context).local_max < input->tolerance;
  });
  CHECK(found != candidates.end());
}

TEST_CASE("revolve: the wall of a step hardly thicker than the nodes are wide is no part of the axis") {
  Loop loop;
  loop.name = "profile";
  loop.elements = {SketchPoint{0, 0, ""},  SketchPoint{20, 0, ""}, SketchPoint{20, 30, ""},
                   SketchPoint{4, 30, ""}, SketchPoint{4, 74, ""}, SketchPoint{0, 74, ""}};
  Model model;
  model.objects.push_back({"part", Revolve{{{loop}}}, {}, {}, {}});
  model.as_scanned = false;
  Scan scan = sampled(model, {.points = 4000, .noise = 0.2, .reach = 80, .seen_from = {1, 0.6, 0.7}, .seed = 3});
  // Of its end nothing was seen: what lies nearest to the axis is this wall.
  std::erase_if(scan.cloud.points, [](const Vec3& p) { return p.z() > 73; });
  Context context;
  const auto input = prepare(scan, 4, context);
  REQUIRE(input);
  auto candidates = propose_revolves(*input, {Vec3(0.1, 0, 1)}, context);
  CHECK(std::any_of(candidates.begin(), candidates.end(), [&](Candidate& c) {
    if (!std::holds_alternative<Revolve>(c.shape) || c.parameters.size() > 6) return false;
    refine(c, *input, {.points = 6000, .uncertainty = false}, context);
    return std::abs(nearest_value(c, 20) - 20) < 0.3 && std::abs(nearest_value(c, 4) - 4) < 0.3 &&
           evidence_of(c, *input, context).local_max < input->tolerance;
  }));
}

TEST_CASE("revolve: a profile is closed at a rim of which nobody saw enough") {
  // A cone's shell with a hole on top; nothing was seen of the hole's lower edge.
  Loop loop;
  loop.name = "profile";
  loop.elements = {SketchPoint{40, 0, ""}, SketchPoint{46, 0, ""}, SketchPoint{16, 40, ""}, SketchPoint{16, 32, ""}};
  Model model;
  model.objects.push_back({"part", Revolve{{{loop}}}, {}, {}, {}});
  model.as_scanned = false;
  Scan scan = sampled(model, {.points = 30000, .noise = 0.02, .reach = 50, .seed = 5});
  std::erase_if(scan.cloud.points, [](const Vec3& p) { return p.head<2>().norm() < 18 && p.z() < 33; });
  Context context;
  const auto input = prepare(scan, 0.2, context);
  REQUIRE(input);
  auto candidates = propose_revolves(*input, {Vec3::UnitZ()}, context);
  const bool found = std::any_of(candidates.begin(), candidates.end(), [&](Candidate& c) {
    const auto* revolve = std::get_if<Revolve>(&c.shape);
    if (!revolve || revolve->sketch.loops[0].elements.size() != 4) return false;
    refine(c, *input, {.points = 6000, .uncertainty = false}, context);
    return std::abs(nearest_value(c, 16) - 16) < 0.02 && std::abs(nearest_value(c, 46) - 46) < 0.02 &&
           evidence_of(c, *input, context).local_max < 0.1;
  });
  CHECK(found);
}

TEST_CASE("revolve: the axis is settled by the points, beyond what noisy normals say of it") {
  Context context;
  Scan scan;
  const FitInput input = noisy_input(scan, 0.7, 2.1, context);
  const auto axes = revolution_axes(input, {Vec3(0.1, 0, 1)});
  REQUIRE_FALSE(axes.empty());
  const auto candidates = propose_revolves(input, {Vec3(0.1, 0, 1)}, context);
  REQUIRE_FALSE(candidates.empty());
  const auto angle = [](const Vec3& d) { return std::acos(std::min(1.0, std::abs(d.normalized().z()))) * 180 / pi; };
  const Vec3 settled = candidates[0].scan_from_part.rotation.col(2);
  INFO(angle(axes[0].direction) << " degrees by the normals, " << angle(settled) << " settled");
  CHECK(angle(settled) < 0.2);
}

TEST_CASE("revolve: noisy normals lower no axis below the share at which it is used") {
  Context context;
  Scan scan;
  const FitInput input = noisy_input(scan, 1.0, 3, context);
  const auto axes = revolution_axes(input, {Vec3(0.1, 0, 1), Vec3::UnitX(), Vec3::UnitY()});
  REQUIRE_FALSE(axes.empty());
  CHECK(axes[0].share > 0.8);
  // Where normals are good enough all starts lead to the one axis.
  for (std::size_t k = 1; k < axes.size(); ++k) CHECK(axes[k].share < 0.8);
}
