#include "fit/sketch/sketch_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <map>

#include "core/number.h"

namespace partscribe::fit {
namespace {

/// A level that is measured from the far side: `slot` is what is left of `size`.
struct FromFarSide {
  std::size_t slot, size;
};

/// The steps of an outline between its lower edge and `high` are measured from the nearer of the two. The two steps of
/// an angle are what its legs are thick.
std::vector<FromFarSide> measure_steps(std::vector<SketchSlot>& slots, const std::vector<SketchLevel>& levels,
                                       const std::array<const SketchLevel*, 2>& high) {
  std::array<std::vector<const SketchLevel*>, 2> steps;
  for (const SketchLevel& level : levels) {
    const auto axis = std::size_t(level.axis);
    if (level.set && level.expr.is_parameter() && high[axis] && slots[slot_of(level.expr)].role.starts_with("edge_"))
      steps[axis].push_back(&level);
  }
  const bool angle = steps[0].size() == 1 && steps[1].size() == 1;
  std::vector<FromFarSide> far;
  for (const std::size_t axis : {0, 1})
    for (const SketchLevel* level : steps[axis]) {
      const std::size_t slot = slot_of(level->expr);
      const bool from_far = level->value > high[axis]->value / 2;
      if (from_far) far.push_back({slot, slot_of(high[axis]->expr)});
      if (angle)
        slots[slot] = {"leg_thickness", "thickness of the leg"};
      else if (from_far)
        slots[slot].note = std::string("from an edge to the ") + (axis == 0 ? "right" : "back");
    }
  return far;
}

/// Roles that depend on all levels together.
std::vector<FromFarSide> rename_roles(std::vector<SketchSlot>& slots, const std::vector<SketchLevel>& levels,
                                      const std::vector<std::vector<SketchPiece>>& pieces_of_loops,
                                      const SketchOptions& options) {
  const double same = options.tolerance / 5;
  double top = -1e300;
  std::size_t top_slot = 0;
  std::vector<std::pair<const SketchLevel*, std::size_t>> walls;
  for (const auto& level : levels) {
    if (!level.set || !level.expr.is_parameter()) continue;
    const std::size_t slot = slot_of(level.expr);
    if (options.revolve && level.axis == 1 && level.value > top) top = level.value, top_slot = slot;
    if (options.revolve && level.axis == 0 && level.rising) walls.emplace_back(&level, slot);
  }
  double highest = -1e300;
  for (const auto& pieces : pieces_of_loops)
    for (const auto& p : pieces) {
      highest = std::max({highest, p.s.start.y(), p.s.end.y()});
      if (p.s.arc && p.s.sweep > 0 && p.from0 < pi / 2 && p.to0 > pi / 2)
        highest = std::max(highest, p.s.center.y() + p.s.radius);
    }
  if (top > 0 && top > highest - 2 * options.tolerance) slots[top_slot] = {"total_length", "length over all"};
  if (walls.size() == 2) {
    auto [big, small] = std::make_pair(walls[0], walls[1]);
    if (big.first->value < small.first->value) std::swap(big, small);
    const double big_length = big.first->high - big.first->low, small_length = small.first->high - small.first->low;
    if (big_length < small_length) {
      slots[big.second].role = "head_radius", slots[big.second].note = "radius of the head";
      slots[small.second].role = "shank_radius", slots[small.second].note = "radius of the shank";
    } else {
      slots[small.second].role = "neck_radius", slots[small.second].note = "radius of the neck";
    }
  }
  // The one shoulder of a part of two diameters ends the lower of its two cylinders.
  std::vector<std::size_t> shoulders;
  for (const auto& level : levels)
    if (options.revolve && level.axis == 1 && level.set && level.expr.is_parameter() && level.value < top)
      shoulders.push_back(slot_of(level.expr));
  if (walls.size() == 2 && shoulders.size() == 1 && slots[shoulders[0]].role == "shoulder_z") {
    const auto lower = walls[0].first->low < walls[1].first->low ? walls[0] : walls[1];
    const std::string& wall = slots[lower.second].role;  // "head_radius"
    const std::string name = wall.substr(0, wall.find('_'));
    slots[shoulders[0]] = name == "head" ? SketchSlot{"head_height", "height of the head"}
                                         : SketchSlot{name + "_length", "length of the " + name};
  }
  std::array<const SketchLevel*, 2> sizes = {};
  if (!options.revolve)
    for (int axis = 0; axis < 2; ++axis) {
      const SketchLevel* high = nullptr;
      bool datum = false;
      for (const auto& level : levels) {
        if (level.axis != axis || !level.set) continue;
        datum |= level.expr == Expr(0);
        if (!high || level.value > high->value) high = &level;
      }
      bool lowest = true;
      for (const auto& level : levels) lowest &= level.axis != axis || level.value > -same;
      if (!datum || !lowest || !high || !high->expr.is_parameter()) continue;
      slots[slot_of(high->expr)] =
          axis == 0 ? SketchSlot{"length", "size along x"} : SketchSlot{"width", "size along y"};
      sizes[std::size_t(axis)] = high;
    }
  return measure_steps(slots, levels, sizes);
}

}  // namespace

std::string of_several(const std::string& note) {
  const auto end = note.find(';');
  std::string one = note.substr(0, end);
  while (!one.empty() && (std::isdigit(static_cast<unsigned char>(one.back())) || one.back() == ' ')) one.pop_back();
  const auto word = one.rfind(" of ");
  if (word == std::string::npos || one.empty() || one.back() == 's') return note;
  const std::size_t thing = word + 4;
  if (one.compare(thing, 4, "the ") != 0) one.insert(thing, "the ");
  return one + "s" + (end == std::string::npos ? "" : note.substr(end));
}

void name_parameters(BuiltSketch& built, std::vector<SketchSlot> slots, const std::vector<SketchLevel>& levels,
                     const std::vector<std::vector<SketchPiece>>& pieces, const SketchOptions& options) {
  const std::vector<FromFarSide> far = rename_roles(slots, levels, pieces, options);
  std::map<std::string, std::string> wholes;  // of levels that are measured from the far side
  for (const auto& [slot, size] : far) {
    Parameter &p = built.parameters[slot], &whole = built.parameters[size];
    wholes[p.name] = whole.name;
    p.value = p.fitted = whole.value - p.value;
  }
  std::map<std::string, int> count, used;
  for (const auto& slot : slots) ++count[slot.role];
  std::map<std::string, std::string> names;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    std::string name = slots[i].role;
    if (count[name] > 1) {
      const int k = ++used[name];
      // head_radius, head_2_radius: the number stands before the last word.
      if (k > 1) {
        const auto cut = name.rfind('_');
        name = cut == std::string::npos ? name + "_" + std::to_string(k)
                                        : name.substr(0, cut) + "_" + std::to_string(k) + name.substr(cut);
      }
    }
    names[built.parameters[i].name] = name;
    built.parameters[i].name = name;
    built.parameters[i].note = slots[i].note;
  }
  std::function<void(Expr&)> rename = [&](Expr& e) {
    for (auto& a : e.arguments) rename(a);
    if (!e.is_parameter()) return;
    const auto whole = wholes.find(e.parameter);
    e = whole == wholes.end() ? Expr::of(names.at(e.parameter))
                              : Expr::of(names.at(whole->second)) - Expr::of(names.at(e.parameter));
  };
  const auto without = [](std::string name, std::initializer_list<const char*> suffixes) {
    for (const char* suffix : suffixes)
      if (name.ends_with(suffix)) name.resize(name.size() - std::string(suffix).size());
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
  };
  auto face_name = [&](const std::string& edge) -> std::string {
    if (edge.starts_with('/')) return without(names.at(edge.substr(1)), {"_width"});  // of a chamfer: its parameter
    if (edge.empty() || edge[0] != '#') return edge;
    const SketchLevel& level = levels[std::stoul(edge.substr(1))];
    if (level.axis == 1 && level.expr == Expr(0)) return "bottom face";
    std::string name = level.expr.is_parameter() ? names.at(level.expr.parameter) : level.axis == 0 ? "wall" : "face";
    if (name == "total_length") return "top face";
    if (name == "head_height" || (name.ends_with("_length") && level.axis == 1 && options.revolve)) return "shoulder";
    return without(std::move(name), {"_radius", "_z", "_thickness"});
  };
  for (auto& loop : built.sketch.loops)
    for (auto& element : loop.elements) {
      std::visit([&](auto& e) { e.edge = face_name(e.edge); }, element);
      // Of several fillets each is called as its radius is.
      auto* arc = std::get_if<SketchArc>(&element);
      if (!arc || !arc->radius.is_parameter()) continue;
      const std::string called = without(names.at(arc->radius.parameter), {"_radius"});
      if (!arc->name.empty() && called.starts_with(arc->name + " ")) arc->name = called;
    }
  Shape shape = Extrude{std::move(built.sketch), Expr(1)};
  visit_expressions(shape, [&](Expr& e, Domain) { rename(e); });
  built.sketch = std::move(std::get<Extrude>(shape).sketch);
}

}  // namespace partscribe::fit
