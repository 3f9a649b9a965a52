/// Numbers, parameters and arithmetic of such: what a dimension of a part is made of.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace partscribe::model {

/// Values of parameters by name.
using Values = std::map<std::string, double, std::less<>>;

/// Millimetres and radians. Functions: sqrt, sin, cos, asin, acos of one argument, atan2 of two (y, x).
struct Expr {
  enum class Kind { number, parameter, negate, add, subtract, multiply, divide, sqrt, sin, cos, asin, acos, atan2 };
  Kind kind = Kind::number;
  double number = 0;            ///< for Kind::number
  std::string parameter;        ///< for Kind::parameter
  std::vector<Expr> arguments;  ///< for all others

  Expr() = default;
  Expr(double value) : number(value) {}
  Expr(int value) : number(value) {}
  static Expr of(std::string parameter_name);
  static Expr call(Kind kind, std::vector<Expr> arguments);

  bool is_number() const { return kind == Kind::number; }
  bool is_parameter() const { return kind == Kind::parameter; }
  bool operator==(const Expr&) const = default;
};

/// Arithmetic folds numbers and neutral elements, so that x + 0 is x.
Expr operator+(Expr a, Expr b);
Expr operator-(Expr a, Expr b);
Expr operator*(Expr a, Expr b);
Expr operator/(Expr a, Expr b);
Expr operator-(Expr a);

/// The name of an operator or function as model.json has it: "+", "-", "*", "/", "neg", "sqrt", ...
std::string_view kind_name(Expr::Kind kind);

/// The value; an unknown parameter is our own mistake (check() finds it first). asin, acos and sqrt clamp their
/// argument into their domain, because a fit may step across its edge.
double evaluate(const Expr& expr, const Values& values);

/// Calls `visit` with every parameter name in the expression, in order, repeats included.
void visit_parameters(const Expr& expr, const std::function<void(const std::string&)>& visit);

/// Replaces parameter `from` by `to` everywhere.
void substitute(Expr& expr, std::string_view from, const Expr& to);

}  // namespace partscribe::model
