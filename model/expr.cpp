#include "model/expr.h"

#include <algorithm>
#include <cmath>

namespace partscribe::model {

using Kind = Expr::Kind;

Expr Expr::of(std::string parameter_name) {
  Expr e;
  e.kind = Kind::parameter;
  e.parameter = std::move(parameter_name);
  return e;
}

Expr Expr::call(Kind kind, std::vector<Expr> arguments) {
  Expr e;
  e.kind = kind;
  e.arguments = std::move(arguments);
  return e;
}

namespace {
bool is(const Expr& e, double value) { return e.is_number() && e.number == value; }
}  // namespace

Expr operator-(Expr a) {
  if (a.is_number()) return Expr(-a.number + 0.0);
  if (a.kind == Kind::negate) return a.arguments[0];
  if (a.kind == Kind::subtract) return Expr::call(Kind::subtract, {a.arguments[1], a.arguments[0]});
  return Expr::call(Kind::negate, {std::move(a)});
}

Expr operator+(Expr a, Expr b) {
  if (a.is_number() && b.is_number()) return Expr(a.number + b.number);
  if (is(a, 0)) return b;
  if (is(b, 0)) return a;
  if (b.kind == Kind::negate) return std::move(a) - b.arguments[0];
  if (b.is_number() && a.kind == Kind::add && a.arguments[1].is_number())
    return a.arguments[0] + Expr(a.arguments[1].number + b.number);
  if (b.is_number() && b.number < 0) return Expr::call(Kind::subtract, {std::move(a), Expr(-b.number)});
  return Expr::call(Kind::add, {std::move(a), std::move(b)});
}

Expr operator-(Expr a, Expr b) {
  if (a.is_number() && b.is_number()) return Expr(a.number - b.number);
  if (is(b, 0)) return a;
  if (is(a, 0)) return -std::move(b);
  if (a == b) return Expr(0);
  if (b.kind == Kind::negate) return std::move(a) + b.arguments[0];
  if (b.is_number() && b.number < 0) return Expr::call(Kind::add, {std::move(a), Expr(-b.number)});
  return Expr::call(Kind::subtract, {std::move(a), std::move(b)});
}

Expr operator*(Expr a, Expr b) {
  if (a.is_number() && b.is_number()) return Expr(a.number * b.number);
  if (is(a, 0) || is(b, 0)) return Expr(0);
  if (is(a, 1)) return b;
  if (is(b, 1)) return a;
  if (is(a, -1)) return -std::move(b);
  if (is(b, -1)) return -std::move(a);
  return Expr::call(Kind::multiply, {std::move(a), std::move(b)});
}

Expr operator/(Expr a, Expr b) {
  if (a.is_number() && b.is_number() && b.number != 0) return Expr(a.number / b.number);
  if (is(b, 1)) return a;
  return Expr::call(Kind::divide, {std::move(a), std::move(b)});
}

std::string_view kind_name(Kind kind) {
  switch (kind) {
    case Kind::number:
      return "number";
    case Kind::parameter:
      return "parameter";
    case Kind::negate:
      return "neg";
    case Kind::add:
      return "+";
    case Kind::subtract:
      return "-";
    case Kind::multiply:
      return "*";
    case Kind::divide:
      return "/";
    case Kind::sqrt:
      return "sqrt";
    case Kind::sin:
      return "sin";
    case Kind::cos:
      return "cos";
    case Kind::asin:
      return "asin";
    case Kind::acos:
      return "acos";
    case Kind::atan2:
      return "atan2";
  }
  ensure(false, "every kind of expression has a name");
  return {};
}

double evaluate(const Expr& e, const Values& values) {
  auto argument = [&](std::size_t i) { return evaluate(e.arguments[i], values); };
  auto unit = [](double x) { return std::clamp(x, -1.0, 1.0); };
  switch (e.kind) {
    case Kind::number:
      return e.number;
    case Kind::parameter: {
      const auto found = values.find(e.parameter);
      ensure(found != values.end(), "an expression names a known parameter");
      return found->second;
    }
    case Kind::negate:
      return -argument(0);
    case Kind::add:
      return argument(0) + argument(1);
    case Kind::subtract:
      return argument(0) - argument(1);
    case Kind::multiply:
      return argument(0) * argument(1);
    case Kind::divide:
      return argument(0) / argument(1);
    case Kind::sqrt:
      return std::sqrt(std::max(argument(0), 0.0));
    case Kind::sin:
      return std::sin(argument(0));
    case Kind::cos:
      return std::cos(argument(0));
    case Kind::asin:
      return std::asin(unit(argument(0)));
    case Kind::acos:
      return std::acos(unit(argument(0)));
    case Kind::atan2:
      return std::atan2(argument(0), argument(1));
  }
  return 0;
}

void visit_parameters(const Expr& e, const std::function<void(const std::string&)>& visit) {
  if (e.is_parameter()) visit(e.parameter);
  for (const auto& a : e.arguments) visit_parameters(a, visit);
}

void substitute(Expr& e, std::string_view from, const Expr& to) {
  if (e.is_parameter() && e.parameter == from) {
    e = to;
    return;
  }
  for (auto& a : e.arguments) substitute(a, from, to);
}

}  // namespace partscribe::model
