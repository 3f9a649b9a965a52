#include "cli/analyse/target.h"

#include <utility>
#include <vector>

#include "cli/suggest.h"
#include "codegen/analysis/density.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

// kg/m^3: from foams to twice the heaviest metal.
constexpr double least_density = 1, most_density = 50000;

const std::vector<std::pair<std::string, double>> masses = {{"kg", 1}, {"g", 1e-3}};
const std::vector<std::pair<std::string, double>> volumes = {
    {"mm3", 1}, {"cm3", 1e3}, {"ml", 1e3}, {"l", 1e6}, {"m3", 1e9}};

}  // namespace

Result<Target> parse_target(const std::string& text) {
  const auto wrong = [&](const std::string& why) {
    return usage_error(
        "--target: expected mass=NUMBER with kg or g, or volume=NUMBER with mm3, cm3, ml, l or m3 "
        "(mass=0.12kg), found '" +
        text + "'" + why);
  };
  const auto equals = text.find('=');
  if (equals == std::string::npos) return wrong("");
  const std::string what = text.substr(0, equals), amount = text.substr(equals + 1);
  if (what != "mass" && what != "volume") return wrong(did_you_mean(what, {"mass", "volume"}));
  const auto& units = what == "mass" ? masses : volumes;
  const auto end = amount.find_first_not_of("0123456789.+-eE");
  const std::string number = amount.substr(0, end), unit = end == std::string::npos ? "" : amount.substr(end);
  const auto value = parse_number(number);
  for (const auto& [name, scale] : units) {
    if (unit != name || !value) continue;
    // The whole range of what a body can be: a grain of sand to a ship.
    if (!(*value * scale > 1e-12 && *value * scale < 1e18)) return wrong(", which no part has");
    return Target{what == "mass", *value * scale};
  }
  return wrong(value && unit.empty() ? ": the unit is missing" : "");
}

double volume_for(const Target& target, double density) {
  return target.by_mass ? target.wished / density * 1e9 : target.wished;
}

Result<Density> parse_density(const std::string& text) {
  if (const auto known = density_of(text)) return Density{*known, text};
  const auto number = parse_number(text);
  if (number && *number >= least_density && *number <= most_density) return Density{*number, ""};
  std::vector<std::string> names;
  std::string list;
  for (const auto& material : materials()) {
    names.push_back(material.name);
    list += (list.empty() ? "" : ", ") + material.name;
  }
  return usage_error("--density: expected kg/m^3 from " + print_number(least_density) + " to " +
                     print_number(most_density) + " or one of " + list + ", found '" + text + "'" +
                     did_you_mean(text, names));
}

}  // namespace partscribe::cli
