#include "verify/report/words.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"

namespace partscribe::verify {

Words::Words(double tolerance) : resolution_(std::clamp(power_of_ten_below(tolerance / 5), 1e-6, 0.01)) {}

std::string Words::mm(double length) const { return shown(length, resolution_); }

std::string Words::with_sigma(double length, double sigma) const {
  const double step = sigma > 0 ? std::clamp(power_of_ten_below(sigma), 1e-6, resolution_) : resolution_;
  return shown(length, step) + " +- " + shown(std::max(sigma, step), step);
}

std::string Words::area(double mm2) const {
  const double step = mm2 >= 10 ? 1 : mm2 >= 1 ? 0.1 : 0.01;
  return shown(mm2, step);
}

std::string Words::place(const Vec3& p) const { return shown(p, std::max(resolution_, 0.01) * 10); }

std::string shown(double value, double resolution) { return print_number(snapped(value, resolution)); }

std::string shown(const Vec3& v, double resolution) {
  return "(" + shown(v.x(), resolution) + ", " + shown(v.y(), resolution) + ", " + shown(v.z(), resolution) + ")";
}

std::string percent(double share) { return shown(100 * share, 0.1) + " %"; }

std::string direction_text(const Vec3& direction) {
  const double length = direction.norm();
  if (!(length > 0)) return "no direction";
  const Vec3 d = direction / length;
  Eigen::Index axis;
  if (d.cwiseAbs().maxCoeff(&axis) > 0.985) return std::string(d[axis] > 0 ? "+" : "-") + "xyz"[axis];
  return shown(d, 0.01);
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " and ") + names[i];
  return text;
}

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace partscribe::verify
