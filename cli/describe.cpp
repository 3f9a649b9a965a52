#include "cli/describe.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codegen/describe.h"
#include "core/number.h"
#include "verify/report/words.h"

namespace partscribe::cli {
namespace {

/// "79 faces: 49 planes, 29 cylinders, 1 free form of 200 triangles".
std::string faces_text(const TriSurface& surface) {
  std::string text;
  std::size_t count = 0;
  for (const std::string kind : {"plane", "cylinder", "cone", "sphere", "torus", ""}) {
    std::size_t of_kind = 0;
    int triangles = 0;
    for (const auto& face : surface.faces)
      if (face.surface == kind) ++of_kind, triangles += face.triangles;
    if (of_kind == 0) continue;
    count += of_kind;
    text += text.empty() ? ": " : ", ";
    if (kind.empty())
      text +=
          std::to_string(of_kind) + " free form of " + verify::counted(static_cast<std::size_t>(triangles), "triangle");
    else
      text += std::to_string(of_kind) + " " + (of_kind == 1 ? kind : kind == "torus" ? "tori" : kind + "s");
  }
  return std::to_string(count) + " faces" + text;
}

/// Shapes as people call them.
std::string noun_of(const Shape& shape) {
  const auto kind = kind_of(shape);
  if (kind == "box") return "a box";
  if (kind == "half_spaces") return "a polyhedron cut from half-spaces";
  if (kind == "ellipsoid") return "an ellipsoid";
  if (kind == "extrude")
    return std::get<Extrude>(shape).draft == Expr(0) ? "an extrusion of a sketch" : "a drafted extrusion of a sketch";
  if (kind == "superellipsoid" && !(std::get<Superellipsoid>(shape).bend == Expr(0))) return "a bent superellipsoid";
  if (kind == "revolve") return "a surface of revolution";
  if (kind == "tri_surface") {
    const auto& surface = std::get<TriSurface>(shape);
    if (!surface.faces.empty()) return "a body of " + faces_text(surface);
    return "a triangulation of " + std::to_string(surface.triangles.size()) + " triangles" +
           (surface.closed ? "" : " (an open sheet)");
  }
  if (kind == "surface_set") {
    const auto& set = std::get<SurfaceSet>(shape);
    std::size_t control = 0;
    for (const auto& patch : set.patches) control += patch.control.size();
    return "a " + std::string(set.closed ? "body" : "sheet") + " of " +
           verify::counted(set.patches.size(), "B-spline surface") + " with " +
           verify::counted(control, "control point");
  }
  if (kind == "swept_surface")
    return "what a B-spline surface with " +
           verify::counted(std::get<SweptSurface>(shape).surface.control.size(), "control point") + " passes";
  if (kind == "union") return "a union";
  if (kind == "difference") return "a body with cuts";
  if (kind == "intersection") return "an intersection";
  return "a " + std::string(kind);
}

/// Procedures as a person would prefer them: the fewer numbers one has to read, the smaller.
int plainness(const std::string& procedure) {
  constexpr std::array plain_first = {
      "sphere",   "box", "cylinder", "cone", "torus", "wedge", "fillet", "ellipsoid", "surface of revolution",
      "extrusion"};
  const auto at = std::find(plain_first.begin(), plain_first.end(), procedure);
  return static_cast<int>(at - plain_first.begin());
}

/// "an extrusion", "a box".
std::string with_article(const std::string& noun) {
  return (std::string("aeiou").find(noun.front()) != std::string::npos ? "an " : "a ") + noun;
}

/// mm, of the box around a triangulation; 0 for other shapes.
double size_of(const Model& model) {
  const auto* surface = model.objects.empty() ? nullptr : std::get_if<TriSurface>(&model.objects.back().shape);
  Box3 box;
  if (surface)
    for (const auto& v : surface->vertices) box.add(Vec3(v[0], v[1], v[2]));
  return box.empty() ? 0 : box.diagonal();
}

double shown(double value, Quantity quantity) { return quantity == Quantity::angle ? degrees(value) : value; }

/// Width in columns: every byte that is no UTF-8 continuation.
std::size_t columns(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

std::string readable(double value) {
  if (!std::isfinite(value)) return "unknown";
  if (std::abs(value) < 1e-6) return "0";
  const double step = power_of_ten_below(std::abs(value)) / 100;
  return print_number(snapped(value, std::min(step, 1.0)));
}

std::string with_sigma(double value, double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma)) return print_number(snapped(value, 1e-9));
  const double step = std::max(power_of_ten_below(sigma) / 10, 1e-12);
  return print_number(snapped(value, step)) + " ± " + print_number(snapped(sigma, step));
}

std::string procedure_text(const Model& model) {
  if (model.objects.empty()) return "nothing";
  const Object& last = model.objects.back();
  std::string text = noun_of(last.shape);
  if (model.fallback) text += ", because no procedure met " + print_number(model.tolerance) + " mm";
  if (model.objects.size() > 1) {
    text += " in " + std::to_string(model.objects.size()) + " steps: ";
    for (std::size_t i = 0; i < model.objects.size(); ++i)
      text += (i ? ", " : "") + model.objects[i].name + " (" + std::string(kind_of(model.objects[i].shape)) + ")";
  }
  return text;
}

Dimension describe(const Parameter& parameter) {
  Dimension row;
  const auto quantity = parameter.quantity;
  row.name = parameter.name;
  row.value = print_number(snapped(shown(parameter.value, quantity), 1e-10));
  row.unit = unit_of(quantity);
  row.note = parameter.note;
  if (parameter.sigma > 0) row.fitted = with_sigma(shown(parameter.fitted, quantity), shown(parameter.sigma, quantity));
  if (parameter.points > 0) row.points = std::to_string(parameter.points);
  if (parameter.nominal) {
    const auto& nominal = *parameter.nominal;
    row.nominal =
        print_number(snapped(shown(nominal.candidate, quantity), 1e-10)) +
        (nominal.series.empty() ? "" : " (" + nominal.series + ")") + ", " + readable(std::abs(nominal.z)) +
        " sigma away" +
        (nominal.probability > 0 ? ", probability " + print_number(snapped(nominal.probability, 0.001)) : "") + ": " +
        (nominal.kept ? "taken" : "not taken");
  }
  return row;
}

std::string table(const std::vector<std::vector<std::string>>& rows, const std::string& indent) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], columns(row[k]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = indent;
    for (std::size_t k = 0; k < row.size(); ++k) line += row[k] + std::string(widths[k] - columns(row[k]) + 2, ' ');
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string dimension_table(const Model& model) {
  if (model.parameters.empty()) return {};
  std::vector<std::vector<std::string>> rows = {{"dimension", "value", "", "fitted", "what it is"}};
  for (const auto& parameter : model.parameters) {
    const auto row = describe(parameter);
    rows.push_back({row.name, row.value, row.unit, row.fitted, row.note});
  }
  return table(rows);
}

std::vector<std::string> rival_lines(const Model& model) {
  std::vector<std::string> lines;
  for (const auto& rival : model.rivals)
    lines.push_back(rival.procedure + ": " +
                    (rival.meets_tolerance ? "meets the tolerance" : "does not meet the tolerance") +
                    ", off by up to " + readable(rival.deviation) + " mm, description length " +
                    readable(rival.description_length) + (rival.reason.empty() ? "" : "; " + rival.reason));
  return lines;
}

double useful_reach(double size) {
  constexpr double near = 0.03;
  return near * size;
}

const Rival* nearest_procedure(const Model& model) {
  constexpr double as_near = 1.1;  // times the least deviation
  if (!model.fallback) return nullptr;
  const double reach = useful_reach(size_of(model));
  double least = reach;
  const auto in_question = [&](const Rival& r) { return !r.meets_tolerance && r.deviation > model.tolerance; };
  for (const auto& r : model.rivals)
    if (in_question(r)) least = std::min(least, r.deviation);
  const Rival* nearest = nullptr;
  for (const auto& r : model.rivals) {
    if (!in_question(r) || r.deviation > std::min(reach, as_near * least)) continue;
    if (!nearest ||
        std::pair(plainness(r.procedure), r.deviation) < std::pair(plainness(nearest->procedure), nearest->deviation))
      nearest = &r;
  }
  return nearest;
}

std::string nearest_procedure_line(const Model& model) {
  const Rival* nearest = nearest_procedure(model);
  if (!nearest) return {};
  return "Nearest procedure: " + with_article(nearest->procedure) + ", off by up to " + readable(nearest->deviation) +
         " mm.";
}

std::string no_procedure_line(const Model& model, const std::string& asked) {
  if (!model.fallback || model.objects.empty()) return {};
  const auto nearest = std::min_element(model.rivals.begin(), model.rivals.end(),
                                        [](const Rival& a, const Rival& b) { return a.deviation < b.deviation; });
  std::string line = "No CAD procedure was found: " + (asked.empty() ? "no single extrusion or turned body describes it"
                                                                     : "no " + asked + " describes it");
  line += " within " + print_number(model.tolerance) + " mm";
  if (nearest != model.rivals.end())
    line += "; the nearest, " + with_article(nearest->procedure) + ", " +
            (nearest->deviation > model.tolerance       ? "is off by up to " + readable(nearest->deviation) + " mm"
             : nearest->reason.starts_with("refused: ") ? "was " + nearest->reason
                                                        : "is refused: " + nearest->reason);
  const auto* surface = std::get_if<TriSurface>(&model.objects.back().shape);
  if (surface && !surface->faces.empty())
    return line + ". STEP and IGES are made from " + noun_of(*surface) +
           ", with triangles where one could not be trimmed; OpenSCAD and SCL hold its " +
           std::to_string(surface->triangles.size()) + " triangles, which have no dimensions to edit.\n";
  if (std::holds_alternative<SurfaceSet>(model.objects.back().shape))
    return line + ". The files hold " + noun_of(model.objects.back().shape) + ", by which its form is edited.\n";
  return line + ". The files hold " + noun_of(model.objects.back().shape) + ", which has no dimensions to edit.\n";
}

std::string found_lines(const Model& model) {
  const auto nearest = nearest_procedure_line(model);
  return "Found: " + procedure_text(model) + ".\n" + (nearest.empty() ? "" : nearest + "\n");
}

std::string hypothesis_line(const Model& model) {
  if (!model.hypothesis) return {};
  const auto& h = *model.hypothesis;
  std::string line = "superellipsoid with half axes " + readable(h.a1) + ", " + readable(h.a2) + ", " + readable(h.a3) +
                     " mm, e1 = " + readable(h.e1) + ", e2 = " + readable(h.e2);
  if (h.taper_x != 0 || h.taper_y != 0) line += ", taper " + readable(h.taper_x) + ", " + readable(h.taper_y);
  return line + "; goodness of fit " + readable(h.gof) + " (" + readable(h.gof_mm) +
         " mm); suggests: " + (h.suggests.empty() ? "none" : h.suggests);
}

std::string explanation(const Model& model) {
  std::string text = model.name + ": " + procedure_text(model) + ".\nTolerance " + print_number(model.tolerance) +
                     " mm; " + std::to_string(model.provenance.points) + " points in " +
                     std::to_string(model.provenance.views) + " views, " + std::to_string(model.provenance.rejected) +
                     " set aside; noise " + readable(model.provenance.noise) + " mm.\n\nDimensions\n";
  for (const auto& parameter : model.parameters) {
    const auto row = describe(parameter);
    text += "  " + row.name + " = " + row.value + (row.unit.empty() ? "" : " " + row.unit) +
            (row.note.empty() ? "" : "   " + row.note) + "\n";
    if (!row.fitted.empty())
      text += "      fitted " + row.fitted + (row.points.empty() ? "" : " from " + row.points + " points") + "\n";
    if (parameter.sigma_systematic > 0 || parameter.sigma_noise > 0) {
      const double scale = parameter.quantity == Quantity::angle ? 180 / pi : 1;
      text += "      of which noise " + readable(scale * parameter.sigma_noise) + ", systematic " +
              readable(scale * parameter.sigma_systematic) + "\n";
    }
    if (!row.nominal.empty()) text += "      nominal " + row.nominal + "\n";
  }
  if (model.parameters.empty()) text += "  none: the shape has no dimension that a person would name\n";
  if (const auto line = hypothesis_line(model); !line.empty()) text += "\nHypothesis\n  " + line + "\n";
  text += "\nSteps\n";
  std::vector<std::vector<std::string>> steps = {{"step", "shape", "points", "rms", "max", "covered", "note"}};
  for (const auto& object : model.objects)
    steps.push_back({object.name, std::string(kind_of(object.shape)), std::to_string(object.evidence.points),
                     readable(object.evidence.rms), readable(object.evidence.max),
                     print_number(snapped(100 * object.evidence.covered, 1)) + " %", object.note});
  text += table(steps);
  for (const auto& u : model.unexplained)
    text += "  unexplained: " + u.reason + " (" + readable(u.area) + " mm2, " + std::to_string(u.points) + " points)\n";
  const auto rivals = rival_lines(model);
  text += "\nRivals\n";
  for (const auto& line : rivals) text += "  " + line + "\n";
  if (rivals.empty()) text += "  none were recorded\n";
  if (const auto nearest = nearest_procedure_line(model); !nearest.empty()) text += "\n" + nearest + "\n";
  return text;
}

}  // namespace partscribe::cli
