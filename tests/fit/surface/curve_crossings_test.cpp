#include "fit/surface/curve_crossings.h"

#include <catch2/catch.hpp>

using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

NurbsCurve<2> straight_line(const Vec2& a, const Vec2& b, double high) { return {clamped(1, {0, high}), {a, b}, {}}; }

}  // namespace

TEST_CASE("curve crossings: two lines cross at the shares where they do, whatever their domains") {
  const auto a = straight_line({0, 0}, {10, 0}, 1), b = straight_line({2.03, -1.01}, {2.03, 3}, 8),
             c = straight_line({0, 5}, {10, 5}, 1);
  const NurbsCurve<2>* const list[] = {&a, &b, &c};
  const auto found = crossings_of(list);
  REQUIRE(found.size() == 1);
  const std::size_t of_a = found[0].curve[0] == 0 ? 0 : 1;
  CHECK(found[0].curve[1 - of_a] == 1);
  CHECK(found[0].share[of_a] == Approx(0.2).margin(0.02));
  CHECK(found[0].share[1 - of_a] == Approx(0.25).margin(0.02));
}

TEST_CASE("curve crossings: ends that meet do not cross, a loop crosses itself") {
  const auto a = straight_line({0, 0}, {10, 0}, 1), b = straight_line({10, 0}, {10, 10}, 1);
  const NurbsCurve<2>* const corner[] = {&a, &b};
  CHECK(crossings_of(corner).empty());
  const NurbsCurve<2> loop{clamped(3, {0, 1}), {{0, 0}, {12, 8}, {-2, 8}, {10, 0}}, {}};
  const NurbsCurve<2>* const alone[] = {&loop};
  const auto found = crossings_of(alone);
  REQUIRE(found.size() == 1);
  CHECK(found[0].curve[0] == found[0].curve[1]);
  CHECK(found[0].share[0] + found[0].share[1] == Approx(1).margin(0.06));
}
