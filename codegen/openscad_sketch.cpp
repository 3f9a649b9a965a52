#include "codegen/openscad_sketch.h"

#include <algorithm>
#include <cmath>

#include "codegen/describe.h"
#include "core/number.h"

namespace partscribe {
namespace {

using Text = OpenscadText;

/// One line of a polygon's list with the remark that stands behind it.
struct Row {
  std::string text, remark;
};

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

void add_rows(const SketchPoint& p, const Text& text, OpenscadNeeds&, std::vector<Row>& rows) {
  rows.push_back({point_text(p.x, p.y, text), one_line(p.edge)});
}

void add_rows(const SketchArc& a, const Text& text, OpenscadNeeds& needs, std::vector<Row>& rows) {
  needs.arc = true;
  rows.push_back({"each arc(" + point_text(a.center_x, a.center_y, text) + ", " + text.plain(a.radius) + ", " +
                      text.angle(a.from) + ", " + text.angle(a.to) + ")",
                  remark_of(a.name, a.edge)});
}

void add_rows(const SketchNurbs& c, const Text& text, OpenscadNeeds& needs, std::vector<Row>& rows) {
  needs.library = true;
  rows.push_back({"each nurbs_curve(" + std::to_string(c.degree) + ", knots = " + list_text(c.knots) + ", control = [",
                  remark_of(c.name, c.edge)});
  for (std::size_t i = 0; i < c.control.size(); ++i) {
    rows.push_back({"  " + point_text(c.control[i][0], c.control[i][1], text) + (i + 1 < c.control.size() ? "," : ""), {}});
  }
  rows.push_back({(c.weights.empty() ? "]" : "], weights = " + list_text(c.weights)) + ", error = chord_error / 2)", {}});
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
                              const TemplatePack& pack, OpenscadNeeds& needs) {
  if (const auto* circle = circle_of(loop, text)) {
    needs.disc = needs.facets = true;
    const bool centred = circle->center_x == Expr(0) && circle->center_y == Expr(0);
    return pack.render("circle.scad", {{"center", centred ? "" : text.plain(circle->center_x) + ", " + text.plain(circle->center_y)},
                                       {"radius", text.plain(circle->radius)},
                                       {"role", role}});
  }
  std::vector<Row> rows;
  for (std::size_t i = 0; i < loop.elements.size(); ++i) {
    std::visit([&](const auto& e) { add_rows(e, text, needs, rows); }, loop.elements[i]);
    if (i + 1 < loop.elements.size()) rows.back().text += ",";
  }
  std::size_t width = 0;
  for (const Row& row : rows) {
    if (!row.remark.empty() && row.text.size() <= 70) width = std::max(width, row.text.size());
  }
  std::string lines;
  for (const Row& row : rows) {
    std::string line = row.text;
    if (!row.remark.empty()) {
      line.resize(std::max(width, line.size()), ' ');
      line += "  // " + row.remark;
    }
    lines += (lines.empty() ? "" : "\n") + line;
  }
  const bool guard = about_axis && needs_axis_guard(loop, text);
  if (guard) needs.on_axis = true;
  return pack.render("polygon.scad", {{"rows", lines}, {"role", role}, {"open", guard ? "on_axis(" : ""}, {"close", guard ? ")" : ""}});
}

}  // namespace

Result<std::string> openscad_sketch(const Sketch& sketch, const std::string& name, bool about_axis, const Text& text,
                                    const TemplatePack& pack, OpenscadNeeds& needs) {
  TemplateRecord data{{"name", name}, {"single", TemplateList{}}, {"several", TemplateList{}}};
  const bool several = sketch.loops.size() > 1;
  std::string outer, holes;
  for (std::size_t i = 0; i < sketch.loops.size(); ++i) {
    auto loop = loop_text(sketch.loops[i], several ? one_line(sketch.loops[i].name) : "", about_axis, text, pack, needs);
    if (!loop.ok()) return loop;
    (i == 0 ? outer : holes) += *loop;
  }
  if (several) {
    data["several"] = TemplateList{{{"outer", outer}, {"holes", holes}}};
  } else {
    data["single"] = TemplateList{{{"loop", outer}}};
  }
  return pack.render("sketch.scad", data);
}

std::string openscad_largest_radius(const Sketch& sketch, const Text& text) {
  double largest = -1;
  Expr winner = 0;
  auto consider = [&](const Expr& radius) {
    if (text.value(radius) > largest + 1e-9) {
      largest = text.value(radius);
      winner = radius;
    }
  };
  // Holes lie inside the first loop.
  for (const auto& element : sketch.loops.front().elements) {
    if (const auto* p = std::get_if<SketchPoint>(&element)) consider(p->x);
    if (const auto* c = std::get_if<SketchNurbs>(&element)) {
      for (const auto& control : c->control) consider(control[0]);
    }
    if (const auto* a = std::get_if<SketchArc>(&element)) {
      const double low = std::min(text.value(a->from), text.value(a->to)), high = std::max(text.value(a->from), text.value(a->to));
      // The arc's easternmost point, or its farther end: a radius just has to be no smaller than the profile.
      const bool east = std::floor(high / (2 * pi) + 1e-12) >= std::ceil(low / (2 * pi) - 1e-12);
      if (east) {
        consider(a->center_x + a->radius);
      } else {
        const bool first = std::cos(text.value(a->from)) > std::cos(text.value(a->to));
        consider(a->center_x + a->radius * Expr::call(Expr::Kind::cos, {first ? a->from : a->to}));
      }
    }
  }
  return text.plain(winner);
}

}  // namespace partscribe
