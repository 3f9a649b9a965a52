#include "fit/prepare.h"

#include "core/number.h"
#include "geometry/thin.h"

namespace partscribe {

Result<FitInput> prepare(Scan& scan, double tolerance, Context& context) {
  constexpr std::size_t wanted = 60000, least = 50;
  FitInput input;
  input.scan = &scan;
  input.tolerance = tolerance;
  const PointCloud& all = scan.cloud;
  if (all.size() < least)
    return bad_input((scan.files.empty() ? "scan" : scan.files[0]) + ": expected at least " + print_number(double(least)) + " points, found " + print_number(double(all.size())));
  input.oriented = !scan.mesh.empty() || all.rays.size() == all.size();
  input.sampling = estimate_normals(scan.cloud, {}, context);
  input.thin_spacing = spacing_for_count(all.points, all.rejected, wanted);
  const auto kept = thinned(all.points, all.rejected, input.thin_spacing);
  if (kept.size() < least)
    return bad_input((scan.files.empty() ? "scan" : scan.files[0]) + ": only " + print_number(double(kept.size())) + " points are left after outliers were set aside");
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
  if (input.thin_spacing <= 0) input.thin_spacing = input.sampling.spacing;
  return input;
}

}  // namespace partscribe
