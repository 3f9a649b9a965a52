#include "codegen/openscad/openscad_sketch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "codegen/describe.h"
#include "core/ensure.h"
#include "core/number.h"
#include "model/sketch.h"

namespace partscribe::codegen {
namespace {

using Text = OpenscadText;

/// One line of a polygon's list with the remark that stands behind it.
struct Row {
  std::string text, remark;
};

// Longer rows have their remark above, not behind.
constexpr std::size_t longest_beside = 70;

std::string point_text(const Expr& x, const Expr& y, const Text& text) {
  return "[" + text.plain(x) + ", " + text.plain(y) + "]";
}

std::string list_text(const std::vector<double>& numbers) {
  std::string list;
  for (const double number : numbers) list += (list.empty() ? "" : ", ") + print_number(number);
  return "[" + list + "]";
}

std::string remark_of(const std::string& name, const std::string& edge) {
  if (name.empty()) return one_line(edge);
  return one_line(edge.empty() ? name : name + ", then " + edge);
}

/// Letters, digits and _ of a role.
std::string identifier_of(const std::string& role) {
  std::string word;
  for (const char c : role) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (letter)
      word += c;
    else if (!word.empty() && word.back() != '_')
      word += '_';
  }
  while (!word.empty() && word.back() == '_') word.pop_back();
  return word.empty() ? "curve" : word;
}

/// The names of the control point tables, by curve, in the order of the sketch.
using CurveNames = std::map<const SketchNurbs*, std::string>;

CurveNames curve_names(const Sketch& sketch, const std::string& module, const Text& text) {
  std::set<std::string> taken;
  for (const auto& [name, spelled] : text.names().parameter) taken.insert(spelled);
  CurveNames names;
  for (const Loop& loop : sketch.loops) {
    for (const auto& element : loop.elements) {
      const auto* curve = std::get_if<SketchNurbs>(&element);
      if (!curve) continue;
      const std::string base = module + "_" + identifier_of(curve->name);
      std::string name = base;
      for (int i = 2; !taken.insert(name).second; ++i) name = base + "_" + std::to_string(i);
      names[curve] = name;
    }
  }
  return names;
}

/// The table of a curve's control points.
std::string control_table(const SketchNurbs& curve, const std::string& name, const Text& text) {
  std::string table =
      "// Control points of the " + one_line(curve.name.empty() ? "curve" : curve.name) + ".\n" + name + " = [\n";
  for (std::size_t i = 0; i < curve.control.size(); ++i) {
    table += "  " + point_text(curve.control[i][0], curve.control[i][1], text) +
             (i + 1 < curve.control.size() ? ",\n" : "\n];\n\n");
  }
  return table;
}

/// The rows one below the other, their remarks in one column.
std::string aligned(const std::vector<Row>& rows) {
  std::size_t width = 0;
  for (const Row& row : rows) {
    if (!row.remark.empty() && row.text.size() <= longest_beside) width = std::max(width, row.text.size());
  }
  std::string lines;
  for (const Row& row : rows) {
    std::string line = row.text;
    if (!row.remark.empty() && row.text.size() > longest_beside) {
      line = "// " + row.remark + "\n" + row.text;
    } else if (!row.remark.empty()) {
      line.resize(std::max(width, line.size()), ' ');
      line += "  // " + row.remark;
    }
    lines += (lines.empty() ? "" : "\n") + line;
  }
  return lines;
}

Row row_of(const SketchPoint& p, const Text& text, const CurveNames&, OpenscadNeeds&) {
  return {point_text(p.x, p.y, text), one_line(p.edge)};
}

Row row_of(const SketchArc& a, const Text& text, const CurveNames&, OpenscadNeeds& needs) {
  needs.arc = true;
  return {"each arc(" + point_text(a.center_x, a.center_y, text) + ", " + text.plain(a.radius) + ", " +
              text.angle(a.from) + ", " + text.angle(a.to) + ")",
          remark_of(a.name, a.edge)};
}

Row row_of(const SketchNurbs& c, const Text&, const CurveNames& names, OpenscadNeeds& needs) {
  needs.library = true;
  return {"each nurbs_curve(" + std::to_string(c.degree) + ", " + list_text(c.knots) + ", " + names.at(&c) + ", " +
              (c.weights.empty() ? "" : "weights = " + list_text(c.weights) + ", ") + "error = chord_error / 2)",
          remark_of(c.name, c.edge)};
}

/// Where an element begins and ends at present.
std::array<Vec2, 2> ends_of(const SketchElement& element, const Text& text) {
  if (const auto* p = std::get_if<SketchPoint>(&element)) {
    const Vec2 at(text.value(p->x), text.value(p->y));
    return {at, at};
  }
  const auto* a = std::get_if<SketchArc>(&element);
  ensure(a != nullptr, "a drafted sketch is made of points and arcs");
  auto at = [&](const Expr& angle) -> Vec2 {
    return Vec2(text.value(a->center_x), text.value(a->center_y)) +
           text.value(a->radius) * Vec2(std::cos(text.value(angle)), std::sin(text.value(angle)));
  };
  return {at(a->from), at(a->to)};
}

/// The elements of a loop, each a row of their numbers; points in which an arc ends add nothing.
std::vector<Row> element_rows(const Loop& loop, const Text& text) {
  const std::size_t count = loop.elements.size();
  std::vector<Row> rows;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& element = loop.elements[i];
    if (const auto* p = std::get_if<SketchPoint>(&element)) {
      const Vec2 own = ends_of(element, text)[0];
      const Vec2 before = ends_of(loop.elements[(i + count - 1) % count], text)[1];
      if ((own - before).norm() <= sketch_join) {
        if (!rows.empty()) rows.back().remark = remark_of(rows.back().remark, p->edge);
        continue;
      }
      if ((own - ends_of(loop.elements[(i + 1) % count], text)[0]).norm() <= sketch_join) continue;
      rows.push_back({point_text(p->x, p->y, text), one_line(p->edge)});
    } else if (const auto* a = std::get_if<SketchArc>(&element)) {
      rows.push_back({"[" + point_text(a->center_x, a->center_y, text) + ", " + text.plain(a->radius) + ", " +
                          text.angle(a->from) + ", " + text.angle(a->to) + "]",
                      remark_of(a->name, a->edge)});
    }
  }
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) rows[i].text += ",";
  return rows;
}

