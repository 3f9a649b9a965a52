/// What a part shall weigh or fill, as a user says it: "mass=0.12kg", "volume=5cm3".
#pragma once

#include <string>

#include "core/layers.h"
#include "core/result.h"

namespace partscribe::cli {

struct Target {
  bool by_mass = false;
  double wished = 0;  ///< kg or mm^3
};

/// Mass in kg or g, volume in mm3, cm3, ml, l or m3. Anything else is a usage error that shows how to write it.
Result<Target> parse_target(const std::string& text);

/// mm^3 that a body of this density (kg/m^3) has when the target is met.
double volume_for(const Target& target, double density);

/// kg/m^3 from a number or the name of a material.
struct Density {
  double density = 0;
  std::string material;  ///< empty: a number was given
};
Result<Density> parse_density(const std::string& text);

}  // namespace partscribe::cli
