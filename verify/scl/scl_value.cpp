/// Values of Alpha_1 procedures in words, and as numbers.
#include "verify/scl/scl_value.h"

#include "core/number.h"

namespace partscribe::verify {

std::string description_of(const SclValue& value) {
  switch (value.value.index()) {
    case 0:
      return "nothing";
    case 1:
      return *value.as<bool>() ? "true" : "false";
    case 2:
      return "the number " + std::to_string(*value.as<std::int64_t>());
    case 3:
      return "the number " + print_real(*value.as<double>());
    case 4:
      return "the string \"" + value.as<std::string>()->substr(0, 40) + "\"";
    case 5:
      return "a point";
    case 6:
      return "a vector";
    case 7:
      return "a transformation";
    case 8:
      return "an array";
    default:
      return name_of(kind_of(**value.as<SclGeometryPtr>()));
  }
}

bool number_of(const SclValue& value, double& number) {
  if (const auto* n = value.as<std::int64_t>()) return number = static_cast<double>(*n), true;
  if (const auto* n = value.as<double>()) return number = *n, true;
  return false;
}

}  // namespace partscribe::verify
