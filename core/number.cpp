#include "core/number.h"

#include <charconv>
#include <cmath>

#include "core/ensure.h"

namespace partscribe::core {

std::string print_number(double value) {
  ensure(std::isfinite(value), "only finite numbers can be printed");
  if (value == 0) return "0";
  char buffer[64];
  const double magnitude = std::abs(value);
  const auto format =
      (magnitude >= 1e-6 && magnitude < 1e15) ? std::chars_format::fixed : std::chars_format::scientific;
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, format).ptr;
  return std::string(buffer, end);
}

std::string print_real(double value) {
  std::string text = print_number(value);
  if (const auto e = text.find('e'); e != std::string::npos) {
    if (text.find('.') == std::string::npos) text.insert(e, ".0");
    return text;
  }
  if (text.find('.') == std::string::npos) text += ".0";
  return text;
}

std::string print_degrees(double angle) { return print_number(snapped(degrees(angle), 1e-10)); }

double snapped(double value, double resolution) {
  ensure(resolution > 0, "a resolution is positive");
  // Multiplying by the inverse of a decimal step keeps the result the double nearest to its decimal
  // text; value * 0.001 would not.
  const double inverse = std::round(1.0 / resolution);
  const double result =
      resolution < 1 ? std::round(value * inverse) / inverse : std::round(value / resolution) * resolution;
  return result == 0 ? 0.0 : result;
}

double power_of_ten_below(double limit) {
  ensure(limit > 0, "a limit is positive");
  int exponent = static_cast<int>(std::floor(std::log10(limit)));
  while (std::pow(10.0, exponent + 1) <= limit) ++exponent;
  while (std::pow(10.0, exponent) > limit) --exponent;
  return exponent >= 0 ? std::pow(10.0, exponent) : 1.0 / std::pow(10.0, -exponent);
}

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

double degrees(double angle) { return angle * (180.0 / pi); }
double radians(double angle) { return angle * (pi / 180.0); }

}  // namespace partscribe::core
