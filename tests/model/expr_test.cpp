// Expressions keep relations readable and exact.
#include "model/expr.h"

#include <catch2/catch.hpp>

#include "core/number.h"

using namespace partscribe::model;

TEST_CASE("expressions: neutral elements disappear, relations stay") {
  const Expr r = Expr::of("r");
  CHECK(r + Expr(0) == r);
  CHECK(Expr(1) * r == r);
  CHECK(r - r == Expr(0));
  CHECK(Expr(2) + Expr(3) == Expr(5));
  CHECK(-(-r) == r);
  CHECK((r - Expr(0.5)).kind == Expr::Kind::subtract);
  CHECK(r * Expr(0) == Expr(0));
}

TEST_CASE("expressions: values and clamped functions") {
  const Values v = {{"a", 3}, {"b", 4}};
  const Expr a = Expr::of("a"), b = Expr::of("b");
  CHECK(evaluate(Expr::call(Expr::Kind::sqrt, {a * a + b * b}), v) == Approx(5));
  CHECK(evaluate(Expr::call(Expr::Kind::acos, {b / a}), v) == 0);
  CHECK(evaluate(Expr::call(Expr::Kind::sqrt, {a - b}), v) == 0);
  CHECK(evaluate(Expr::call(Expr::Kind::atan2, {a, -a}), v) == Approx(0.75 * pi));
}
