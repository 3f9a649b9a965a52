/// What a part weighs, how it turns and which dimensions matter, in words and as JSON (docs/analysis.schema.json).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/analyse/target.h"
#include "codegen/analysis/sensitivity.h"
#include "codegen/analysis/solve_volume.h"
#include "core/files.h"

namespace partscribe::cli {

struct TargetAnswer {
  Target target;
  std::string parameter;
  Quantity quantity = Quantity::length;
  double before = 0;  ///< the parameter's value; mm, rad
  SolvedVolume solved;
};

struct Analysis {
  std::string name, procedure;  ///< of the model
  Density density;
  bool in_scan_frame = true;
  MassProperties body;
  PrincipalMoments principal;
  double boundary_error = 0;  ///< mm, how far the exact boundary may be from the model
  bool varied = false;        ///< whether parameters were changed at all
  std::vector<Sensitivity> sensitivities;
  MassSigma sigma;
  std::optional<TargetAnswer> target;
};

/// kg
double mass_of(const Analysis& analysis);

std::string analysis_text(const Analysis& analysis);
std::string analysis_json(const Analysis& analysis, const std::vector<Path>& files);

/// "spacing 41.25 mm", with the angle in degrees.
std::string value_text(const std::string& parameter, Quantity quantity, double value);

/// One line for a wish that no value meets.
std::string out_of_reach(const TargetAnswer& answer, double density);

/// "0.12 kg", "41.3 g", "5200 mm^3": six digits.
std::string amount_text(const Target& target);

}  // namespace partscribe::cli
