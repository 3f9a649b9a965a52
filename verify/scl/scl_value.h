/// What a statement of an Alpha_1 procedure can be worth.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "verify/scl/scl_geometry.h"

namespace partscribe::verify {

struct SclValue;
using SclArray = std::shared_ptr<const std::vector<SclValue>>;

struct SclPoint {
  Vec3 at = Vec3::Zero();
  int dimension = 3;  ///< 2: z is 0 and unsaid
};
struct SclVector {
  Vec3 along = Vec3::Zero();
};

/// monostate: a statement that gives nothing.
struct SclValue {
  std::variant<std::monostate, bool, std::int64_t, double, std::string, SclPoint, SclVector, SclTransform, SclArray,
               SclGeometryPtr>
      value;
  SclValue() = default;
  template <class T>
  explicit SclValue(T v) : value(std::move(v)) {}
  template <class T>
  const T* as() const {
    return std::get_if<T>(&value);
  }
};

/// "a point", "an array", "a shell".
std::string description_of(const SclValue& value);
/// Whole and real numbers; false for anything else.
bool number_of(const SclValue& value, double& number);

}  // namespace partscribe::verify
