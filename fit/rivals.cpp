#include "fit/rivals.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/refine.h"

namespace partscribe {
namespace {

constexpr double undecided = 2;  // sigmas

struct Measured {
  double value = 0, sigma = 0;
};

/// A length of the shape with its uncertainty; plain numbers have none.
Measured measured(const Candidate& c, const Expr& e) {
  if (!e.is_parameter()) return {e.is_number() ? e.number : 0, 0};
  for (const auto& p : c.parameters)
    if (p.name == e.parameter) return {p.fitted, p.sigma};
  return {};
}

std::string with_sigma(const Measured& m, const std::string& unit) {
  const double step = power_of_ten_below(std::max(m.sigma / 5, 1e-6));
  return print_number(snapped(m.value, step)) + " +- " + print_number(std::max(snapped(m.sigma, step), step)) + " " + unit;
}

}  // namespace

std::string told_apart_by(const Candidate& winner, Candidate rival, const FitInput& input, Context& context) {
  const bool cone = std::holds_alternative<Cylinder>(winner.shape) && std::holds_alternative<Cone>(rival.shape);
  const bool ellipsoid = std::holds_alternative<Sphere>(winner.shape) && std::holds_alternative<Ellipsoid>(rival.shape);
  if (!cone && !ellipsoid) return {};
  RefineOptions options;
  refine(rival, input, options, context);
  // The two sizes hang together, and against each other: their sigmas add up at most.
  if (cone) {
    const auto& shape = std::get<Cone>(rival.shape);
    const Measured a = measured(rival, shape.bottom_radius), b = measured(rival, shape.top_radius), h = measured(rival, shape.height);
    if (!(h.value > 0) || !(a.sigma > 0)) return {};
    const Measured angle{std::atan((a.value - b.value) / h.value) * 180 / pi, (a.sigma + b.sigma) / h.value * 180 / pi};
    if (!(std::abs(angle.value) < undecided * angle.sigma)) return {};
    return "the data cannot tell it from a cone: half angle " + with_sigma({std::abs(angle.value), angle.sigma}, "degrees");
  }
  const auto& shape = std::get<Ellipsoid>(rival.shape);
  const std::vector<Measured> radii = {measured(rival, shape.radius_x), measured(rival, shape.radius_y), measured(rival, shape.radius_z)};
  const auto less = [](const Measured& a, const Measured& b) { return a.value < b.value; };
  const Measured low = *std::min_element(radii.begin(), radii.end(), less), high = *std::max_element(radii.begin(), radii.end(), less);
  const Measured apart{high.value - low.value, low.sigma + high.sigma};
  if (!(low.sigma > 0) || !(apart.value < undecided * apart.sigma)) return {};
  return "the data cannot tell it from an ellipsoid: its half axes differ by " + with_sigma(apart, "mm");
}

}  // namespace partscribe
