/// Tails of distributions against sums by hand.
#include "verify/compare/chance.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace partscribe::verify;

TEST_CASE("chance: tails agree with sums that can be done by hand") {
  CHECK(poisson_tail(0, 2) == 1);
  CHECK(poisson_tail(2, 0.5) == Approx(1 - std::exp(-0.5) * 1.5));
  CHECK(poisson_tail(5, 0) == 0);
  CHECK(binomial_tail(3, 3, 0.1) == Approx(0.001));
  CHECK(binomial_tail(2, 3, 0.1) == Approx(0.001 + 3 * 0.01 * 0.9));
  CHECK(binomial_tail(4, 3, 0.1) == 0);
  CHECK(two_sided_quantile(0.0455002638963584) == Approx(2).epsilon(1e-9));
}
