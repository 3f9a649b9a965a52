#include "fit/propose/best_bodies.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/evidence/evidence.h"
#include "fit/refine/refine.h"

namespace partscribe::fit {
namespace {

bool same_numbers(const Candidate& a, const Candidate& b, double tolerance) {
  return a.procedure == b.procedure &&
         std::ranges::equal(a.parameters, b.parameters, [&](const Parameter& p, const Parameter& q) {
           return std::abs(p.value - q.value) < 0.1 * tolerance;
         });
}

}  // namespace

std::vector<Candidate> best_bodies(std::vector<Candidate> bodies, const FitInput& rest, const std::string& what,
                                   Context& context) {
  constexpr std::size_t most = 3;
  struct Body {
    Candidate candidate;
    double cost;
  };
  std::vector<Body> found;
  for (Candidate& body : bodies) {
    if (context.cancelled) break;
    if (!makes_sense(body)) continue;
    RefineOptions quick;
    quick.points = 6000, quick.iterations = 25, quick.uncertainty = false;
    refine(body, rest, quick, context);
    const auto same = [&](const Body& other) { return same_numbers(body, other.candidate, rest.tolerance); };
    if (!makes_sense(body) || std::ranges::any_of(found, same)) continue;
    const CandidateEvidence evidence = evidence_of(body, rest, context);
    context.say(what + ": " + body.procedure + " off by " + millimetres(evidence.local_max, rest.tolerance));
    if (evidence.local_max <= rest.tolerance) found.push_back({std::move(body), evidence.total()});
  }
  std::ranges::stable_sort(found, {}, &Body::cost);
  if (found.size() > most) found.erase(found.begin() + most, found.end());
  std::vector<Candidate> result;
  for (Body& body : found) result.push_back(std::move(body.candidate));
  return result;
}

}  // namespace partscribe::fit
