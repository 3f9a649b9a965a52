#include "fit/propose/torus_piece.h"

#include <algorithm>

#include "core/number.h"
#include "fit/sketch/length_parameter.h"
#include "geometry/surfaces/primitive_fit.h"

namespace partscribe::fit {

Candidate torus_candidate(double major_radius, double minor_radius, const Pose& scan_from_part) {
  Candidate ring;
  ring.procedure = ring.object_name = "torus";
  ring.shape = Torus{Expr::of("major_radius"), Expr::of("minor_radius")};
  ring.parameters = {length_parameter("major_radius", major_radius, "radius of the ring's centre circle"),
                     length_parameter("minor_radius", minor_radius, "radius of the tube")};
  ring.scan_from_part = scan_from_part;
  return ring;
}

std::vector<Candidate> propose_torus_piece(const FitInput& input) {
  constexpr std::size_t most_points = 1500;
  constexpr double welsch = 2.5, least_share = 2.0 / 3, largest = 10;  // in sigmas; of the points; times what was seen
  const PointCloud& cloud = input.cloud;
  if (cloud.size() < 50 || cloud.normals.size() != cloud.size()) return {};
  std::vector<Vec3> points, normals;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / most_points);
  for (std::size_t i = 0; i < cloud.size(); i += step)
    points.push_back(cloud.points[i]), normals.push_back(cloud.normals[i]);
  const double noise = std::max(input.sampling.sigma, 0.1 * input.tolerance);
  PrimitiveFitOptions options;
  options.sigma = noise, options.robust = welsch;
  const auto fit = fit_primitive(PrimitiveKind::torus, points, normals, options);
  if (!fit || !fit->determined) return {};
  const Primitive& torus = fit->primitive;
  if (!(torus.tube > 0 && torus.tube < torus.radius && torus.radius < largest * input.bounds.diagonal())) return {};
  const double near = std::max(3 * noise, input.tolerance);
  const auto on =
      std::count_if(points.begin(), points.end(), [&](const Vec3& p) { return std::abs(distance(torus, p)) < near; });
  if (double(on) < least_share * double(points.size())) return {};
  return {torus_candidate(torus.radius, torus.tube, {rotation_onto_axis(torus.axis), torus.point})};
}

}  // namespace partscribe::fit
