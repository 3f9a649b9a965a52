/// The state vector of 1993 displaces, cumulates and makes e(q) least.
#include "scan/register/as_published/state_vector.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::scan;

namespace {

std::vector<Vec3> points_anywhere(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (std::size_t k = 0; k < count; ++k) points.emplace_back(random.normal(), random.normal(), random.normal());
  return points;
}

StateVector some_state() { return state_of({rotation_of(Vec3(0.4, -1.2, 0.7)), Vec3(3, -4, 5)}); }

std::vector<Vec3> displaced(const std::vector<Vec3>& points, const StateVector& q) {
  std::vector<Vec3> result;
  for (const Vec3& p : points) result.push_back(pose_of(q) * p);
  return result;
}

}  // namespace

TEST_CASE("state vector: e(q) is the mean of the squared residuals") {
  // Two points a unit off along x and three units off along z: (1 + 9) / 2.
  const std::vector<Vec3> p{{0, 0, 0}, {2, 0, 0}}, x{{1, 0, 0}, {2, 0, 3}};
  CHECK(mean_square_error(p, x, {}) == Approx(5).epsilon(1e-14));
  // Half a turn about z and a step: (0, 0, 0) goes to (1, 1, 0), (2, 0, 0) to (-1, 1, 0).
  StateVector q;
  q.rotation = {0, 0, 0, 1}, q.translation = {1, 1, 0};
  CHECK(mean_square_error(p, x, q) == Approx((1 + 9 + 1 + 9) / 2.0).epsilon(1e-14));
}

TEST_CASE("state vector: the closed form finds a motion exactly") {
  const StateVector motion = some_state();
  const std::vector<Vec3> from = points_anywhere(12, 3), to = displaced(from, motion);
  const StateVector found = best_state(from, to);
  CHECK((found.rotation - motion.rotation).norm() < 1e-12);
  CHECK((found.translation - motion.translation).norm() < 1e-12);
  CHECK(mean_square_error(from, to, found) < 1e-24);
}

TEST_CASE("state vector: no state near the best one has a smaller e(q), and a poisoned one has a larger") {
  const std::vector<Vec3> p = points_anywhere(20, 5);
  std::vector<Vec3> x = displaced(p, some_state());
  const std::vector<Vec3> noise = points_anywhere(20, 6);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += 0.2 * noise[i];
  const StateVector best = best_state(p, x);
  const double least = mean_square_error(p, x, best);
  CHECK(least > 0.01);
  for (int k = 0; k < 6; ++k)
    for (const double step : {-1e-3, 1e-3}) {
      StateVector turn;
      if (k < 3)
        turn = state_of({rotation_of(step * Vec3::Unit(k)), Vec3::Zero()});
      else
        turn.translation[k - 3] = step;
      CHECK(mean_square_error(p, x, cumulated(turn, best)) > least);
    }
}

TEST_CASE("state vector: two displacements cumulated are one after the other, and stay a rotation") {
  StateVector all;
  Pose pose;
  Random random(9);
  for (int k = 0; k < 3000; ++k) {
    const Pose step{rotation_of(Vec3(random.normal(), random.normal(), random.normal())),
                    Vec3(random.normal(), random.normal(), random.normal())};
    all = cumulated(state_of(step), all), pose = step * pose;
  }
  const Vec3 p(0.3, 0.7, -2);
  CHECK((pose_of(all) * p - pose * p).norm() < 1e-9);
  CHECK(std::abs(all.rotation.norm() - 1) < 1e-14);
  CHECK((rotation_matrix(all) * rotation_matrix(all).transpose() - Mat3::Identity()).norm() < 1e-13);
}
