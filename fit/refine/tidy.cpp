#include "fit/refine/tidy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/number.h"
#include "fit/refine/nominal.h"

namespace partscribe::fit {
namespace {

/// A unit normal without components that move nothing by a tenth of the tolerance.
void square_up(HalfSpace& plane, const TidyOptions& options) {
  std::array<Expr*, 3> parts = {&plane.normal_x, &plane.normal_y, &plane.normal_z};
  Vec3 n;
  for (int k = 0; k < 3; ++k) {
    if (!parts[k]->is_number()) return;
    n[k] = std::abs(parts[k]->number) * options.size < options.tolerance / 10 ? 0.0 : parts[k]->number;
  }
  if (!(n.norm() > 0.5)) return;
  n.normalize();
  for (int k = 0; k < 3; ++k) *parts[k] = Expr(snapped(n[k], 1e-8));
}

/// How much a turn changes a shape.
enum class Symmetry { none, about_z, all };

Symmetry symmetry_of(const Shape& shape) {
  if (std::holds_alternative<Sphere>(shape)) return Symmetry::all;
  if (std::holds_alternative<Cylinder>(shape) || std::holds_alternative<Cone>(shape) ||
      std::holds_alternative<Torus>(shape) || std::holds_alternative<Revolve>(shape))
    return Symmetry::about_z;
  return Symmetry::none;
}

}  // namespace

void snap_parameters(Candidate& candidate, const TidyOptions& options) {
  if (auto* body = std::get_if<HalfSpaces>(&candidate.shape))
    for (auto& plane : body->planes) square_up(plane, options);
  std::vector<std::optional<NominalEvidence>> nominal(candidate.parameters.size());
  if (options.nominal) nominal = nominal_values(candidate.parameters, options.tolerance, options.size);
  for (std::size_t i = 0; i < candidate.parameters.size(); ++i) {
    auto& p = candidate.parameters[i];
    if (p.quantity == Quantity::count) continue;
    const bool angle = p.quantity == Quantity::angle;
    const double sigma = p.sigma > 0 ? p.sigma : options.tolerance;
    p.nominal = nominal[i];
    if (p.nominal && p.nominal->kept) {
      p.value = p.nominal->candidate;
    } else if (angle) {
      const double step = power_of_ten_below(std::min(degrees(sigma) / 3, 0.01));
      p.value = radians(snapped(degrees(p.fitted), std::max(step, 1e-6)));
    } else {
      const double step =
          power_of_ten_below(std::min(options.tolerance / 50, std::max(sigma / 3, options.tolerance / 1000)));
      p.value = snapped(p.fitted, p.quantity == Quantity::ratio ? std::min(step, 1e-3) : step);
    }
    // As-built and as-designed stay side by side; what lies below a hundredth of a sigma is noise in print.
    const double fine = power_of_ten_below(std::clamp(sigma / 30, 1e-9, options.tolerance / 100));
    p.fitted = angle ? radians(snapped(degrees(p.fitted),
                                       std::max(power_of_ten_below(std::max(degrees(sigma) / 30, 1e-9)), 1e-9)))
                     : snapped(p.fitted, fine);
    for (double* s : {&p.sigma, &p.sigma_noise, &p.sigma_systematic})
      if (*s > 0) *s = snapped(*s, power_of_ten_below(*s / 10));
    if (p.nominal) {
      p.nominal->z = snapped(p.nominal->z, 0.01);
      p.nominal->probability = snapped(p.nominal->probability, 0.001);
    }
  }
}

Model model_of(const Candidate& candidate, const FitInput& input) {
  Model model;
  model.tolerance = input.tolerance;
  model.parameters = candidate.parameters;
  model.objects = candidate.steps;
  const double size = std::max(input.bounds.diagonal(), 1e-9);
  const double step = power_of_ten_below(input.tolerance / 100);
  const double turn_step = std::max(power_of_ten_below(degrees(input.tolerance / 200 / size)), 1e-9);
  Mat3 rotation = candidate.scan_from_part.rotation;
  Vec3 angles = euler_from_rotation(rotation);
  const Symmetry symmetry = symmetry_of(candidate.shape);
  if (symmetry == Symmetry::all) angles = Vec3::Zero();
  if (symmetry == Symmetry::about_z) {
    const Vec3 axis = rotation.col(2);
    angles = {-std::asin(std::clamp(axis.y(), -1.0, 1.0)), std::atan2(axis.x(), axis.z()), 0};
    // A shape that points straight along y: the second turn would be about itself.
    if (std::hypot(axis.x(), axis.z()) < input.tolerance / size / 10) angles.y() = 0;
  }
  for (int k = 0; k < 3; ++k) {
    double d = degrees(angles[k]);
    // A turn that moves nothing by a tenth of the tolerance cannot be seen.
    const double right = std::round(d / 90) * 90;
    if (radians(std::abs(d - right)) * size < input.tolerance / 10) d = right;
    angles[k] = radians(snapped(d, turn_step));
  }
  Vec3 move = candidate.scan_from_part.translation;
  for (int k = 0; k < 3; ++k) move[k] = std::abs(move[k]) < input.tolerance / 20 ? 0.0 : snapped(move[k], step);
  model.scan_from_part = {move.x(), move.y(), move.z(), angles.x(), angles.y(), angles.z()};
  Object object;
  object.name = candidate.object_name;
  object.shape = candidate.shape;
  model.objects.push_back(std::move(object));
  return model;
}

}  // namespace partscribe::fit
