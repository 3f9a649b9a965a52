#include "codegen/analysis/density.h"

#include "core/layers.h"

namespace partscribe::codegen {

const std::vector<Material>& materials() {
  static const std::vector<Material> all = {
      {"abs", 1040},       {"aluminium", 2700}, {"brass", 8500},     {"bronze", 8800},
      {"cast_iron", 7200}, {"copper", 8960},    {"magnesium", 1800}, {"nylon", 1140},
      {"petg", 1270},      {"pla", 1240},       {"pom", 1410},       {"stainless", 7900},
      {"steel", 7850},     {"titanium", 4430},  {"water", 1000},     {"zinc", 6700},
  };
  return all;
}

std::optional<double> density_of(std::string_view name) {
  for (const auto& material : materials())
    if (material.name == name) return material.density;
  return std::nullopt;
}

}  // namespace partscribe::codegen
