/// Walls of which both sides lie within the noise.
#include "fit/evidence/coverage.h"

#include <catch2/catch.hpp>

#include "fit/input/prepare.h"
#include "fit/refine/refine.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

TEST_CASE("coverage: a wall that is folded within the noise is thin, a plain one is not") {
  const auto plate_of = [](std::vector<SketchElement> elements) {
    Loop outline;
    outline.name = "outline", outline.elements = std::move(elements);
    Candidate plate;
    plate.object_name = "plate";
    plate.shape = Extrude{{{outline}}, Expr(40)};
    return plate;
  };
  const Candidate plain =
      plate_of({SketchPoint{0, 0, ""}, SketchPoint{40, 0, ""}, SketchPoint{40, 6, ""}, SketchPoint{0, 6, ""}});
  // Its lower wall runs to the right, back above itself, and to the right again: a wall and a slot, each within the
  // noise.
  const Candidate folded = plate_of({SketchPoint{0, -0.4, ""}, SketchPoint{35, -0.4, ""}, SketchPoint{5, 0, ""},
                                     SketchPoint{40, 0.4, ""}, SketchPoint{40, 6, ""}, SketchPoint{0, 6, ""}});
  Scan scan = sampled(bare_model(plain), {.points = 4000, .noise = 0.4, .reach = 45, .seed = 2});
  Context context;
  auto input = prepare(scan, 1.2, context);
  REQUIRE(input);
  input->sampling.sigma = 0.4;
  CHECK(coverage_of(plain, *input, context).thin < 0.01);
  CHECK(coverage_of(folded, *input, context).thin > 0.12);
}

TEST_CASE("coverage: walls thinner than the noise are thin, thick ones are not") {
  Context context;
  for (const double height : {0.8, 20.0}) {
    Candidate disc;
    disc.object_name = "disc";
    disc.shape = Cylinder{20, height};
    Scan scan = sampled(bare_model(disc), {.points = 4000, .noise = 0.4, .reach = 25, .seed = 2});
    auto input = prepare(scan, 1.2, context);
    REQUIRE(input);
    input->sampling.sigma = 0.4;
    const double thin = coverage_of(disc, *input, context).thin;
    INFO("height " << height << ": " << thin);
    CHECK((height < 1 ? thin > 0.4 : thin < 0.1));
  }
}
