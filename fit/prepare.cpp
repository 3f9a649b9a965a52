#include "fit/prepare.h"

#include "core/number.h"
#include "geometry/thin.h"

namespace partscribe {

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
  input.bounds = input.cloud.bounds();
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
  return input;
}

}  // namespace partscribe
