#include "fit/input/prepare.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/evidence/evidence.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/points/thin.h"

namespace partscribe::fit {
namespace {

/// Mean depth of the facets of curved faces, weighted by area: a fit may stay this far away from any facet.
double mean_depth(const TriangleMesh& mesh, const std::vector<double>& depths) {
  double sum = 0, curved = 0;
  for (std::size_t t = 0; t < depths.size(); ++t) {
    if (!(depths[t] > 0)) continue;
    const double size = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    sum += size * depths[t], curved += size;
  }
  return curved > 0 ? sum / curved : 0;
}

/// For points scattered over a coarse mesh.
std::vector<float> facet_depths(const TriangleMesh& mesh, const std::vector<Vec3>& points) {
  const std::vector<double> depths = chord_depths(mesh);
  const double mean = mean_depth(mesh, depths);
  const MeshDistance nearest(mesh);
  std::vector<float> result(points.size(), 0);
  nearest.for_each_closest(points, 1, Sign::none, [&](std::size_t i, const MeshHit& hit) {
    result[i] = static_cast<float>(std::max(mean, depths[hit.triangle]));
  });
  return result;
}

/// How many decimal digits a number was written with, ten at most.
int digits_of(double v) {
  constexpr int most = 10;
  if (v == 0) return 0;
  const int magnitude = int(std::floor(std::log10(std::abs(v)))) + 1;
  for (int digits = 1; digits < most; ++digits) {
    const double place = std::pow(10, digits - magnitude);
    if (std::abs(std::round(v * place) / place - v) <= 1e-14 * std::abs(v)) return digits;
  }
  return most;
}

/// mm: half of the last place of the coordinates as they stand in the file: of the digits of a text, or of single
/// precision; 0 if they are neither.
double coordinate_precision(const Scan& scan) {
  constexpr std::size_t enough = 2000;
  constexpr int single_digits = 9, drawn_digits = 4;  // a designer's sizes have few digits and are exact all the same
  const std::vector<Vec3>& points = scan.mesh.empty() ? scan.cloud.points : scan.mesh.vertices;
  const std::size_t step = std::max<std::size_t>(1, points.size() / enough);
  double largest = 0;
  int digits = 0;
  bool single = true;
  for (std::size_t i = 0; i < points.size(); i += step)
    for (int k = 0; k < 3; ++k) {
      const double v = points[i][k] / scan.unit_scale;
      if (!std::isfinite(v)) continue;
      largest = std::max(largest, std::abs(v));
      digits = std::max(digits, digits_of(v));
      single = single && std::abs(v - double(float(v))) <= 1e-15 * std::abs(v);
    }
  if (!(largest > 0)) return 0;
  const double by_bits = single ? 0.5 * std::ldexp(1.0, std::ilogb(largest) - 23) : 0;
  const bool written = digits < single_digits && (scan.mesh.empty() || digits > drawn_digits);
  const double by_digits = written ? 0.5 * std::pow(10, std::floor(std::log10(largest)) + 1 - digits) : 0;
  return scan.unit_scale * std::max(by_bits, by_digits);
}

}  // namespace

FitInput selection(const Scan& scan, const SamplingSummary& sampling, double tolerance, std::size_t wanted) {
  FitInput input;
  const PointCloud& all = scan.cloud;
  input.scan = &scan;
  input.tolerance = tolerance;
  input.sampling = sampling;
  input.oriented = !scan.mesh.empty() || all.rays.size() == all.size();
  input.thin_spacing = spacing_for_count(all.points, all.rejected, wanted);
  const auto kept = thinned(all.points, all.rejected, input.thin_spacing);
  auto copy = [&](const auto& from, auto& to) {
    if (from.size() != all.size()) return;
    to.reserve(kept.size());
    for (const auto i : kept) to.push_back(from[i]);
  };
  copy(all.points, input.cloud.points);
  copy(all.normals, input.cloud.normals);
  copy(all.rays, input.cloud.rays);
  copy(all.sigma, input.cloud.sigma);
  copy(all.view, input.cloud.view);
  if (!scan.mesh.empty() && all.size() > scan.mesh.vertices.size())
    input.facet_depth = facet_depths(scan.mesh, input.cloud.points);
  input.bounds = input.cloud.bounds();
  input.closed = !scan.mesh.empty() && topology(scan.mesh).closed();
  input.precision = coordinate_precision(scan);
  if (input.thin_spacing <= 0) input.thin_spacing = sampling.spacing;
  return input;
}

Result<FitInput> prepare(Scan& scan, double tolerance, Context& context) {
  constexpr std::size_t wanted = 60000, least = 50;
  const std::string name = scan.files.empty() ? "scan" : scan.files[0];
  if (scan.cloud.size() < least)
    return bad_input(name + ": expected at least " + print_number(double(least)) + " points, found " +
                     print_number(double(scan.cloud.size())));
  const SamplingSummary sampling = estimate_normals(scan.cloud, {}, context);
  FitInput input = selection(scan, sampling, tolerance, wanted);
  if (input.cloud.size() < least)
    return bad_input(name + ": only " + print_number(double(input.cloud.size())) +
                     " points are left after outliers were set aside");
  input.surroundings = surroundings_of(input, context);
  return input;
}

}  // namespace partscribe::fit
