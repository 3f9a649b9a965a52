/// Densities of common materials by name.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace partscribe::codegen {

struct Material {
  std::string name;
  double density = 0;  ///< kg/m^3, of the usual grade at room temperature
};

/// In alphabetical order.
const std::vector<Material>& materials();

/// kg/m^3
std::optional<double> density_of(std::string_view material);

}  // namespace partscribe::codegen
