/// Claims about least squares by normal equations.
#include "geometry/least_squares.h"

#include <catch2/catch.hpp>

#include "core/random.h"

namespace partscribe::testing {
using namespace geometry;
using namespace core;

TEST_CASE("least squares: the sums give the line through samples, and a ridge holds what they leave open") {
  NormalSums<2> sums;
  for (int k = 0; k < 9; ++k) sums.add({double(k), 1}, 3 * k - 2);
  CHECK((sums.solution(0) - Eigen::Vector2d(3, -2)).norm() < 1e-9);
  NormalSums<2> slope_open;
  slope_open.add({0, 1}, 5);
  CHECK((slope_open.solution(1e-9) - Eigen::Vector2d(0, 5)).norm() < 1e-6);
}

TEST_CASE("least squares: reweighted, the level of most samples comes out whatever a third of them says") {
  Random random(3);
  std::vector<double> samples;
  for (int k = 0; k < 200; ++k) samples.push_back(7 + 0.01 * random.normal());
  for (int k = 0; k < 100; ++k) samples.push_back(random.uniform(8, 30));
  double level = 0;
  const auto fit = [&](const std::vector<double>& weights) {
    NormalSums<1> sums;
    for (std::size_t i = 0; i < samples.size(); ++i) sums.add(NormalSums<1>::Row(1), samples[i], weights[i]);
    level = sums.g[0] / sums.h(0, 0);
    return level < 100;
  };
  const auto off = [&](std::size_t i) { return samples[i] - level; };
  CHECK(reweighted(samples.size(), {30, 2, 0.02}, fit, off));
  CHECK(level == Approx(7).margin(0.005));
  CHECK(reweighted(samples.size(), {30, 2, 0.02, 0.8}, fit, off));
  CHECK(level == Approx(7).margin(0.005));
  samples.assign(5, 1000);
  CHECK_FALSE(reweighted(samples.size(), {}, fit, off));
}

TEST_CASE("least squares: a damped step is shortened until it is taken, and none is taken in the end") {
  const Eigen::Matrix2d h = Eigen::Vector2d(4, 1).asDiagonal();
  const Eigen::Vector2d g(8, 2);
  const auto solve = [](const Eigen::Matrix2d& a, const Eigen::Vector2d& b) { return solve_ldlt(a, b); };
  Damping damping{1e-3, 0.1, 10, 1e-9, 1e6};
  Eigen::Vector2d taken;
  CHECK(damped_step(h, g, 0, damping, 8, solve, [&](const Eigen::Vector2d& step) {
    taken = step;
    return step.norm() < 1;
  }));
  CHECK(taken.norm() < 1);
  CHECK(taken.x() == Approx(taken.y()));  // each unknown in its own units
  CHECK(damping.value == Approx(0.1 * 10));
  CHECK_FALSE(damped_step(h, g, 0, damping, 3, solve, [](const Eigen::Vector2d&) { return false; }));
  CHECK(damping.value == Approx(1000));
}

}  // namespace partscribe::testing
