#include "fit/sketch/sketch_numbers.h"

#include <cmath>

#include "fit/sketch/sketch_names.h"

namespace partscribe::fit {
namespace {

std::optional<Expr> found(const SketchNumbers::Shared& list, double v, double same) {
  for (const auto& [value, expr] : list)
    if (std::abs(value - v) < same) return expr;
  return {};
}

}  // namespace

SketchNumbers::SketchNumbers(double same_within) : same(same_within) {
  for (auto& list : coordinates_) list.emplace_back(0.0, Expr(0));
}

Expr SketchNumbers::parameter(double value, Quantity quantity, std::string role, std::string note) {
  Parameter p;
  p.name = "#" + std::to_string(parameters.size());
  p.quantity = quantity;
  p.value = p.fitted = value;
  parameters.push_back(p);
  slots.push_back({std::move(role), std::move(note)});
  return Expr::of(p.name);
}

std::size_t slot_of(const Expr& parameter) { return std::stoul(parameter.parameter.substr(1)); }

double SketchNumbers::value(const Expr& e) const {
  Values v;
  for (const auto& p : parameters) v[p.name] = p.value;
  return evaluate(e, v);
}

Expr SketchNumbers::shared(Shared& list, double v, const std::string& role, const std::string& note) {
  if (const auto known = found(list, v, same)) {
    if (known->is_parameter()) {
      SketchSlot& slot = slots[slot_of(*known)];
      if (slot.note != note) slot.note = of_several(slot.note);
    }
    return *known;
  }
  list.emplace_back(v, parameter(v, Quantity::length, role, note));
  return list.back().second;
}

Expr SketchNumbers::coordinate(int axis, double v, const std::string& role, const std::string& note) {
  return shared(coordinates_[axis], v, role, note);
}

std::optional<Expr> SketchNumbers::known(int axis, double v) const { return found(coordinates_[axis], v, same); }

void SketchNumbers::know(int axis, double v, const Expr& e) {
  if (!knows(axis, v)) coordinates_[axis].emplace_back(v, e);
}

}  // namespace partscribe::fit
