/// Temporary folders of a program that ends at once.
#pragma once

#include "core/files.h"

namespace partscribe::core {

/// Removes every TemporaryDirectory that exists now. Nothing may use one afterwards.
void remove_temporary_directories();

}  // namespace partscribe::core
