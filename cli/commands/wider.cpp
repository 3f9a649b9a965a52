#include "cli/commands/wider.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"

namespace partscribe::cli {

double tolerance_that_lets(double deviation) {
  const double enough = 1.02 * deviation, step = power_of_ten_below(enough) / 10;
  return snapped(std::ceil(enough / step) * step, step);
}

std::optional<double> most_off(const Verdict& verdict) {
  std::optional<double> most;
  for (const auto& a : verdict.artifacts)
    for (const auto& f : a.findings) {
      if (f.kind == Finding::Kind::not_scanned) continue;
      if (!(f.deviation > 0)) return std::nullopt;
      most = std::max(most.value_or(0), f.deviation);
    }
  return most;
}

std::optional<Wider> wider_for(const std::string& procedure, const Verdict& verdict, double reach) {
  const auto most = most_off(verdict);
  if (verdict.verdict != Outcome::out_of_tolerance || !most || *most <= verdict.tolerance) return std::nullopt;
  const Wider wider{procedure, tolerance_that_lets(*most)};
  return wider.tolerance <= reach ? std::optional(wider) : std::nullopt;
}

Result<std::optional<Wider>> first_verified(std::vector<Wider> proposals, double reach, const WiderTrial& trial) {
  constexpr int most_trials = 3;
  const auto narrower = [](const Wider& a, const Wider& b) { return a.tolerance < b.tolerance; };
  for (int tried = 0; tried < most_trials && !proposals.empty(); ++tried) {
    const auto next = std::min_element(proposals.begin(), proposals.end(), narrower);
    const Wider wider = *next;
    std::erase_if(proposals,
                  [&](const Wider& w) { return w.procedure == wider.procedure && w.tolerance <= wider.tolerance; });
    const auto verdict = trial(wider);
    if (!verdict) return verdict.error();
    if (!*verdict) continue;
    if ((*verdict)->verdict == Outcome::verified) return std::optional(wider);
    if (auto again = wider_for(wider.procedure, **verdict, reach); again && again->tolerance > wider.tolerance)
      proposals.push_back(std::move(*again));
  }
  return std::optional<Wider>();
}

}  // namespace partscribe::cli
