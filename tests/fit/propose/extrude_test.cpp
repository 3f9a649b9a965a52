/// Extrusions among outliers: where a sweep begins and ends.
#include "fit/propose/extrude.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "fit/input/prepare.h"
#include "fit/refine/refine.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

TEST_CASE("extrude: outliers beside the walls do not move the ends of the sweep") {
  Loop outline;
  outline.name = "outline";
  outline.elements = {SketchPoint{0, 0, ""}, SketchPoint{60, 0, ""}, SketchPoint{60, 15, ""}, SketchPoint{25, 40, ""},
                      SketchPoint{0, 40, ""}};
  Model plate;
  plate.objects.push_back({"part", Extrude{{{outline}}, Expr(12)}, {}, {}, {}});
  plate.as_scanned = false;
  Context context;
  Scan scan = sampled(plate, {.points = 4000, .noise = 0.05, .reach = 70, .seen_from = Vec3::Zero(), .seed = 5});
  auto input = prepare(scan, 0.3, context);
  REQUIRE(input);
  // Every thirtieth point of a wall has a fellow far above or below.
  const std::size_t count = input->cloud.size();
  std::size_t walls = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 n = input->cloud.normals[i];
    if (std::abs(n.z()) > 0.1 || ++walls % 30 != 0) continue;
    input->cloud.points.push_back(input->cloud.points[i] + Vec3(0, 0, walls % 60 == 0 ? 15.0 : -14.0));
    input->cloud.normals.push_back(n);
  }
  input->outlier_share = 0.02;
  const auto candidates = propose_extrudes(*input, {Vec3::UnitZ()}, false, context);
  CHECK(std::any_of(candidates.begin(), candidates.end(), [](const Candidate& c) {
    return std::any_of(c.parameters.begin(), c.parameters.end(),
                       [](const Parameter& p) { return p.name == "height" && std::abs(p.value - 12) < 0.1; });
  }));
}
