/// Numbers of a model by their names.
#pragma once

#include <string>

#include "model/model.h"

namespace partscribe::testing {

/// -1 where there is no such parameter.
inline double value_of(const model::Model& model, const std::string& name) {
  for (const model::Parameter& p : model.parameters)
    if (p.name == name) return p.value;
  return -1;
}

}  // namespace partscribe::testing
