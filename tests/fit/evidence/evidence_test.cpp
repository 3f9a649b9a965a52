/// Which points around one judge a candidate together.
#include "fit/evidence/evidence.h"

#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::fit;

TEST_CASE("evidence: the two sides of a thin wall are judged apart where normals know their side") {
  FitInput input;
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const double side = i % 2 ? 1 : -1;
    input.cloud.points.push_back(Vec3(random.uniform(0, 20), random.uniform(0, 20), 0.2 * side));
    input.cloud.normals.push_back(Vec3(0, 0, side));
  }
  input.thin_spacing = 0.6;
  Context context;
  const auto mixed = [&](bool oriented) {
    input.oriented = oriented;
    const auto around = surroundings_of(input, context);
    std::size_t others = 0;
    for (std::size_t i = 0; i < input.cloud.size(); ++i)
      for (std::size_t k = around->first[i]; k < around->first[i + 1]; ++k) others += (around->index[k] - i) % 2;
    return others;
  };
  CHECK(mixed(true) == 0);
  CHECK(mixed(false) > 10000);
}
