#include "cli/analyse/analysis.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/describe.h"
#include "core/json_text.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;

/// A multiple of a power of ten that leaves so many digits; what is below `floor` is rounding and becomes 0.
double to_digits(double value, int digits, double floor = 0) {
  if (std::abs(value) <= floor || value == 0) return 0;
  return snapped(value, power_of_ten_below(std::abs(value)) / std::pow(10.0, digits - 1));
}

std::string digits_text(double value, double floor = 0) { return print_number(to_digits(value, 6, floor)); }

/// "5123.4 ± 0.9", or six digits where nothing is known of the deviation.
std::string sure(double value, double sigma, double floor = 0) {
  return sigma > 0 ? with_sigma(value, sigma) : digits_text(value, floor);
}

std::string quantity_unit(Quantity quantity) {
  if (quantity == Quantity::length) return "mm";
  if (quantity == Quantity::angle) return "rad";
  return quantity == Quantity::count ? "piece" : "1";
}

/// What is rounding of zero: a billionth of the part's size.
double tiny_length(const Analysis& a) { return 1e-9 * std::cbrt(a.body.volume); }

/// kg mm^2 of a body of density 1.
double inertia_scale(const Analysis& a) { return a.density.density * 1e-9; }

std::string triple_text(const Vec3& v, double floor) {
  std::string text;
  for (int k = 0; k < 3; ++k) text += (k > 0 ? ", " : "") + digits_text(v[k], floor);
  return text;
}

/// Changes to three digits: nobody needs more of a slope.
std::string slope_text(double value, double floor) { return print_number(to_digits(value, 3, floor)); }
std::string slopes_text(const Vec3& v, double floor) {
  std::string text;
  for (int k = 0; k < 3; ++k) text += (k > 0 ? ", " : "") + slope_text(v[k], floor);
  return text;
}

Json triple_json(const Vec3& v, double floor = 0) {
  return {to_digits(v.x(), 10, floor), to_digits(v.y(), 10, floor), to_digits(v.z(), 10, floor)};
}

Json matrix_json(const Mat3& m, double floor) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back(triple_json(m.row(r), floor));
  return rows;
}

/// Products of inertia that rounding left.
double tiny_inertia(const Mat3& m) { return 1e-9 * m.cwiseAbs().maxCoeff(); }

std::string mass_lines(const Analysis& a) {
  const double scale = inertia_scale(a), mass = mass_of(a);
  const bool grams = mass < 1;
  const double unit = grams ? 1000 : 1;
  const Vec3& c = a.body.centroid;
  std::string centroid;
  for (int k = 0; k < 3; ++k)
    centroid += (k > 0 ? ", " : "") +
                sure(c[k], a.sigma.centroid[k] > tiny_length(a) ? a.sigma.centroid[k] : 0, tiny_length(a));
  std::string text =
      table({{"quantity", "value", "unit"},
             {"volume", sure(a.body.volume, a.sigma.volume), "mm^3"},
             {"surface", sure(a.body.area, a.sigma.area), "mm^2"},
             {"mass", sure(unit * mass, unit * a.sigma.volume * a.density.density * 1e-9), grams ? "g" : "kg"},
             {"centroid", centroid, "mm"}});
  const Mat3 inertia = scale * a.body.inertia;
  const double tiny = tiny_inertia(inertia);
  text += "\nInertia about the centroid, kg mm^2\n";
  for (int r = 0; r < 3; ++r) text += "  " + triple_text(inertia.row(r), tiny) + "\n";
  std::vector<std::vector<std::string>> rows = {{"principal moment", "kg mm^2", "about the direction", "gyration mm"}};
  for (int k = 0; k < 3; ++k)
    rows.push_back({std::to_string(k + 1), sure(scale * a.principal.moments[k], scale * a.sigma.moments[k]),
                    triple_text(a.principal.axes.col(k), 1e-9),
                    digits_text(std::sqrt(a.principal.moments[k] / a.body.volume))});
  return text + "\n" + table(rows);
}

