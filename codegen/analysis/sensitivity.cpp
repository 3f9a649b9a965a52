#include "codegen/analysis/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/number.h"

namespace partscribe::codegen {
namespace {

/// A change of slope by more than this share, from one side of a value to the other, is no curvature.
constexpr double kink_share = 0.05;

/// mm: the edge of a cube of the same volume.
double edge_of_cube(const MassProperties& body) { return std::cbrt(body.volume); }

/// mm, about the centroid: the distance that all of the material may be thought to have from it.
double radius_of_gyration(const MassProperties& body) { return std::sqrt(body.inertia.trace() / (2 * body.volume)); }

double step_of(const Parameter& parameter, const MassProperties& body, const SensitivityOptions& options) {
  if (parameter.quantity == Quantity::count) return 1;
  const double size = parameter.quantity == Quantity::length ? edge_of_cube(body) : 1;
  const double value = std::abs(parameter.value);
  return options.step * (value > 1e-6 * size ? std::min(value, size) : size);
}

/// (b - a) / width
MassProperties slope(const MassProperties& a, const MassProperties& b, double width) {
  return {(b.volume - a.volume) / width, (b.area - a.area) / width, (b.centroid - a.centroid) / width,
          (b.inertia - a.inertia) / width};
}

bool is_kink(const Sensitivity& s, const MassProperties& body, double forward, double backward) {
  const double largest = std::max(std::abs(forward), std::abs(backward));
  const double size = s.quantity == Quantity::length ? edge_of_cube(body) : 1;
  return s.quantity != Quantity::count && largest > 1e-3 * body.volume / size &&
         std::abs(forward - backward) > kink_share * largest;
}

/// How much of the parameter moves the surface by about 1 mm.
double about_one_mm(const Sensitivity& s, const MassProperties& body) {
  if (s.quantity == Quantity::length || s.quantity == Quantity::count) return 1;
  return 1 / radius_of_gyration(body);
}

double weight_of(const Sensitivity& s, const MassProperties& body, const PrincipalMoments& principal) {
  const double by_moments = (s.moments.array() / principal.moments.array()).abs().maxCoeff();
  return about_one_mm(s, body) * std::max({std::abs(s.change.volume) / body.volume,
                                           s.change.centroid.norm() / radius_of_gyration(body), by_moments});
}

/// Whether the volume of a model can be had, or the reason why not.
struct Attempt {
  std::optional<MassProperties> body;
  std::string fault;
};

Result<Attempt> attempt(const CheckedModel& model, const std::string& parameter, double value, Context& context) {
  const auto changed = with_value(model, parameter, value);
  if (!changed) return Attempt{{}, changed.error().message};
  const auto body = mass_properties(*changed, context);
  if (body) return Attempt{*body, ""};
  if (body.error().kind == ErrorKind::stopped) return body.error();
  return Attempt{{}, body.error().message};
}

}  // namespace

Result<CheckedModel> with_value(const CheckedModel& model, std::string_view name, double value) {
  Model changed = *model;
  const auto found = std::find_if(changed.parameters.begin(), changed.parameters.end(),
                                  [&](const Parameter& p) { return p.name == name; });
  if (found == changed.parameters.end()) {
    std::string known;
    for (const auto& p : changed.parameters)
      if (!p.formula) known += (known.empty() ? "" : ", ") + p.name;
    return usage_error("expected a parameter of the model (" + (known.empty() ? "it has none" : known) + "), found '" +
                       std::string(name) + "'");
  }
  if (found->formula) {
    std::string from;
    visit_parameters(*found->formula, [&](const std::string& p) { from += (from.empty() ? "" : ", ") + p; });
    return usage_error("parameter '" + found->name + "' is computed from " + from + "; change those");
  }
  found->value = value;
  return checked(std::move(changed), found->name + " = " + print_number(snapped(value, 1e-6)));
}

Result<std::vector<Sensitivity>> sensitivities(const CheckedModel& model, const MassProperties& body,
                                               const SensitivityOptions& options, Context& context) {
  const PrincipalMoments principal = principal_moments(body.inertia);
  std::vector<Sensitivity> all;
  double done = 0;
  for (const Parameter& parameter : model->parameters) {
    context.report("sensitivities", done++ / static_cast<double>(model->parameters.size()));
    if (parameter.formula) continue;
    Sensitivity s;
    s.parameter = parameter.name, s.quantity = parameter.quantity;
    s.value = parameter.value, s.sigma = parameter.sigma;
    s.step = step_of(parameter, body, options);
    const auto more = attempt(model, s.parameter, s.value + s.step, context);
    if (!more) return more.error();
    const auto less = attempt(model, s.parameter, s.value - s.step, context);
    if (!less) return less.error();
    if (more->body && less->body) {
      s.change = slope(*less->body, *more->body, 2 * s.step);
      s.kink =
          is_kink(s, body, (more->body->volume - body.volume) / s.step, (body.volume - less->body->volume) / s.step);
    } else if (more->body || less->body) {
      s.one_sided = true;
      s.change = more->body ? slope(body, *more->body, s.step) : slope(*less->body, body, s.step);
    } else {
      s.fault = more->fault;
    }
    // To first order the moments about the axes as they are, which is also what they do where two are equal.
    s.moments = (principal.axes.transpose() * s.change.inertia * principal.axes).diagonal();
    s.weight = weight_of(s, body, principal);
    all.push_back(std::move(s));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Sensitivity& a, const Sensitivity& b) { return a.weight > b.weight; });
  return all;
}

MassSigma mass_sigma(const std::vector<Sensitivity>& all) {
  MassSigma sigma;
  for (const Sensitivity& s : all) {
    if (s.sigma <= 0 || !s.fault.empty()) continue;
    const double variance = s.sigma * s.sigma;
    sigma.volume += variance * s.change.volume * s.change.volume;
    sigma.area += variance * s.change.area * s.change.area;
    sigma.centroid += variance * s.change.centroid.cwiseAbs2();
    sigma.moments += variance * s.moments.cwiseAbs2();
    sigma.known.push_back(s.parameter);
  }
  sigma.volume = std::sqrt(sigma.volume), sigma.area = std::sqrt(sigma.area);
  sigma.centroid = sigma.centroid.cwiseSqrt(), sigma.moments = sigma.moments.cwiseSqrt();
  return sigma;
}

}  // namespace partscribe::codegen
