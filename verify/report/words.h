/// Sizes, places and directions as findings say them.
#pragma once

#include <string>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::verify {

/// Lengths are rounded to a fifth of the tolerance or finer, and at least to 0.01 mm.
class Words {
 public:
  explicit Words(double tolerance);

  std::string mm(double length) const;                        ///< "0.31"
  std::string with_sigma(double length, double sigma) const;  ///< "6.98 +- 0.01"
  std::string area(double mm2) const;                         ///< "14"
  std::string place(const Vec3& point) const;                 ///< "(10, 20, 5)"

 private:
  double resolution_;
};

/// Rounded to a multiple of `resolution`: "0.31", "(10, 20, 5)".
std::string shown(double value, double resolution);
std::string shown(const Vec3& v, double resolution);

/// "0.3 %" of a share from 0 to 1.
std::string percent(double share);

/// "+x" within 10 degrees of an axis, else the two or three components: "(0.6, 0.8, 0)".
std::string direction_text(const Vec3& direction);

/// "a, b and c".
std::string listed(const std::vector<std::string>& names);

/// "1 point", "14 points".
std::string counted(std::size_t count, const std::string& what);

}  // namespace partscribe::verify
