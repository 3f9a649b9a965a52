#include "fit/surface/piece_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/surface/border_curves.h"

namespace partscribe::fit {

Vec2 place_on(const TriangleMesh& mesh, std::span<const Vec2> places, std::size_t triangle, const Vec3& point) {
  const auto& t = mesh.triangles[triangle];
  const Vec3 a = mesh.vertices[t[0]], ab = mesh.vertices[t[1]] - a, ac = mesh.vertices[t[2]] - a, d = point - a;
  const double bb = ab.squaredNorm(), cc = ac.squaredNorm(), bc = ab.dot(ac);
  // A triangle without area has no inside: its longest edge says enough.
  const double det = std::max({bb * cc - bc * bc, 1e-9 * std::max(bb * bb, cc * cc), 1e-300});
  const double s = (cc * d.dot(ab) - bc * d.dot(ac)) / det, r = (bb * d.dot(ac) - bc * d.dot(ab)) / det;
  return places[t[0]] + s * (places[t[1]] - places[t[0]]) + r * (places[t[2]] - places[t[0]]);
}

namespace {

SplineFitOptions options_for(const FitInput& input) {
  SplineFitOptions options;
  options.tolerance = fit_share * input.tolerance;
  options.noise = input.sampling.sigma;
  return options;
}

}  // namespace

std::optional<SplineFit> fit_piece(const SplineData& data, const FitInput& input, Context& context) {
  const double tolerance = input.tolerance;
  SplineFitOptions options = options_for(input);
  options.low = Vec2::Constant(1e300), options.high = Vec2::Constant(-1e300);
  for (const Vec2& p : data.places) options.low = options.low.cwiseMin(p), options.high = options.high.cwiseMax(p);
  // A little beyond the border, which is free to move while parameters are corrected.
  const double step = power_of_ten_below(tolerance / 50),
               margin = 2 * tolerance + 0.01 * (options.high - options.low).norm();
  for (int k = 0; k < 2; ++k) {
    options.low[k] = step * std::floor((options.low[k] - margin) / step);
    options.high[k] = step * std::ceil((options.high[k] + margin) / step);
  }
  context.say("free form: " + std::to_string(data.points.size()) + " points over " +
              print_number(snapped(options.high.x() - options.low.x(), tolerance)) + " x " +
              print_number(snapped(options.high.y() - options.low.y(), tolerance)) + " mm");
  auto fit = fit_spline(data, options, context);
  if (!fit) context.say("free form: it would take too many control points");
  return fit;
}

std::optional<SplineFit> fit_piece_again(const SplineData& data, const NurbsSurface& before, double held_tolerance,
                                         const FitInput& input, Context& context) {
  SplineFitOptions options = options_for(input);
  options.held_tolerance = held_tolerance;
  return fit_spline_again(data, before, options, context);
}

void round_numbers(TrimmedSurface& trimmed, double tolerance) {
  const double step = power_of_ten_below(tolerance / 50);
  for (Vec3& p : trimmed.surface.points)
    for (int k = 0; k < 3; ++k) p[k] = snapped(p[k], step);
  for (KnotVector* t : {&trimmed.surface.u, &trimmed.surface.v})
    for (double& knot : t->knots) knot = snapped(knot, step);
  for (auto& loop : trimmed.loops)
    for (auto& trim : loop) {
      const KnotVector &u = trimmed.surface.u, &v = trimmed.surface.v;
      trim.curve = held_in(std::move(trim.curve), {u.low(), v.low()}, {u.high(), v.high()}, 0.02 * tolerance);
      for (Vec2& p : trim.curve.points)
        p = {std::clamp(snapped(p.x(), step), u.low(), u.high()), std::clamp(snapped(p.y(), step), v.low(), v.high())};
    }
}

}  // namespace partscribe::fit
