#include "fit/surface/fallback.h"

#include <algorithm>
#include <optional>

#include "fit/input/prepare.h"
#include "fit/surface/triangulate.h"

namespace partscribe::fit {

Result<Fallback> fallback_of(const FitInput& input, Context& context) {
  const double tolerance = input.tolerance;
  FitInput dense = selection(*input.scan, input.sampling, tolerance, 400000);
  dense.surroundings = surroundings_of(dense, context);
  Triangulator triangulator(input, context);
  double enough = 0.8 * tolerance;
  std::optional<Fallback> best;
  for (const double share : {1.0, 0.5, 0.25}) {
    auto mesh = triangulator.within(share * tolerance);
    if (context.cancelled) return Error{"cancelled", ErrorKind::stopped};
    if (!mesh && best) break;
    if (!mesh) return mesh.error();
    const CandidateEvidence evidence = evidence_of(*mesh, dense, context);
    context.say("triangulation: deviation " + millimetres(evidence.local_max, tolerance));
    const bool first = !best;
    if (best && evidence.local_max > best->evidence.local_max) break;
    best = Fallback{std::move(*mesh), evidence};
    if (evidence.local_max < enough) break;
    const auto surface = first ? triangulator.unsimplified() : std::nullopt;
    if (!surface) continue;
    const double least = evidence_of(*surface, dense, context).local_max;
    context.say("triangulation: deviation " + millimetres(least, tolerance) + " before triangles were taken out");
    enough = std::max(enough, least + 0.1 * tolerance);
    if (evidence.local_max < enough) break;
  }
  return std::move(*best);
}

}  // namespace partscribe::fit
