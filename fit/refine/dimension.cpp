#include "fit/refine/dimension.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "fit/evidence/evidence.h"
#include "fit/refine/refine.h"
#include "fit/sketch/sketch_names.h"
#include "model/sketch.h"

namespace partscribe::fit {
namespace {

void visit(Candidate& candidate, const std::function<void(Expr&)>& change) {
  const auto of_shape = [&](Expr& e, Domain) { change(e); };
  for (Object& step : candidate.steps) {
    visit_expressions(step.shape, of_shape);
    visit_expressions(step.frame, change);
  }
  visit_expressions(candidate.shape, of_shape);
}

Parameter* parameter_of(Candidate& candidate, std::string_view name) {
  const auto found = std::ranges::find(candidate.parameters, name, &Parameter::name);
  return found == candidate.parameters.end() ? nullptr : &*found;
}

/// Puts `to` in the place of parameter `from` everywhere.
void put(Candidate& candidate, const std::string& from, const Expr& to) {
  visit(candidate, [&](Expr& e) { substitute(e, from, to); });
}

void drop(Candidate& candidate, const std::string& name) {
  std::erase_if(candidate.parameters, [&](const Parameter& p) { return p.name == name; });
  std::erase_if(candidate.held, [&](const HeldParameter& h) { return h.name == name; });
}

/// Gives parameter `from` another name, and a value that is `times` as large; not where the name is taken.
void restate(Candidate& candidate, const std::string& from, const std::string& to, const std::string& note,
             double times = 1) {
  Parameter* p = parameter_of(candidate, from);
  if (!p || (from != to && parameter_of(candidate, to))) return;
  const std::string tail = p->note.find(';') == std::string::npos ? "" : p->note.substr(p->note.find(';'));
  p->name = to, p->note = note + tail;
  for (double* v : {&p->value, &p->fitted, &p->sigma, &p->sigma_noise, &p->sigma_systematic}) *v *= times;
  for (HeldParameter& h : candidate.held)
    if (h.name == from) h.name = to, h.sigma *= times;
  put(candidate, from, times == 1 ? Expr::of(to) : Expr::of(to) / Expr(times));
}

/// "hole_radius" of "hole_2_radius", "groove_center_r" of "groove_center_2_r": the name without its number.
std::string role_of(const std::string& name) {
  std::string role, word;
  const auto end_word = [&] {
    const bool number = !word.empty() && std::ranges::all_of(word, [](char c) { return c >= '0' && c <= '9'; });
    if (!number) role += (role.empty() ? "" : "_") + word;
    word.clear();
  };
  for (const char c : name) {
    if (c == '_')
      end_word();
    else
      word += c;
  }
  end_word();
  return role;
}

std::vector<SketchArc*> arcs_of(Loop& loop) {
  std::vector<SketchArc*> arcs;
  for (SketchElement& element : loop.elements)
    if (auto* arc = std::get_if<SketchArc>(&element)) arcs.push_back(arc);
  return arcs;
}

/// Full circles of the trade: what a caliper or a plug gauge measures across.
void by_diameters(Candidate& candidate) {
  static const std::set<std::string, std::less<>> round = {
      "radius",      "body_radius", "bore_radius",   "head_radius", "shank_radius", "neck_radius", "hole_radius",
      "disc_radius", "ring_radius", "bottom_radius", "top_radius",  "major_radius", "minor_radius"};
  std::vector<std::string> names;
  for (const Parameter& p : candidate.parameters)
    if (round.contains(role_of(p.name))) names.push_back(p.name);
  for (const std::string& name : names) {
    std::string stem = name.substr(0, name.size() - std::string_view("radius").size());
    if (stem == "major_") stem = "ring_";
    if (stem == "minor_") stem = "tube_";
    std::string note = parameter_of(candidate, name)->note;
    note = note.substr(0, note.find(';'));
    if (note.starts_with("radius")) note = "diameter" + note.substr(std::string_view("radius").size());
    if (role_of(name) == "ring_radius") note = "diameter of the circle of centres";
    restate(candidate, name, stem.empty() ? "diameter" : stem + "d", note, 2);
  }
}

/// A bar whose ends are round has a width, and a distance between the centres of its ends.
void bars(Candidate& candidate) {
  auto* plate = std::get_if<Extrude>(&candidate.shape);
  if (!plate) return;
  std::vector<std::string> radii, reaches;
  for (Loop& loop : plate->sketch.loops) {
    const bool outer = &loop == &plate->sketch.loops.front();
    bool from_zero = false;
    std::vector<std::string> centres;
    for (const SketchArc* arc : arcs_of(loop)) {
      if (arc->radius.is_parameter() && role_of(arc->radius.parameter) == "end_radius" && outer)
        radii.push_back(arc->radius.parameter);
      from_zero |= arc->center_x == Expr(0);
      if (arc->center_x.is_parameter() && role_of(arc->center_x.parameter) == "end_center_x")
        centres.push_back(arc->center_x.parameter);
    }
    if (from_zero && centres.size() == 1) reaches = centres;
  }
  for (const std::string& r : radii) restate(candidate, r, "width", "width, twice the radius of the round ends", 2);
  for (const std::string& x : reaches)
    restate(candidate, x, "center_distance", "distance between the centres of the ends");
}

void plates(Candidate& candidate) {
  const auto* plate = std::get_if<Extrude>(&candidate.shape);
  if (!plate || !plate->height.is_parameter() || !drawable(candidate)) return;
  const Values values = values_of(candidate);
  const auto shape = std::get<ExtrudeOf<double>>(evaluate(candidate.shape, values));
  const Vec3 size = flat_box(outline_of(shape.sketch)).size();
  if (shape.height < height_of_plate * std::min(size.x(), size.y()))
    restate(candidate, plate->height.parameter, "thickness", "thickness");
}

/// A groove's centre lies outside the part: what is measured is the diameter at its bottom, or of a bulge at its crest.
bool turned_arcs(Candidate& candidate) {
  auto* turned = std::get_if<Revolve>(&candidate.shape);
  if (!turned) return false;
  struct Change {
    std::string centre, name, note;
    Expr to;
    double value;
  };
  std::vector<Change> changes;
  const Values values = values_of(candidate);
  for (Loop& loop : turned->sketch.loops)
    for (const SketchArc* arc : arcs_of(loop)) {
      if (!arc->center_x.is_parameter() || !arc->radius.is_parameter()) continue;
      const std::string& centre = arc->center_x.parameter;
      const std::string role = role_of(centre);
      const bool groove = role == "groove_center_r";
      if (!groove && role != "bulge_center_r") continue;
      if (std::ranges::any_of(changes, [&](const Change& c) { return c.centre == centre; })) continue;
      const std::string stem = groove ? "groove" : "bulge", number = centre.substr(stem.size() + 8);  // "_center_"
      const std::string name = stem + "_" + (number == "r" ? "" : number.substr(0, number.size() - 1)) + "d";
      const double r = evaluate(arc->radius, values), c = evaluate(arc->center_x, values);
      const Expr half = Expr::of(name) / Expr(2);
      changes.push_back({centre, name, groove ? "diameter at the bottom of the groove" : "diameter of the bulge",
                         groove ? half + arc->radius : half - arc->radius, 2 * (groove ? c - r : c + r)});
    }
  std::erase_if(changes, [&](const Change& c) { return !(c.value > 0) || parameter_of(candidate, c.name) != nullptr; });
  for (const Change& change : changes) {
    Parameter* p = parameter_of(candidate, change.centre);
    p->name = change.name, p->note = change.note, p->value = p->fitted = change.value;
    put(candidate, change.centre, change.to);
  }
  return !changes.empty();
}

/// Of the same role, and as near to each other as their sigmas are wide.
bool may_be_equal(const Parameter& a, const Parameter& b, double within) {
  constexpr double sigmas = 3;
  const double apart = std::abs(a.fitted - b.fitted);
  return a.quantity == Quantity::length && b.quantity == Quantity::length && role_of(a.name) == role_of(b.name) &&
         a.sigma > 0 && b.sigma > 0 && apart < within && apart <= sigmas * std::hypot(a.sigma, b.sigma);
}

bool equals(Candidate& candidate, double within) {
  bool any = false;
  auto& all = candidate.parameters;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = i + 1; k < all.size();) {
      if (!may_be_equal(all[i], all[k], within)) {
        ++k;
        continue;
      }
      const double a = 1 / (all[i].sigma * all[i].sigma), b = 1 / (all[k].sigma * all[k].sigma);
      all[i].value = all[i].fitted = (a * all[i].fitted + b * all[k].fitted) / (a + b);
      all[i].sigma = 1 / std::sqrt(a + b);
      all[i].note = of_several(all[i].note);
      put(candidate, all[k].name, Expr::of(all[i].name));
      drop(candidate, std::string(all[k].name));
      any = true;
    }
  return any;
}

}  // namespace

void dimension(Candidate& candidate) {
  by_diameters(candidate);
  bars(candidate);
  plates(candidate);
}

std::optional<Candidate> related(const Candidate& candidate, double within) {
  Candidate result = candidate;
  const bool equal = equals(result, within);
  return turned_arcs(result) || equal ? std::optional(std::move(result)) : std::nullopt;
}

}  // namespace partscribe::fit