std::string sensitivity_lines(const Analysis& a) {
  if (!a.varied) return "";
  if (a.sensitivities.empty()) return "\nThe model has no named dimension that could be changed.\n";
  const double scale = inertia_scale(a), mass = mass_of(a);
  const bool grams = mass < 1;
  std::vector<std::vector<std::string>> rows = {{"dimension", "value", "per", grams ? "mass g" : "mass kg",
                                                 "volume mm^3", "centroid mm", "principal moments kg mm^2", ""}};
  std::string faults;
  for (const auto& s : a.sensitivities) {
    if (!s.fault.empty()) {
      faults += "  " + s.parameter + " cannot be changed alone: " + s.fault + "\n";
      continue;
    }
    const double tiny = 1e-8;  // of what 1 mm can do: below what differences of built models resolve
    rows.push_back(
        {s.parameter, print_number(to_digits(s.value, 6)), quantity_unit(s.quantity),
         slope_text((grams ? 1000 : 1) * s.change.volume * a.density.density * 1e-9, (grams ? 1000 : 1) * tiny * mass),
         slope_text(s.change.volume, tiny * a.body.volume), slopes_text(s.change.centroid, 1e-6),
         slopes_text(scale * s.moments, scale * tiny * a.principal.moments[2]),
         s.kink        ? "differs between larger and smaller"
         : s.one_sided ? "to one side only"
                       : ""});
  }
  std::string text = "\nWhat each dimension does, those that matter most first\n";
  if (rows.size() > 1) text += table(rows);
  return text + faults;
}

}  // namespace

double mass_of(const Analysis& a) { return a.body.volume * a.density.density * 1e-9; }

std::string value_text(const std::string& parameter, Quantity quantity, double value) {
  const std::string number = quantity == Quantity::angle ? print_degrees(value) : print_number(value);
  return parameter + " " + number +
         (quantity == Quantity::length  ? " mm"
          : quantity == Quantity::angle ? " degrees"
                                        : "");
}

std::string amount_text(const Target& target) {
  if (!target.by_mass) return digits_text(target.wished) + " mm^3";
  return target.wished < 1 ? digits_text(1000 * target.wished) + " g" : digits_text(target.wished) + " kg";
}

std::string out_of_reach(const TargetAnswer& answer, double density) {
  const auto amount = [&](double volume) {
    return amount_text({answer.target.by_mass, answer.target.by_mass ? volume * density * 1e-9 : volume});
  };
  const auto& s = answer.solved;
  return "--target: no value of " + answer.parameter + " gives " + amount_text(answer.target) + ": from " +
         value_text(answer.parameter, answer.quantity, to_digits(s.low, 6)) + " to " +
         value_text(answer.parameter, answer.quantity, to_digits(s.high, 6)) + " it is " + amount(s.least) + " to " +
         amount(s.most) + (s.limit.empty() ? "" : "; beyond: " + s.limit);
}

std::string analysis_text(const Analysis& a) {
  std::string text =
      a.name + ": " + a.procedure + ".\nDensity " + print_number(a.density.density) + " kg/m^3" +
      (a.density.material.empty() ? "" : " (" + a.density.material + ")") + "; places in the frame of the " +
      (a.in_scan_frame ? "scan and of the CAD files" : "part itself") +
      "; computed from the exact boundary that STEP holds" +
      (a.boundary_error > 0 ? ", which is within " + readable(a.boundary_error) + " mm of the model" : "") + ".\n\n" +
      mass_lines(a);
  if (!a.sigma.known.empty())
    text += "\n± is one standard deviation, from those of " + std::to_string(a.sigma.known.size()) +
            " dimensions, taken as independent.\n";
  text += sensitivity_lines(a);
  if (a.target) {
    const auto& t = *a.target;
    text += "\n" + amount_text(t.target) + " by " + value_text(t.parameter, t.quantity, t.solved.value) + " (was " +
            value_text(t.parameter, t.quantity, t.before) + "): the model built so has " +
            amount_text(
                {t.target.by_mass, t.target.by_mass ? t.solved.volume * a.density.density * 1e-9 : t.solved.volume}) +
            "; " + std::to_string(t.solved.builds) + " models were built.\n";
  }
  return text;
}

