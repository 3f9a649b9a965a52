/// Noise of each point, told from the distances of all.
#include "fit/uncertainty/noise_model.h"

#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::fit;

TEST_CASE("noise model: rims get a sigma but have no say about it") {
  Random random(4);
  std::vector<double> residuals;
  NoiseTraits traits;
  for (int i = 0; i < 4000; ++i) {
    const bool rim = i % 4 == 0;
    residuals.push_back((rim ? 1.0 : 0.1) * random.normal());
    traits.face.push_back(i % 2), traits.told.push_back(!rim);
  }
  for (const double s : noise_of_points(residuals, traits, 1e-6)) REQUIRE(s == Approx(0.1).epsilon(0.05));
}
