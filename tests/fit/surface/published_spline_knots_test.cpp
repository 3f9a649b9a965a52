/// Where the fits of 1993 put their knots.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "fit/surface/published_spline.h"

using namespace partscribe::geometry;
using namespace partscribe::fit;

TEST_CASE("published spline: knots come where the error has its maxima, and nowhere else") {
  // A long flat wave with two narrow bumps at 30 and 70 of 100.
  std::vector<Vec3> places;
  const auto bump = [](double x, double middle) { return 4 * std::exp(-(x - middle) * (x - middle) / 6); };
  for (int i = 0; i <= 500; ++i) {
    const double x = 0.2 * i;
    places.emplace_back(x, 0, std::sin(x / 30) + bump(x, 30) + bump(x, 70));
  }
  const auto at = parameters_of(places, Parameters::uniform);
  const KnotVector start = equal_spans(8);
  const PublishedCurve before = published_curve(places, at, start);
  REQUIRE(before.worst > 1);
  // What exceeds this lies on the bumps; what lies beside them swings less.
  const double tolerance = 0.6 * before.worst;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (before.errors[i] > tolerance) CHECK(std::min(std::abs(at[i] - 0.3), std::abs(at[i] - 0.7)) < 0.02);
  const PublishedCurve fine = refined_curve(places, at, start, tolerance);
  CHECK(fine.worst <= tolerance);
  std::vector<double> added;
  std::set_difference(fine.curve.t.knots.begin(), fine.curve.t.knots.end(), start.knots.begin(), start.knots.end(),
                      std::back_inserter(added));
  REQUIRE(added.size() >= 2);
  CHECK(fine.curve.points.size() == before.curve.points.size() + added.size());
  const double span = 1.0 / 5;  // of the start: a knot parts the one that holds the maximum
  for (const double t : added) CHECK(std::min(std::abs(t - 0.3), std::abs(t - 0.7)) <= span / 2 + 1e-12);
  for (const double middle : {0.3, 0.7})
    CHECK(std::any_of(added.begin(), added.end(), [&](double t) { return std::abs(t - middle) <= span / 2; }));
  // Where nothing exceeds the tolerance nothing is added.
  CHECK(refined_curve(places, at, start, before.worst).curve.t == start);
}
