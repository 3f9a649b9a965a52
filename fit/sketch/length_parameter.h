/// A length that a proposer measured.
#pragma once

#include <string>

#include "model/model.h"

namespace partscribe::fit {

inline Parameter length_parameter(const std::string& name, double value, const std::string& note) {
  Parameter p;
  p.name = name, p.value = p.fitted = value, p.note = note;
  return p;
}

}  // namespace partscribe::fit
