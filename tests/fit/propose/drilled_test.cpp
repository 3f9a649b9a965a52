/// Whole parts from scans: bodies with holes drilled into them.
#include "fit/propose/drilled.h"

#include <catch2/catch.hpp>

#include "fit/build.h"
#include "testing/golden_models.h"
#include "testing/parameter_value.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

TEST_CASE("drilled: a scan of a plate with a bore and four counterbored holes gives nine numbers") {
  Model truth;
  for (const Model& m : golden_models())
    if (m.name == "drilled_plate") truth = m;
  REQUIRE_FALSE(truth.objects.empty());
  truth.as_scanned = false;
  Scan scan = sampled(truth, {.points = 60000, .noise = 0.02, .reach = 65, .seen_from = Vec3::Zero(), .seed = 3});
  BuildOptions options;
  options.tolerance = 0.2;
  Context context;
  const auto model = build_model(scan, options, context);
  REQUIRE(model);
  CHECK_FALSE((*model)->fallback);
  CHECK((*model)->parameters.size() == 9);
  for (const auto& [name, size] : {std::pair{"length", 120.0},
                                   {"width", 80.0},
                                   {"thickness", 20.0},
                                   {"bore_d", 40.0},
                                   {"screw_hole_d", 9.0},
                                   {"head_d", 15.0},
                                   {"head_depth", 8.6},
                                   {"pitch_x", 90.0},
                                   {"pitch_y", 50.0}}) {
    INFO(name);
    CHECK(value_of(**model, name) == Approx(size).margin(0.02));
  }
}
