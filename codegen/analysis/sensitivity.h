/// What a body's mass properties owe to each named parameter of its model: the model is built again with the parameter
/// a little larger, and a little smaller.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "codegen/analysis/mass.h"

namespace partscribe::codegen {

/// The model with another value of one parameter, its formulas computed anew and everything checked again. A usage
/// error if there is no such parameter, or if it follows from others by a formula.
Result<CheckedModel> with_value(const CheckedModel& model, std::string_view parameter, double value);

/// How the body changes per mm of a length, radian of an angle, one more of a count, unit of a ratio.
struct Sensitivity {
  std::string parameter;
  Quantity quantity = Quantity::length;
  double value = 0, sigma = 0;  ///< the parameter's; mm, rad or plain
  double step = 0;              ///< to either side, of the differences
  MassProperties change;        ///< per unit of the parameter
  Vec3 moments = Vec3::Zero();  ///< mm^5 per unit: of the principal moments
  /// What a change that moves the surface by about 1 mm does, as a share: the largest of volume, centroid (of the
  /// body's radius of gyration) and principal moments.
  double weight = 0;
  bool one_sided = false;  ///< the model can be built on one side of its value only
  bool kink = false;       ///< the volume grows otherwise than it shrinks: something appears or vanishes here
  std::string fault;       ///< why there are no differences; else empty
};

struct SensitivityOptions {
  /// Of the smaller of the parameter and the body's size: truncation grows with its square, rounding with its inverse.
  double step = 3e-4;
};

/// Of every parameter that is not computed from others, those that matter most first. An error only if stopped.
Result<std::vector<Sensitivity>> sensitivities(const CheckedModel& model, const MassProperties& body,
                                               const SensitivityOptions& options, Context& context);

/// One standard deviation of the mass properties, to first order from those of the parameters, which are taken as
/// independent: a model does not keep how they are correlated.
struct MassSigma {
  double volume = 0, area = 0;     ///< mm^3, mm^2
  Vec3 centroid = Vec3::Zero();    ///< mm
  Vec3 moments = Vec3::Zero();     ///< mm^5, of the principal moments
  std::vector<std::string> known;  ///< the parameters that have a sigma and count here
};

MassSigma mass_sigma(const std::vector<Sensitivity>& all);

}  // namespace partscribe::codegen
