/// Names, numbers and expressions of a model as Alpha_1 (SCL) text.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "model/model.h"

namespace partscribe::codegen {

/// Spells names as labels and expressions as SCL. SCL's mathematical functions are not documented, so sqrt, sin and
/// their like come out as numbers; what such a number stands for is remembered in notes().
class Alpha1Text {
 public:
  explicit Alpha1Text(const Model& model);

  const std::string& parameter(const std::string& name) const { return parameters_.at(name); }
  const std::string& object(const std::string& name) const { return objects_.at(name); }
  /// A label nobody has yet, close to `wish` ("tie_bar outline" becomes TieBarOutline).
  std::string fresh(const std::string& wish);

  /// A length, ratio, coordinate: anything but an angle.
  std::string plain(const Expr& expr);
  /// An angle, in degrees.
  std::string angle(const Expr& expr);
  /// As plain and angle, fit to stand right of an operator.
  std::string factor(const Expr& expr);
  std::string angle_factor(const Expr& expr);
  double value(const Expr& expr) const { return evaluate(expr, values_); }

  /// What numbers in the text so far stand for; empties the list.
  std::vector<std::string> take_notes();

 private:
  struct Piece {
    std::string text;
    int strength;
  };
  Piece piece(const Expr& expr, bool as_angle, bool spelled_out);
  bool carries_angle(const Expr& expr) const;

  Values values_;
  std::map<std::string, Quantity> quantity_;
  std::map<std::string, std::string> parameters_, objects_;
  std::set<std::string> taken_;  // in lower case
  std::vector<std::string> notes_;
};

/// cos and sin of an angle: a number if the angle holds no parameter, else an expression.
Expr cos_of(const Expr& angle);
Expr sin_of(const Expr& angle);

}  // namespace partscribe::codegen
