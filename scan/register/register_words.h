/// How registration puts its numbers into words.
#pragma once

#include <string>

#include "core/number.h"

namespace partscribe::scan {

inline std::string in_steps(double value, double resolution) { return print_number(snapped(value, resolution)); }
inline std::string in_percent(double share) { return in_steps(100 * share, 0.1) + " %"; }
/// `angle`: rad.
inline std::string in_degrees(double angle) { return in_steps(degrees(angle), 0.1); }

}  // namespace partscribe::scan
