#include "fit/finish.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/refine/tidy.h"
#include "fit/search/rivals.h"
#include "fit/surface/fallback.h"

namespace partscribe::fit {
namespace {

Provenance provenance_of(const Scan& scan, const FitInput& input, const BuildOptions& options) {
  Provenance p;
  for (std::size_t i = 0; i < scan.files.size(); ++i)
    p.sources.push_back({scan.files[i], i < scan.sha256.size() ? scan.sha256[i] : ""});
  p.points = scan.cloud.size();
  // Outliers are recognised among the thinned points of the fit; each of these stands for an equal number of points of
  // the scan.
  const auto rejected = static_cast<std::size_t>(std::count(scan.cloud.rejected.begin(), scan.cloud.rejected.end(), 1));
  const std::size_t aside = input.set_aside.size(), looked_at = input.cloud.size() + aside,
                    kept = scan.cloud.size() - rejected + aside;
  p.rejected = rejected - aside + aside * kept / std::max<std::size_t>(looked_at, 1);
  p.views = static_cast<int>(scan.views.size());
  p.noise =
      input.sampling.sigma > 0 ? snapped(input.sampling.sigma, power_of_ten_below(input.sampling.sigma / 100)) : 0;
  p.spacing = input.sampling.spacing > 0
                  ? snapped(input.sampling.spacing, power_of_ten_below(input.sampling.spacing / 100))
                  : 0;
  p.unit_scale = scan.unit_scale;
  p.options = "--tolerance " + print_number(options.tolerance) + (options.nominal ? "" : " --no-nominal") +
              (options.force.empty() ? "" : " --procedure " + options.force);
  return p;
}

double rounded(double v) { return v > 0 ? snapped(v, power_of_ten_below(v / 1000)) : 0; }

/// Completes a model.
Result<CheckedModel> completed(Model model, const CandidateEvidence& found, double covered, const Attempt& attempt,
                               const std::vector<Rival>& refused, const Scan& scan, const BuildOptions& options,
                               Context& context) {
  const FitInput& input = attempt.scan.input;
  const ProcedureSearch& search = attempt.search;
  model.name = options.name;
  model.provenance = provenance_of(scan, input, options);
  model.hypothesis = search.hypothesis.hypothesis;
  Evidence& evidence = model.objects.back().evidence;
  evidence.points = input.cloud.size();
  evidence.rms = rounded(found.rms);
  evidence.max = rounded(found.local_max);
  evidence.covered = snapped(covered, 0.001);
  evidence.views = static_cast<int>(scan.views.size());
  const auto& judged = search.judged;
  const Judged* winner = search.found ? &judged.front() : nullptr;
  for (const Judged& j : judged) {
    if (&j == winner || j.refused) continue;
    model.rivals.push_back(rival_of(j, j.evidence, winner ? reason_of(*winner, j, input, context) : j.reason));
  }
  model.rivals = worth_naming(std::move(model.rivals));
  const auto put_first = [&](Rival rival) {
    if (!rival.reason.empty()) model.rivals.insert(model.rivals.begin(), std::move(rival));
  };
  if (winner) {
    const double cost = winner->evidence.total(), off = rounded(found.local_max);
    // A bent sheet is closer to the data than the winner: its numbers are the most that can be said.
    put_first({"cylinder", true, off, std::round(cost), bent_sheet(winner->candidate, input)});
    put_first(
        {"convex polyhedron", false, off, std::round(cost), open_polyhedron(winner->candidate, cost, input, context)});
  }
  for (auto rival = refused.rbegin(); rival != refused.rend(); ++rival) put_first(*rival);
  return checked(std::move(model), "the fitted model");
}

}  // namespace

Rival rival_of(const Judged& j, const CandidateEvidence& evidence, const std::string& reason) {
  return {j.candidate.procedure, j.meets, rounded(evidence.local_max), std::round(evidence.total()), reason};
}

Result<CheckedModel> finished(const Attempt& attempt, const std::vector<Rival>& refused, const Scan& scan,
                              const BuildOptions& options, Context& context) {
  const ProcedureSearch& found = attempt.search;
  return completed(found.model, found.evidence, found.covered, attempt, refused, scan, options, context);
}

namespace {

Result<CheckedModel> completed(const Fallback& fallback, const Attempt& attempt, const std::vector<Rival>& refused,
                               const Scan& scan, const BuildOptions& options, Context& context) {
  Model model = model_of(fallback.candidate, attempt.scan.input);
  const Vec3 shift = fallback.candidate.scan_from_part.translation;
  model.scan_from_part = {};
  model.scan_from_part.x = shift.x(), model.scan_from_part.y = shift.y(), model.scan_from_part.z = shift.z();
  model.fallback = options.force.empty() || !asked_for(options.force, fallback.candidate);
  return completed(std::move(model), fallback.evidence, fallback.covered, attempt, refused, scan, options, context);
}

}  // namespace

Result<std::optional<CheckedModel>> as_free_form(const Attempt& attempt, Triangulator& triangulator,
                                                 const std::vector<Rival>& refused, const Scan& scan,
                                                 const BuildOptions& options, Context& context) {
  context.report("free form", 0.65);
  const auto fallback = free_form_of(attempt.scan.input, triangulator, context);
  if (context.cancelled) return Error{"cancelled", ErrorKind::stopped};
  if (!fallback) return std::optional<CheckedModel>();
  auto model = completed(*fallback, attempt, refused, scan, options, context);
  if (!model) return model.error();
  return std::optional(std::move(*model));
}

Result<CheckedModel> triangulated(const Attempt& attempt, Triangulator& triangulator, const std::vector<Rival>& refused,
                                  const Scan& scan, const BuildOptions& options, Context& context) {
  context.report("triangulation", 0.7);
  const auto fallback = fallback_of(attempt.scan.input, triangulator, context);
  if (!fallback) return fallback.error();
  return completed(*fallback, attempt, refused, scan, options, context);
}

}  // namespace partscribe::fit