/// A full turn is a circle of its own.
const SketchArc* circle_of(const Loop& loop, const Text& text) {
  if (loop.elements.size() != 1) return nullptr;
  const auto* arc = std::get_if<SketchArc>(&loop.elements[0]);
  return arc && std::abs(std::abs(text.value(arc->to) - text.value(arc->from)) - 2 * pi) < 1e-9 ? arc : nullptr;
}

/// Whether rounding could put a corner to the wrong side of the axis.
bool needs_axis_guard(const Loop& loop, const Text& text) {
  for (const auto& element : loop.elements) {
    if (const auto* p = std::get_if<SketchPoint>(&element)) {
      if (!p->x.is_number() && std::abs(text.value(p->x)) < 1e-5) return true;
    } else if (const auto* a = std::get_if<SketchArc>(&element)) {
      const double x = text.value(a->center_x), r = text.value(a->radius);
      for (const Expr* end : {&a->from, &a->to}) {
        if (std::abs(x + r * std::cos(text.value(*end))) < 1e-5) return true;
      }
    } else {
      const auto& control = std::get<SketchNurbs>(element).control;
      if (!control.front()[0].is_number() && std::abs(text.value(control.front()[0])) < 1e-5) return true;
      if (!control.back()[0].is_number() && std::abs(text.value(control.back()[0])) < 1e-5) return true;
    }
  }
  return false;
}

Result<std::string> loop_text(const Loop& loop, const std::string& role, bool about_axis, const Text& text,
                              const CurveNames& names, const TemplatePack& pack, OpenscadNeeds& needs) {
  if (const auto* circle = circle_of(loop, text)) {
    needs.disc = needs.facets = true;
    const bool centred = circle->center_x == Expr(0) && circle->center_y == Expr(0);
    return pack.render("circle.scad",
                       {{"center", centred ? "" : text.plain(circle->center_x) + ", " + text.plain(circle->center_y)},
                        {"radius", text.plain(circle->radius)},
                        {"role", role}});
  }
  std::vector<Row> rows;
  for (std::size_t i = 0; i < loop.elements.size(); ++i) {
    rows.push_back(std::visit([&](const auto& e) { return row_of(e, text, names, needs); }, loop.elements[i]));
    if (i + 1 < loop.elements.size()) rows.back().text += ",";
  }
  const std::string lines = aligned(rows);
  const bool guard = about_axis && needs_axis_guard(loop, text);
  if (guard) needs.on_axis = true;
  return pack.render("polygon.scad",
                     {{"rows", lines}, {"role", role}, {"open", guard ? "on_axis(" : ""}, {"close", guard ? ")" : ""}});
}

