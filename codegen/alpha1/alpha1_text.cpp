#include "codegen/alpha1/alpha1_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/number.h"

namespace partscribe::codegen {
namespace {

// Words that mean something to SCL, to its manual or to our prelude; names of functions do not heed case.
constexpr const char* reserved[] = {
    // keywords
    "and", "const", "commentoutcode", "else", "false", "for", "forcollect", "if", "include", "not", "or", "procedure",
    "quit", "return", "seq", "seqcollect", "set", "true", "unset", "while", "demand_eval",
    // predefined objects
    "linear", "quadratic", "cubic", "quartic", "quintic", "origin", "xaxis", "yaxis", "zaxis", "unitsphere",
    // functions
    "anchor", "arcendcenterend", "arcthru3pts", "arrayof", "bboxobj", "box", "boxfromanchor", "circccw", "circle",
    "circtubeconstantwidth", "combineshells", "crvfromarc", "crvfromcircle", "dumpa1file", "dumpgeomfile", "e2", "e3",
    "extrudeprofiles", "extrudeprofileswithdraft", "fillet", "filletoutside", "filletpt", "getattr", "group",
    "instance", "krefinesrf", "linethru2pts", "makegeom", "nurbscrv", "objtransform", "outlinecrv", "plane", "polyline",
    "profile", "pt", "ptl", "ptx", "pty", "ptz", "reflect", "remattr", "restoremodel", "reverseobj", "rightanglewedge",
    "rightcircylinder", "roundpolyline", "rx", "ry", "rz", "savemodel", "setattr", "setcolor", "setsharedattr", "setsq",
    "settexture", "sg", "shelloffacets", "shellofhalfspaces", "shellofsurfaces", "show", "srefine", "string_attr",
    "surface", "surfaceopen", "surfrev", "sxyz", "total_copy_obj", "tx", "ty", "tz", "vec", "cone", "cylinder",
    "ellipsoid", "extrude", "sphere", "torus", "wedge",
    // procedures of the prelude, and formal arguments of procedures in the body, which would hide a label
    "atradius", "facet", "halfspace", "moved", "nurbscurve", "polyhedronoffacets", "solidcommon", "soliddifference",
    "solidofextrusion", "solidofdraftedextrusion", "solidofhalfspaces", "solidofrevolution", "solidofsurface",
    "solidunion", "turned", "c", "q", "qc", "qs", "r", "rc", "rs", "s", "u", "w", "z",
    // labels of our own
    "asdesigned", "asscanned", "out", "placed"};

enum { sum = 1, product = 2, sign = 3, atom = 4 };

std::string lower(std::string text) {
  for (auto& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// "bore_1" and "left bore" as Bore1 and LeftBore; digits next to digits keep an underscore between them.
std::string camel_case(const std::string& name) {
  std::string text;
  bool start = true;
  for (const char c : name) {
    const bool digit = c >= '0' && c <= '9';
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!digit && !letter) {
      start = true;
      continue;
    }
    if (digit && start && !text.empty() && text.back() >= '0' && text.back() <= '9') text += '_';
    text += start && letter ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    start = false;
  }
  if (text.empty() || (text[0] >= '0' && text[0] <= '9')) text = "No" + text;
  return text;
}

bool has_parameter(const Expr& e) {
  bool found = false;
  visit_parameters(e, [&](const std::string&) { found = true; });
  return found;
}

std::string real_degrees(double angle) { return print_real(snapped(degrees(angle), 1e-10)); }

bool is_function(Expr::Kind kind) {
  switch (kind) {
    case Expr::Kind::sqrt:
    case Expr::Kind::sin:
    case Expr::Kind::cos:
    case Expr::Kind::asin:
    case Expr::Kind::acos:
    case Expr::Kind::atan2:
      return true;
    default:
      return false;
  }
}

bool gives_angle(Expr::Kind kind) {
  return kind == Expr::Kind::asin || kind == Expr::Kind::acos || kind == Expr::Kind::atan2;
}

}  // namespace

Expr cos_of(const Expr& angle) {
  if (has_parameter(angle)) return Expr::call(Expr::Kind::cos, {angle});
  return Expr(snapped(std::cos(evaluate(angle, {})), 1e-12));
}

Expr sin_of(const Expr& angle) {
  if (has_parameter(angle)) return Expr::call(Expr::Kind::sin, {angle});
  return Expr(snapped(std::sin(evaluate(angle, {})), 1e-12));
}

Alpha1Text::Alpha1Text(const Model& model) : values_(values_of(model)) {
  for (const char* word : reserved) taken_.insert(word);
  for (const auto& p : model.parameters) {
    quantity_[p.name] = p.quantity;
    parameters_[p.name] = fresh(p.name);
  }
  for (const auto& o : model.objects) objects_[o.name] = fresh(o.name);
}

std::string Alpha1Text::fresh(const std::string& wish) {
  const std::string base = camel_case(wish);
  std::string label = base;
  for (int i = 2; !taken_.insert(lower(label)).second; ++i) label = base + "_" + std::to_string(i);
  return label;
}

std::string Alpha1Text::plain(const Expr& expr) { return piece(expr, false, false).text; }
std::string Alpha1Text::angle(const Expr& expr) { return piece(expr, true, false).text; }

std::string Alpha1Text::factor(const Expr& expr) {
  Piece p = piece(expr, false, false);
  return p.strength == atom ? p.text : "( " + p.text + " )";
}

std::string Alpha1Text::angle_factor(const Expr& expr) {
  Piece p = piece(expr, true, false);
  return p.strength == atom ? p.text : "( " + p.text + " )";
}

std::vector<std::string> Alpha1Text::take_notes() {
  std::vector<std::string> notes;
  notes.swap(notes_);
  return notes;
}

bool Alpha1Text::carries_angle(const Expr& e) const {
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
    default:
      return gives_angle(e.kind);
  }
}

Alpha1Text::Piece Alpha1Text::piece(const Expr& e, bool as_angle, bool spelled_out) {
  // `right`: the operand stands right of its operator, where no sign may follow.
  auto operand = [&](std::size_t i, bool wants_angle, int needed, bool right) {
    Piece p = piece(e.arguments[i], wants_angle, spelled_out);
    if (p.strength < needed || (right && p.strength == sign)) return "( " + p.text + " )";
    return p.text;
  };
  auto converted = [&](Piece p, bool is_angle) -> Piece {
    if (is_angle == as_angle) return p;
    if (p.strength < product) p.text = "( " + p.text + " )";
    return {p.text + (as_angle ? " * " : " / ") + print_real(snapped(degrees(1), 1e-12)), product};
  };
  if (is_function(e.kind)) {
    if (spelled_out) {
      const bool of_angle = e.kind == Expr::Kind::sin || e.kind == Expr::Kind::cos;
      std::string text = std::string(kind_name(e.kind)) + "( ";
      for (std::size_t i = 0; i < e.arguments.size(); ++i)
        text += (i ? ", " : "") + piece(e.arguments[i], of_angle, true).text;
      return {text + " )", atom};
    }
    const double v = value(e);
    const std::string text = as_angle ? real_degrees(v) : print_real(snapped(v, 1e-12));
    if (has_parameter(e)) {
      const std::string note =
          text + (as_angle && gives_angle(e.kind) ? " degrees" : "") + " is " + piece(e, as_angle, true).text;
      if (std::find(notes_.begin(), notes_.end(), note) == notes_.end()) notes_.push_back(note);
    }
    return {text, text[0] == '-' ? sign : atom};
  }
  switch (e.kind) {
    case Expr::Kind::number: {
      std::string text = as_angle ? real_degrees(e.number) : print_real(e.number);
      const int strength = text[0] == '-' ? sign : atom;
      return {std::move(text), strength};
    }
    case Expr::Kind::parameter:
      return converted({parameters_.at(e.parameter), atom}, quantity_.at(e.parameter) == Quantity::angle);
    case Expr::Kind::negate:
      return {"-" + operand(0, as_angle, atom, true), sign};
    case Expr::Kind::add:
      return {operand(0, as_angle, sum, false) + " + " + operand(1, as_angle, sum, true), sum};
    case Expr::Kind::subtract:
      return {operand(0, as_angle, sum, false) + " - " + operand(1, as_angle, product, true), sum};
    case Expr::Kind::multiply: {
      const bool first = carries_angle(e.arguments[0]), second = carries_angle(e.arguments[1]);
      if (as_angle && first != second)
        return {operand(0, first, product, false) + " * " + operand(1, second, product, true), product};
      return converted({operand(0, false, product, false) + " * " + operand(1, false, product, true), product}, false);
    }
    case Expr::Kind::divide: {
      const bool first = carries_angle(e.arguments[0]), second = carries_angle(e.arguments[1]);
      const bool both = first && second;  // a ratio of angles is the same in degrees
      const bool angle_on_top = as_angle && !second && (first || e.arguments[0].is_number());
      Piece p{operand(0, both || angle_on_top, product, false) + " / " + operand(1, both, sign, true), product};
      return angle_on_top ? p : converted(std::move(p), false);
    }
    default:
      break;
  }
  ensure(false, "every kind of expression has a text");
  return {};
}

}  // namespace partscribe::codegen
