#include "codegen/describe.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/number.h"

namespace partscribe::codegen {
namespace {

/// What is shown of a fitted value: no more digits than its uncertainty and the tolerance deserve.
double resolution_of(const Parameter& p, double tolerance) {
  const bool angle = p.quantity == Quantity::angle;
  const double limit = angle ? 0.01 : tolerance / 100;
  if (p.sigma <= 0) return power_of_ten_below(limit);
  return std::min(power_of_ten_below(angle ? degrees(p.sigma) : p.sigma), power_of_ten_below(limit));
}

/// `value` to two significant digits.
std::string two_digits(double value) {
  if (value == 0) return "0";
  return print_number(snapped(value, power_of_ten_below(std::abs(value)) / 10));
}

/// `value` rounded down in precision to one significant digit.
std::string one_digit(double value) { return print_number(snapped(value, power_of_ten_below(value))); }

}  // namespace

std::string with_thousands(std::size_t count) {
  std::string text = std::to_string(count);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

std::string one_line(const std::string& text) {
  std::string result;
  for (const char c : text) result += static_cast<unsigned char>(c) < 32 || c == 127 ? ' ' : c;
  return result;
}

std::string as_title(const std::string& name) {
  std::string text = one_line(name);
  std::replace(text.begin(), text.end(), '_', ' ');
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::vector<std::string> header_lines(const Model& model) {
  std::vector<std::string> lines;
  const Object& part = model.objects.back();
  lines.push_back(as_title(model.name) + (part.note.empty() ? "" : ": " + one_line(part.note)));
  lines.push_back("");
  if (model.fallback) {
    lines.push_back(std::holds_alternative<SurfaceSet>(part.shape)
                        ? "Free form: B-spline surfaces, because no procedure met the tolerance."
                        : "A triangulation, because no procedure met the tolerance.");
    const auto* surface = std::get_if<TriSurface>(&part.shape);
    if (surface && !surface->faces.empty())
      lines.push_back("STEP and IGES files of the same model hold its " + std::to_string(surface->faces.size()) +
                      " faces as true surfaces.");
  }
  lines.push_back("Units: millimetres and degrees. Tolerance: " + print_number(model.tolerance) + " mm.");
  if (const auto quality = describe_evidence(part.evidence); !quality.empty()) lines.push_back("Fit: " + quality + ".");
  std::string sources;
  std::size_t shown = 0;
  for (const auto& source : model.provenance.sources) {
    if (++shown > 4) break;
    sources += (sources.empty() ? "" : ", ") + one_line(source.file);
  }
  if (model.provenance.sources.size() > 4) {
    sources += " and " + std::to_string(model.provenance.sources.size() - 4) + " more";
  }
  if (!sources.empty()) lines.push_back("Source: " + sources + ".");
  lines.push_back("Written by " + one_line(model.provenance.program) +
                  (model.provenance.version.empty() ? "" : " " + one_line(model.provenance.version)) + ".");
  return lines;
}

std::string describe_evidence(const Evidence& evidence) {
  if (evidence.points == 0) return {};
  std::string text = "rms " + two_digits(evidence.rms) + " mm from " + with_thousands(evidence.points) +
                     " points, local mean within " + two_digits(evidence.max) + " mm";
  if (evidence.covered > 0) {
    text += ", " + print_number(std::round(100 * std::min(evidence.covered, 1.0))) + " % of its surface scanned";
  }
  return text;
}

std::string describe_fit(const Parameter& p, double tolerance) {
  if (p.sigma <= 0) return {};
  const double resolution = resolution_of(p, tolerance);
  const bool angle = p.quantity == Quantity::angle;
  const double fitted = angle ? degrees(p.fitted) : p.fitted;
  const double sigma = angle ? degrees(p.sigma) : p.sigma;
  std::string text = "fitted " + print_number(snapped(fitted, resolution)) + " +/- " + one_digit(sigma);
  if (p.points > 0) text += " from " + with_thousands(p.points) + " points";
  if (p.nominal) {
    const std::string series = p.nominal->series.empty() ? "" : one_line(p.nominal->series) + ", ";
    text += "; nominal " + value_text(p.quantity, p.nominal->candidate) + (p.nominal->kept ? "" : " refused") + " (" +
            series + "z = " + print_number(snapped(p.nominal->z, 0.1)) + ")";
  }
  return text;
}

std::string unit_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::length:
      return "mm";
    case Quantity::angle:
      return "deg";
    case Quantity::count:
    case Quantity::ratio:
      return {};
  }
  return {};
}

std::string value_text(Quantity quantity, double value) {
  return quantity == Quantity::angle ? print_degrees(value) : print_number(value);
}

std::optional<std::string> as_built_text(const Parameter& p, double tolerance) {
  if (p.sigma <= 0 || p.formula) return {};
  const bool angle = p.quantity == Quantity::angle;
  const double resolution = resolution_of(p, tolerance);
  const double shown = snapped(angle ? degrees(p.fitted) : p.fitted, resolution);
  const double value = angle ? degrees(p.value) : p.value;
  // Without a nominal size the value is what was fitted, rounded: there is nothing to choose between.
  const bool nominal = p.nominal && p.nominal->kept;
  const double sigma = angle ? degrees(p.sigma) : p.sigma;
  if (std::abs(shown - value) <= (nominal ? 0.75 * resolution : std::max(sigma, 0.75 * resolution))) return {};
  return print_number(shown);
}

std::vector<ParameterGroup> grouped_parameters(const Model& model) {
  std::map<std::string, std::string> group_of;
  for (const Object& object : model.objects) {
    const std::string title = as_title(object.name);
    auto visit = [&](const Expr& e) {
      visit_parameters(e, [&](const std::string& name) { group_of.emplace(name, title); });
    };
    visit_expressions(object.shape, [&](const Expr& e, Domain) { visit(e); });
    visit_expressions(object.frame, visit);
  }
  visit_expressions(model.scan_from_part, [&](const Expr& e) {
    visit_parameters(e, [&](const std::string& name) { group_of.emplace(name, "Placement"); });
  });
  // What only a formula uses belongs to what the formula gives.
  for (auto p = model.parameters.rbegin(); p != model.parameters.rend(); ++p)
    if (const auto own = group_of.find(p->name); p->formula && own != group_of.end()) {
      const std::string title = own->second;
      visit_parameters(*p->formula, [&](const std::string& name) { group_of.emplace(name, title); });
    }
  std::vector<ParameterGroup> groups;
  for (const Parameter& parameter : model.parameters) {
    const auto known = group_of.find(parameter.name);
    const std::string title = known == group_of.end() ? "Other" : known->second;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const ParameterGroup& g) { return g.title == title; });
    if (group == groups.end()) group = groups.insert(groups.end(), {title, {}});
    group->parameters.push_back(&parameter);
  }
  return groups;
}

TemplateList parameter_rows(const ParameterGroup& group, const std::vector<std::string>& statements, double tolerance) {
  std::vector<std::string> fits;
  std::size_t width = 0;
  for (std::size_t i = 0; i < statements.size(); ++i) {
    fits.push_back(describe_fit(*group.parameters[i], tolerance));
    if (!fits.back().empty()) width = std::max(width, statements[i].size());
  }
  TemplateList rows;
  for (std::size_t i = 0; i < statements.size(); ++i) {
    const Parameter& p = *group.parameters[i];
    const std::string unit = unit_of(p.quantity);
    std::string meaning = one_line(p.note);
    if (!unit.empty()) meaning += (meaning.empty() ? "[" : " [") + unit + "]";
    std::string statement = statements[i];
    if (!fits[i].empty()) statement.resize(width, ' ');
    rows.push_back({{"meaning", meaning}, {"statement", statement}, {"fit", fits[i]}});
  }
  return rows;
}

}  // namespace partscribe::codegen
