#include "fit/build.h"

#include <optional>

#include "fit/input/prepare.h"
#include "fit/offers.h"

namespace partscribe::fit {
namespace {

Error none_found(const Scan& scan, const ProcedureSearch& search) {
  const std::string best = search.judged.empty() ? "none was proposed"
                                                 : "nearest: " + search.judged.front().candidate.procedure + ", " +
                                                       search.judged.front().reason;
  return bad_input((scan.files.empty() ? "scan" : scan.files[0]) +
                   ": expected a procedure within tolerance of the data, found none (" + best + ")");
}

}  // namespace

Result<CheckedModel> build_model(Scan& scan, const BuildOptions& options, Context& context) {
  if (!options.force.empty() && !is_procedure(options.force))
    return usage_error("expected the name of a procedure, found '" + options.force + "'");
  context.report("normals", 0.0);
  const auto input = prepare(scan, options.tolerance, context);
  if (!input) return input.error();
  // Outliers hide procedures or bias them; but recognising them takes time and removes small and strongly curved faces.
  // A scan of which many points were rejected contains more of them; any other scan is tried as it is first.
  constexpr double many = 0.005;
  const bool littered = double(input->sampling.rejected) > many * double(scan.cloud.size());
  const std::vector<std::uint8_t> rejected = scan.cloud.rejected;
  std::vector<Attempt> attempts;
  Offers offers(scan, options, context);
  Result<bool> taken = false;
  const auto done = [&] { return !taken || *taken || context.cancelled || offers.enough(); };
  const auto search = [&](Attempt& a, bool last_resort) {
    scan.cloud.rejected = a.scan.rejected;
    search_procedure(a.search, last_resort, a.scan.input, options, context);
  };
  for (const bool without : {littered, !littered}) {
    if (done()) break;
    auto next = without ? without_outliers(scan, *input, context) : std::optional(Fitted{*input, rejected});
    if (!next) continue;
    if (!attempts.empty() && !without) next->input.outliers_left = attempts.front().scan.input.outlier_share;
    Attempt& attempt = attempts.emplace_back(Attempt{std::move(*next), {}});
    search(attempt, false);
    if (!context.cancelled && is_rough(attempt.search)) search(attempt, true);
    taken = offers.take(attempt);
  }
  for (Attempt& attempt : attempts) {
    if (done()) break;
    search(attempt, true);
    taken = offers.take(attempt);
  }
  if (context.cancelled) return Error{"cancelled", ErrorKind::stopped};
  if (!taken) return taken.error();
  if (!*taken) {
    // The scan is taken as it is, unless many points were rejected and a good part of the others are outliers.
    const bool as_it_is = attempts.size() == 2 && littered && !among_outliers(attempts.front().scan.input);
    const Attempt& rest = attempts[as_it_is ? 1 : 0];
    if (!options.triangulate) return none_found(scan, rest.search);
    taken = offers.take_mesh(rest);
    if (!taken) return taken.error();
  }
  context.report("fitted", 1.0);
  return offers.answer();
}

}  // namespace partscribe::fit
