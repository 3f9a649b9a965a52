#include "fit/ring.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "fit/supertoroid.h"

namespace partscribe {
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
  Candidate c;
  c.procedure = "supertoroid", c.object_name = "ring_body";
  c.shape = Supertoroid{Expr::of("ring_radius"), Expr::of("tube_half_width"), Expr::of("tube_half_height"),
                        Expr::of("exponent_1"), Expr::of("exponent_2")};
  c.parameters = {parameter("ring_radius", Quantity::length, fit.shape.major_radius, "radius of the ring's centre line along x and y"),
                  parameter("tube_half_width", Quantity::length, fit.shape.minor_radius, "half width of the tube"),
                  parameter("tube_half_height", Quantity::length, fit.shape.half_height, "half height of the tube"),
                  parameter("exponent_1", Quantity::ratio, fit.shape.e1, "the tube: 0.1 square, 1 round, 2 diamond"),
                  parameter("exponent_2", Quantity::ratio, fit.shape.e2, "the ring: 0.1 square, 1 round, 2 diamond")};
  c.scan_from_part = fit.scan_from_shape;
  return {std::move(c)};
}

}  // namespace partscribe
