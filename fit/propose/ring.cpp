#include "fit/propose/ring.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fit/propose/supertoroid.h"

namespace partscribe::fit {
namespace {

Parameter parameter(const char* name, Quantity quantity, double value, const char* note) {
  Parameter p;
  p.name = name, p.quantity = quantity, p.value = p.fitted = value, p.note = note;
  return p;
}

}  // namespace

std::vector<Candidate> propose_rings(const FitInput& input, const std::vector<Vec3>& directions, Context& context) {
  constexpr std::size_t most_axes = 2;
  const auto& cloud = input.cloud;
  if (cloud.size() < 50 || input.bounds.empty()) return {};
  std::vector<Axis> axes = revolution_axes(input, directions);
  if (axes.size() > most_axes) axes.resize(most_axes);
  for (const Vec3& d : directions) axes.push_back({input.bounds.center(), d.normalized(), 0});
  const SupertoroidFit fit = recover_supertoroid(cloud.points, axes, context);
  context.report("rings", 1);
  const double close = std::max({input.tolerance, 2 * input.sampling.sigma, 0.01 * input.bounds.diagonal()});
  if (!(fit.miss < close)) return {};
  std::vector<Candidate> result;
  const SupertoroidOf<double>& ring = fit.shape;
  const auto nearly = [](double a, double b) { return std::abs(a - b) < 0.15 * std::max(a, b); };
  if (nearly(ring.e1, 1) && nearly(ring.e2, 1) && nearly(ring.minor_radius, ring.half_height)) {
    Candidate round;  // fewer numbers first
    round.procedure = round.object_name = "torus";
    round.shape = Torus{Expr::of("major_radius"), Expr::of("minor_radius")};
    round.parameters = {
        parameter("major_radius", Quantity::length, ring.major_radius, "radius of the ring's centre circle"),
        parameter("minor_radius", Quantity::length, (ring.minor_radius + ring.half_height) / 2, "radius of the tube")};
    round.scan_from_part = fit.scan_from_shape;
    result.push_back(std::move(round));
  }
  Candidate c;
  c.procedure = "supertoroid", c.object_name = "ring_body";
  c.shape = Supertoroid{Expr::of("ring_radius"), Expr::of("tube_half_width"), Expr::of("tube_half_height"),
                        Expr::of("exponent_1"), Expr::of("exponent_2")};
  c.parameters = {parameter("ring_radius", Quantity::length, fit.shape.major_radius,
                            "radius of the ring's centre line along x and y"),
                  parameter("tube_half_width", Quantity::length, fit.shape.minor_radius, "half width of the tube"),
                  parameter("tube_half_height", Quantity::length, fit.shape.half_height, "half height of the tube"),
                  parameter("exponent_1", Quantity::ratio, fit.shape.e1, "the tube: 0.1 square, 1 round, 2 diamond"),
                  parameter("exponent_2", Quantity::ratio, fit.shape.e2, "the ring: 0.1 square, 1 round, 2 diamond")};
  c.scan_from_part = fit.scan_from_shape;
  result.push_back(std::move(c));
  return result;
}

}  // namespace partscribe::fit