std::string analysis_json(const Analysis& a, const std::vector<Path>& files) {
  const double scale = inertia_scale(a), to_kg = a.density.density * 1e-9;
  Json json;
  json["model"] = a.name;
  json["units"] = {{"length", "mm"}, {"angle", "rad"}, {"mass", "kg"}, {"inertia", "kg mm^2"}, {"density", "kg/m^3"}};
  json["frame"] = a.in_scan_frame ? "scan" : "part";
  json["density"] = a.density.density;
  if (!a.density.material.empty()) json["material"] = a.density.material;
  json["boundary_error"] = a.boundary_error;
  json["volume"] = to_digits(a.body.volume, 10);
  json["area"] = to_digits(a.body.area, 10);
  json["mass"] = to_digits(mass_of(a), 10);
  json["centroid"] = triple_json(a.body.centroid, tiny_length(a));
  json["inertia"] = matrix_json(scale * a.body.inertia, scale * tiny_inertia(a.body.inertia));
  json["principal"] = Json::array();
  for (int k = 0; k < 3; ++k)
    json["principal"].push_back({{"moment", to_digits(scale * a.principal.moments[k], 10)},
                                 {"axis", triple_json(a.principal.axes.col(k), 1e-9)},
                                 {"gyration", to_digits(std::sqrt(a.principal.moments[k] / a.body.volume), 10)}});
  if (a.varied) {
    json["sigma"] = {{"volume", to_digits(a.sigma.volume, 3)},
                     {"area", to_digits(a.sigma.area, 3)},
                     {"mass", to_digits(a.sigma.volume * to_kg, 3)},
                     {"centroid", triple_json(a.sigma.centroid, tiny_length(a))},
                     {"principal", triple_json(scale * a.sigma.moments)},
                     {"parameters", a.sigma.known}};
    json["sensitivities"] = Json::array();
    for (const auto& s : a.sensitivities) {
      Json row = {
          {"parameter", s.parameter}, {"unit", quantity_unit(s.quantity)}, {"value", s.value}, {"sigma", s.sigma}};
      if (!s.fault.empty()) {
        row["fault"] = s.fault;
      } else {
        row["step"] = to_digits(s.step, 6);
        row["volume"] = to_digits(s.change.volume, 8, 1e-10 * a.body.volume);
        row["area"] = to_digits(s.change.area, 8, 1e-10 * a.body.area);
        row["mass"] = to_digits(s.change.volume * to_kg, 8, 1e-10 * mass_of(a));
        row["centroid"] = triple_json(s.change.centroid, 1e-9);
        row["inertia"] = matrix_json(scale * s.change.inertia, scale * tiny_inertia(s.change.inertia));
        row["principal"] = triple_json(scale * s.moments, 1e-10 * scale * a.principal.moments[2]);
        row["weight"] = to_digits(s.weight, 4);
        row["one_sided"] = s.one_sided;
        row["kink"] = s.kink;
      }
      json["sensitivities"].push_back(std::move(row));
    }
  }
  if (a.target) {
    const auto& t = *a.target;
    json["target"] = {{"quantity", t.target.by_mass ? "mass" : "volume"},
                      {"wished", t.target.wished},
                      {"parameter", t.parameter},
                      {"unit", quantity_unit(t.quantity)},
                      {"before", t.before},
                      {"value", t.solved.value},
                      {"volume", to_digits(t.solved.volume, 10)},
                      {"mass", to_digits(t.solved.volume * to_kg, 10)},
                      {"models", t.solved.builds}};
  }
  json["files"] = Json::array();
  for (const auto& file : files) json["files"].push_back(file.string());
  return json_text(json);
}

}  // namespace partscribe::cli
