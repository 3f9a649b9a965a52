/// The numbers of a sketch while it is being built: each has one name, and equal ones are one.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/model.h"

namespace partscribe::fit {

/// What a parameter of a sketch is, before it has its name.
struct SketchSlot {
  std::string role;  ///< its name without a number: "hole_radius"
  std::string note;  ///< for a person
};

/// Number of the slot that a provisional name belongs to.
std::size_t slot_of(const Expr& parameter);

/// Parameters have provisional names "#0", "#1" ...; their slots decide the final ones (sketch_names.h).
class SketchNumbers {
 public:
  using Shared = std::vector<std::pair<double, Expr>>;  ///< values and what stands for them

  /// Values nearer than `same` mm are one. The origin has coordinates of its own: zero.
  explicit SketchNumbers(double same);

  Expr parameter(double value, Quantity quantity, std::string role, std::string note);
  double value(const Expr& e) const;

  /// An equal one of the list, or a new length.
  Expr shared(Shared& list, double v, const std::string& role, const std::string& note);

  /// A coordinate along an axis (0: x, 1: y): what is known for it, or a new length.
  Expr coordinate(int axis, double v, const std::string& role, const std::string& note);
  std::optional<Expr> known(int axis, double v) const;
  bool knows(int axis, double v) const { return known(axis, v).has_value(); }
  void know(int axis, double v, const Expr& e);  ///< unless something is known already

  const double same;
  std::vector<Parameter> parameters;
  std::vector<SketchSlot> slots;

 private:
  Shared coordinates_[2];
};

}  // namespace partscribe::fit
