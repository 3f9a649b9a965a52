/// The one way in which numbers become text, and the rounding that makes a value equal its text.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/layers.h"

namespace partscribe::core {

inline constexpr double pi = 3.14159265358979323846;

/// Shortest text that reads back as exactly `value`; no exponent between 1e-6 and 1e15, never "-0".
/// Infinite and undefined values are our own mistake.
std::string print_number(double value);

/// As print_number, but always with a decimal point ("12.0"), for languages that divide integers apart.
std::string print_real(double value);

/// The text of an angle in degrees; `radians` is rounded to 1e-10 degrees first, so that 45 degrees reads "45".
std::string print_degrees(double radians);

/// `value` rounded to a whole multiple of the decimal `resolution` (a power of ten, or 2 or 5 times one).
double snapped(double value, double resolution);

/// The largest power of ten that is not above `limit`.
double power_of_ten_below(double limit);

/// The number that `text` spells, whole text and finite; nothing otherwise. Ignores the locale.
std::optional<double> parse_number(std::string_view text);

double degrees(double radians);
double radians(double degrees);

}  // namespace partscribe::core
