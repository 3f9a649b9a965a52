/// Expressions and names of a model as OpenSCAD text.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "geometry/vec.h"
#include "model/model.h"

namespace partscribe::codegen {

/// Entries of a long list, several to a line of at most 100 columns.
std::string wrapped_entries(const std::vector<std::string>& entries);
/// "[1, 2, 3]"
std::string point_text(const Vec3& p);
Vec3 snapped_vector(const Vec3& v, double resolution);

/// How a model's names are spelled in a script: as they are, unless OpenSCAD or our helpers use the word.
struct OpenscadNames {
  explicit OpenscadNames(const Model& model);
  std::map<std::string, std::string> parameter, object;
};

/// Turns expressions into text with no more parentheses than needed; angles are degrees in the script.
class OpenscadText {
 public:
  explicit OpenscadText(const Model& model);

  /// A length, ratio, coordinate: anything but an angle.
  std::string plain(const Expr& expr) const;
  /// An angle, in degrees.
  std::string angle(const Expr& expr) const;
  std::string of(const Expr& expr, Domain domain) const { return piece(expr, is_angle(domain)).text; }
  /// The same, fit to stand right of a product's sign.
  std::string factor(const Expr& expr, Domain domain) const;

  const OpenscadNames& names() const { return names_; }
  double value(const Expr& expr) const { return evaluate(expr, values_); }

 private:
  /// Text with the binding strength of its outermost operator.
  struct Piece {
    std::string text;
    int strength;
  };
  Piece piece(const Expr& expr, bool as_angle) const;
  static bool is_angle(Domain domain) { return domain == Domain::angle || domain == Domain::turn; }
  bool carries_angle(const Expr& expr) const;

  OpenscadNames names_;
  Values values_;
  std::map<std::string, Quantity> quantity_;
};

}  // namespace partscribe::codegen
