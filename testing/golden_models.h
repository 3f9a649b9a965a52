/// One hand-made model per shape, the source of tests/golden/<part>/model.json.
#pragma once

#include <string>
#include <vector>

#include "model/model.h"

namespace partscribe::testing {

using namespace model;

std::vector<Model> golden_models();

}  // namespace partscribe::testing
