/// Rims of end faces: where a face ends, and where it does not.
#include "fit/sketch/end_rims.h"

#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"

namespace partscribe::testing {

using namespace fit;

TEST_CASE("end rims: a ring's face ends at its two circles, and its rim points out of the face") {
  constexpr double inner = 8, outer = 20, spacing = 0.6;
  Random random(5);
  std::vector<Vec2> face;
  while (face.size() < 3000) {
    const Vec2 p(random.uniform(-outer, outer), random.uniform(-outer, outer));
    if (p.norm() > inner && p.norm() < outer) face.push_back(p);
  }
  const auto rim = rim_of(face);
  std::size_t at_hole = 0, at_edge = 0, astray = 0;
  for (const auto& p : rim) {
    const double r = p.position.norm(), out = p.normal.dot(p.position) / r;
    if (std::abs(r - outer) < 2 * spacing && out > 0.7)
      ++at_edge;
    else if (std::abs(r - inner) < 2 * spacing && out < -0.7)
      ++at_hole;
    else
      ++astray;
  }
  CHECK(double(at_edge) > 0.5 * 2 * pi * outer / (2 * spacing));
  CHECK(double(at_hole) > 0.5 * 2 * pi * inner / (2 * spacing));
  CHECK(double(astray) < 0.1 * double(rim.size()));  // gaps by chance
}

TEST_CASE("end rims: too few points have no rim") { CHECK(rim_of({{0, 0}, {1, 0}, {0, 1}}).empty()); }

}  // namespace partscribe::testing
