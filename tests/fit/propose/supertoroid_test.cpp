/// A start for a ring with corners from half of its surface.
#include "fit/propose/supertoroid.h"

#include <catch2/catch.hpp>

#include "testing/models.h"
#include "testing/sampled.h"

namespace partscribe::testing {

using namespace fit;
using partscribe::testing::model_with;

namespace {}  // namespace

TEST_CASE("supertoroid: a start from half of a soiled ring is near the truth") {
  const Supertoroid truth{30, 10, 8, 0.6, 0.5};
  Scan scan =
      sampled(model_with(truth),
              {.points = 2000, .noise = 0.1, .outliers = 0.05, .reach = 42, .seen_from = {1, 0.5, 1.5}, .seed = 4});
  Context context;
  const SupertoroidFit fit =
      recover_supertoroid(scan.cloud.points, {{{1, -2, 3}, Vec3(0.05, 0.02, 1).normalized(), 1}}, context);
  CHECK(fit.shape.major_radius == Approx(30).margin(0.3));
  CHECK(fit.shape.minor_radius == Approx(10).margin(0.3));
  CHECK(fit.shape.half_height == Approx(8).margin(0.3));
  CHECK(fit.shape.e1 == Approx(0.6).margin(0.08));
  CHECK(fit.shape.e2 == Approx(0.5).margin(0.05));
  CHECK(fit.miss < 0.15);
}

}  // namespace partscribe::testing
