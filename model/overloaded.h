/// Functions for each alternative of a variant, as one visitor: a missing one fails to compile.
#pragma once

#include "core/layers.h"

namespace partscribe::model {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace partscribe::model
