/// Whole parts from scans: plain bodies some of whose faces are free form.
#include "fit/propose/sculpted.h"

#include <catch2/catch.hpp>

#include "fit/build.h"
#include "model/distance/distance.h"
#include "testing/golden_models.h"
#include "testing/parameter_value.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

Model saddle() {
  for (Model& m : golden_models())
    if (m.name == "saddle") {
      m.as_scanned = false;
      m.objects.back().frame = {-30, -20, -10, 0, 0, 0};
      return m;
    }
  return {};
}

}  // namespace

TEST_CASE("sculpted: a block with a free-form top and a hole is a box, a surface that cuts it, and the hole") {
  const Model truth = saddle();
  REQUIRE_FALSE(truth.objects.empty());
  Scan scan = sampled(truth, {.points = 12000, .noise = 0.02, .reach = 36, .seed = 7});
  BuildOptions options;
  options.tolerance = 0.25;
  Context context;
  const auto model = build_model(scan, options, context);
  REQUIRE(model);
  const Model& found = **model;
  CHECK_FALSE(found.fallback);
  CHECK(value_of(found, "length") == Approx(60).margin(0.02));
  CHECK(value_of(found, "width") == Approx(40).margin(0.02));
  CHECK(value_of(found, "bore_d") == Approx(8).margin(0.03));
  std::size_t surfaces = 0;
  for (const Object& o : found.objects)
    if (const auto* swept = std::get_if<SweptSurface>(&o.shape)) {
      ++surfaces;
      // The block's own top takes 20 control points.
      CHECK(swept->surface.control.size() < 60);
    }
  CHECK(surfaces == 1);
  // Everywhere, not only where there were points.
  const ModelDistance true_distance(truth), distance(found);
  for (const Vec3& p : sampled(truth, {.points = 500, .noise = 0, .reach = 36, .seed = 8}).cloud.points)
    REQUIRE(std::abs(distance(p).distance) < 0.1);
  // Nothing stands above the surface.
  CHECK(distance(Vec3(-20, -10, 30)).distance > 15);
}
