/// Which of equals is taken, and that a little more or less changes nothing.
#include "fit/search/equal_choices.h"

#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::fit;

TEST_CASE("equal choices: a sense follows the scan's axes, whatever noise does to a direction that lies across one") {
  Random random(3);
  const auto shaken = [&](const Vec3& v) {
    return Vec3((v + 0.01 * Vec3(random.normal(), random.normal(), random.normal())).normalized());
  };
  for (int k = 0; k < 50; ++k) {
    CHECK(nearest_sense(shaken({0, 0, -1})).z() > 0.9);
    CHECK(nearest_sense(shaken({-1, 0, 0})).x() > 0.9);  // z has no say: it is 0 but for noise
    CHECK(nearest_sense(shaken({0, -1, 0})).y() > 0.9);
    CHECK(nearest_sense(shaken(Vec3(-1, 1, 0).normalized())).x() > 0.6);
    CHECK(nearest_to_scan({shaken({0, 1, 0}), shaken({-1, 0, 0}), shaken({1, 0, 0})}, {0, 1, 2}) == 2);
  }
}

TEST_CASE("equal choices: places and sizes that differ by less than their slack are put in order by what is left") {
  CHECK(in_order({{5, 0}, {0.01, 9}, {0, 10}, {0.02, -3}}, 0.1) == std::vector<std::size_t>{3, 1, 2, 0});
  CHECK(in_order({{5, 0}, {0, 9}, {0.02, 10}, {-0.01, -3}}, 0.1) == std::vector<std::size_t>{3, 1, 2, 0});
  CHECK(by_size({4, 8, 8.01}, {0, 1, 2}, 0.1) == std::vector<std::size_t>{1, 2, 0});
  CHECK(by_size({4, 8.01, 8}, {0, 2, 1}, 0.1) == std::vector<std::size_t>{2, 1, 0});
  CHECK(by_size({4, 8, 9}, {0, 1, 2}, 0.1) == std::vector<std::size_t>{2, 1, 0});
}