/// An expression for the largest first coordinate of a loop.
std::string largest_radius(const Loop& loop, const Text& text, const CurveNames& names) {
  double largest = -1;
  std::string winner;
  auto consider = [&](double radius, const std::string& expression) {
    if (radius > largest + 1e-9) {
      largest = radius;
      winner = expression;
    }
  };
  auto consider_expr = [&](const Expr& radius) { consider(text.value(radius), text.plain(radius)); };
  for (const auto& element : loop.elements) {
    if (const auto* p = std::get_if<SketchPoint>(&element)) consider_expr(p->x);
    if (const auto* c = std::get_if<SketchNurbs>(&element)) {
      double most = 0;
      for (const auto& control : c->control) most = std::max(most, text.value(control[0]));
      consider(most, "max([for (p = " + names.at(c) + ") p.x])");
    }
    if (const auto* a = std::get_if<SketchArc>(&element)) {
      const double low = std::min(text.value(a->from), text.value(a->to)),
                   high = std::max(text.value(a->from), text.value(a->to));
      // The arc's easternmost point, or its farther end.
      const bool east = std::floor(high / (2 * pi) + 1e-12) >= std::ceil(low / (2 * pi) - 1e-12);
      if (east) {
        // The centre of a fillet often is written as edge - radius.
        const bool from_edge = a->center_x.kind == Expr::Kind::subtract && a->center_x.arguments[1] == a->radius;
        consider_expr(from_edge ? a->center_x.arguments[0] : a->center_x + a->radius);
      } else {
        const bool first = std::cos(text.value(a->from)) > std::cos(text.value(a->to));
        consider_expr(a->center_x + a->radius * Expr::call(Expr::Kind::cos, {first ? a->from : a->to}));
      }
    }
  }
  return winner;
}

}  // namespace

Result<OpenscadSketch> openscad_sketch(const Sketch& sketch, const std::string& name, bool about_axis, const Text& text,
                                       const TemplatePack& pack, OpenscadNeeds& needs) {
  const CurveNames names = curve_names(sketch, name, text);
  TemplateRecord data{{"name", name}, {"single", TemplateList{}}, {"several", TemplateList{}}};
  const bool several = sketch.loops.size() > 1;
  std::string outer, holes, tables;
  for (std::size_t i = 0; i < sketch.loops.size(); ++i) {
    const Loop& loop = sketch.loops[i];
    for (const auto& element : loop.elements) {
      if (const auto* curve = std::get_if<SketchNurbs>(&element))
        tables += control_table(*curve, names.at(curve), text);
    }
    auto written = loop_text(loop, several ? one_line(loop.name) : "", about_axis, text, names, pack, needs);
    if (!written.ok()) return written.error();
    (i == 0 ? outer : holes) += *written;
  }
  if (several) {
    data["several"] = TemplateList{{{"outer", outer}, {"holes", holes}}};
  } else {
    data["single"] = TemplateList{{{"loop", outer}}};
  }
  data["tables"] = tables;
  auto module = pack.render("sketch.scad", data);
  if (!module.ok()) return module.error();
  // Holes lie inside the first loop.
  return OpenscadSketch{std::move(module).value(), largest_radius(sketch.loops.front(), text, names)};
}

const SketchArc* only_circle(const Sketch& sketch, const OpenscadText& text) {
  return sketch.loops.size() == 1 ? circle_of(sketch.loops[0], text) : nullptr;
}

std::string openscad_loops(const Sketch& sketch, const OpenscadText& text) {
  std::string all;
  for (std::size_t i = 0; i < sketch.loops.size(); ++i) {
    const Loop& loop = sketch.loops[i];
    const std::string comma = i + 1 < sketch.loops.size() ? "," : "";
    const auto rows = element_rows(loop, text);
    if (!all.empty()) all += "\n";
    if (rows.size() == 1) {
      const std::string role = one_line(loop.name.empty() ? rows[0].remark : loop.name);
      all += "[" + rows[0].text + "]" + comma + (role.empty() ? "" : "  // " + role);
      continue;
    }
    std::string lines = "\n" + aligned(rows);
    for (std::size_t at = 0; (at = lines.find('\n', at)) != std::string::npos; at += 3) lines.insert(at + 1, "  ");
    all += "[" + (loop.name.empty() ? "" : "  // " + one_line(loop.name)) + lines + "\n]" + comma;
  }
  return all;
}

}  // namespace partscribe::codegen
