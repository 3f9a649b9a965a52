#include "codegen/openscad/openscad_text.h"

#include <set>

#include "core/number.h"

namespace partscribe::codegen {
namespace {

// Words that a module of ours must not be called, because it would hide what other modules call.
const std::set<std::string> taken_modules = {"assert",       "children",       "circle",       "color",
                                             "cube",         "cylinder",       "difference",   "echo",
                                             "each",         "else",           "false",        "for",
                                             "function",     "group",          "hull",         "if",
                                             "import",       "include",        "intersection", "intersection_for",
                                             "let",          "linear_extrude", "minkowski",    "mirror",
                                             "module",       "multmatrix",     "offset",       "polygon",
                                             "polyhedron",   "projection",     "render",       "resize",
                                             "rotate",       "rotate_extrude", "scale",        "sphere",
                                             "square",       "surface",        "text",         "translate",
                                             "true",         "undef",          "union",        "use",
                                             "assign",       "ball",           "disc",         "drafted",
                                             "half_spaces",  "superellipsoid", "supertoroid",  "thick_sheet",
                                             "surface_body", "surface_sheet",  "round_cutter", "scan_from_part"};
const std::set<std::string> taken_variables = {
    "as_designed", "as_scanned", "assert",  "chord_error", "each",   "echo", "else", "false", "for", "function",
    "i",           "if",         "include", "let",         "module", "n",    "true", "undef", "use"};

std::string free_name(std::string name, const std::set<std::string>& taken, const std::string& suffix) {
  while (taken.count(name)) name += suffix;
  return name;
}

enum { sum = 1, product = 2, sign = 3, atom = 4 };

std::string guarded(std::string text, int strength, int needed) {
  return strength >= needed ? std::move(text) : "(" + std::move(text) + ")";
}

}  // namespace

std::string wrapped_entries(const std::vector<std::string>& entries) {
  std::string text, line;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::string entry = entries[i] + (i + 1 < entries.size() ? "," : "");
    if (!line.empty() && line.size() + 1 + entry.size() > 98) {
      text += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + entry;
  }
  return text + line;
}

std::string point_text(const Vec3& p) {
  return "[" + print_number(p.x()) + ", " + print_number(p.y()) + ", " + print_number(p.z()) + "]";
}

Vec3 snapped_vector(const Vec3& v, double resolution) {
  return {snapped(v.x(), resolution), snapped(v.y(), resolution), snapped(v.z(), resolution)};
}

OpenscadNames::OpenscadNames(const Model& model) {
  std::set<std::string> taken = taken_variables;
  for (const auto& p : model.parameters) {
    if (!taken_variables.count(p.name)) taken.insert(p.name);
  }
  for (const auto& p : model.parameters) {
    parameter[p.name] = taken_variables.count(p.name) ? free_name(p.name, taken, "_value") : p.name;
    taken.insert(parameter[p.name]);
  }
  std::set<std::string> modules = taken_modules;
  for (const auto& o : model.objects) {
    if (!taken_modules.count(o.name)) modules.insert(o.name);
  }
  for (std::size_t i = 0; i < model.objects.size(); ++i) {
    const std::string& name = model.objects[i].name;
    const bool clash = taken_modules.count(name) || (name == "part" && i + 1 < model.objects.size());
    modules.insert("part");
    object[name] = clash ? free_name(name, modules, "_body") : name;
    modules.insert(object[name]);
  }
}

OpenscadText::OpenscadText(const Model& model) : names_(model), values_(values_of(model)) {
  for (const auto& p : model.parameters) quantity_[p.name] = p.quantity;
}

std::string OpenscadText::plain(const Expr& expr) const { return piece(expr, false).text; }
std::string OpenscadText::angle(const Expr& expr) const { return piece(expr, true).text; }

std::string OpenscadText::factor(const Expr& expr, Domain domain) const {
  Piece p = piece(expr, is_angle(domain));
  return guarded(std::move(p.text), p.strength, sign);
}

bool OpenscadText::carries_angle(const Expr& e) const {
  switch (e.kind) {
    case Expr::Kind::parameter:
      return quantity_.at(e.parameter) == Quantity::angle;
    case Expr::Kind::negate:
      return carries_angle(e.arguments[0]);
    case Expr::Kind::add:
    case Expr::Kind::subtract:
      return carries_angle(e.arguments[0]) || carries_angle(e.arguments[1]);
    case Expr::Kind::multiply:
      return carries_angle(e.arguments[0]) != carries_angle(e.arguments[1]);
    case Expr::Kind::divide:
      return carries_angle(e.arguments[0]) && !carries_angle(e.arguments[1]);
    case Expr::Kind::asin:
    case Expr::Kind::acos:
    case Expr::Kind::atan2:
      return true;
    default:
      return false;
  }
}

OpenscadText::Piece OpenscadText::piece(const Expr& e, bool as_angle) const {
  const auto argument = [&](std::size_t i, bool wants_angle, int needed) {
    Piece p = piece(e.arguments[i], wants_angle);
    // a - -b would be right, but a - (-b) is what a person writes.
    const bool signed_operand = i > 0 && p.text[0] == '-';
    return guarded(std::move(p.text), p.strength, signed_operand ? atom : needed);
  };
  const auto converted = [&](Piece p, bool is_angle) -> Piece {
    if (is_angle == as_angle) return p;
    return {guarded(std::move(p.text), p.strength, product) + (as_angle ? " * 180 / PI" : " * PI / 180"), product};
  };
  switch (e.kind) {
    case Expr::Kind::number: {
      std::string text = as_angle ? print_degrees(e.number) : print_number(e.number);
      const int strength = text[0] == '-' ? sign : atom;
      return {std::move(text), strength};
    }
    case Expr::Kind::parameter:
      return converted({names_.parameter.at(e.parameter), atom}, quantity_.at(e.parameter) == Quantity::angle);
    case Expr::Kind::negate:
      return {"-" + argument(0, as_angle, atom), sign};
    case Expr::Kind::add:
      return {argument(0, as_angle, sum) + " + " + argument(1, as_angle, sum), sum};
    case Expr::Kind::subtract:
      return {argument(0, as_angle, sum) + " - " + argument(1, as_angle, product), sum};
    case Expr::Kind::multiply: {
      const bool first = carries_angle(e.arguments[0]), second = carries_angle(e.arguments[1]);
      if (!as_angle || (first && second)) {
        return converted({argument(0, false, product) + " * " + argument(1, false, product), product}, false);
      }
      const bool first_is_angle = first || (!second && e.arguments[0].is_number());
      if (!first_is_angle && !second && !e.arguments[1].is_number()) {
        return converted({argument(0, false, product) + " * " + argument(1, false, product), product}, false);
      }
      return {argument(0, first_is_angle, product) + " * " + argument(1, !first_is_angle, product), product};
    }
    case Expr::Kind::divide: {
      const bool first = carries_angle(e.arguments[0]), second = carries_angle(e.arguments[1]);
      const bool both = first && second;  // a ratio of angles is the same in degrees
      const bool angle_on_top = as_angle && !second && (first || e.arguments[0].is_number());
      Piece p{argument(0, both || angle_on_top, product) + " / " + argument(1, both, sign), product};
      return angle_on_top ? p : converted(std::move(p), false);
    }
    case Expr::Kind::sqrt: {
      std::string text = argument(0, false, sum);
      if (value(e.arguments[0]) < 1e-9) text = "max(0, " + text + ")";
      return converted({"sqrt(" + text + ")", atom}, false);
    }
    case Expr::Kind::sin:
    case Expr::Kind::cos:
      return converted({std::string(kind_name(e.kind)) + "(" + argument(0, true, sum) + ")", atom}, false);
    case Expr::Kind::asin:
    case Expr::Kind::acos: {
      std::string text = argument(0, false, sum);
      if (value(e.arguments[0]) > 1 - 1e-9) text = "min(1, " + text + ")";
      if (value(e.arguments[0]) < -1 + 1e-9) text = "max(-1, " + text + ")";
      return converted({std::string(kind_name(e.kind)) + "(" + text + ")", atom}, true);
    }
    case Expr::Kind::atan2:
      return converted({"atan2(" + argument(0, false, sum) + ", " + argument(1, false, sum) + ")", atom}, true);
  }
  ensure(false, "every kind of expression has a text");
  return {};
}

}  // namespace partscribe::codegen
