#include "fit/surface/fallback.h"

#include <algorithm>
#include <optional>

#include "core/number.h"
#include "fit/evidence/coverage.h"
#include "fit/input/prepare.h"
#include "fit/surface/free_form.h"
#include "fit/surface/triangulate.h"
#include "geometry/mesh/handles.h"

namespace partscribe::fit {

namespace {

FitInput dense_input(const FitInput& input, Context& context) {
  FitInput dense = selection(*input.scan, input.sampling, input.tolerance, 400000);
  dense.surroundings = surroundings_of(dense, context);
  return dense;
}

}  // namespace

std::optional<Fallback> free_form_of(const FitInput& input, Triangulator& triangulator, Context& context) {
  // Followed more coarsely than this, a part has no form left.
  const double coarsest = 0.1 * input.bounds.diagonal();
  if (input.tolerance > coarsest) {
    FitInput finer = input;
    finer.tolerance = coarsest;
    return free_form_of(finer, triangulator, context);
  }
  // A mesh of planes and cylinders says more by its faces.
  if (triangulator.of_faces(input.tolerance)) return std::nullopt;
  const auto judged = [&](std::optional<Candidate> surfaces) -> std::optional<Fallback> {
    if (!surfaces || context.cancelled) return std::nullopt;
    const CandidateEvidence evidence = evidence_of(*surfaces, dense_input(input, context), context);
    context.say("free form: deviation " + millimetres(evidence.local_max, input.tolerance));
    if (!(evidence.local_max < input.tolerance)) return std::nullopt;
    // Points say nothing of a surface where none of them are.
    const Coverage coverage = coverage_of(*surfaces, input, context);
    if (coverage.contradicted > most_contradicted) {
      context.say("free form: " + print_number(snapped(100 * coverage.contradicted, 0.1)) +
                  " % of it lies off the scanned mesh");
      return std::nullopt;
    }
    return Fallback{std::move(*surfaces), evidence, coverage.covered};
  };
  if (auto sheet = judged(free_form_of_map(input, context))) return sheet;
  const auto mesh = triangulator.surface_of_data(input.tolerance);
  if (!mesh || context.cancelled) return std::nullopt;
  // Where a filling is nowhere farther off than points are apart, or than is asked, a handle may be noise as well.
  const double handle = 4 * std::max(input.tolerance, input.thin_spacing);
  return judged(free_form(without_handles(*mesh, handle), input, context));
}

Result<Fallback> fallback_of(const FitInput& input, Triangulator& triangulator, Context& context) {
  const double tolerance = input.tolerance;
  const FitInput dense = dense_input(input, context);
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
    best = Fallback{std::move(*mesh), evidence, 0};
    if (evidence.local_max < enough) break;
    const auto surface = first ? triangulator.unsimplified() : std::nullopt;
    if (!surface) continue;
    const double least = evidence_of(*surface, dense, context).local_max;
    context.say("triangulation: deviation " + millimetres(least, tolerance) + " before triangles were taken out");
    enough = std::max(enough, least + 0.1 * tolerance);
    if (evidence.local_max < enough) break;
  }
  best->covered = coverage_of(best->candidate, input, context).covered;
  return std::move(*best);
}

}  // namespace partscribe::fit
