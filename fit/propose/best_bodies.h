/// The bodies that describe what a feature leaves of a scan.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// What the makers of single bodies propose for a scan.
using BodyMaker = std::function<std::vector<Candidate>(const FitInput&)>;

/// Of what is proposed for `rest`: the few within the tolerance that cost least, refined; each once. `what` says in the
/// log what they are for.
std::vector<Candidate> best_bodies(std::vector<Candidate> bodies, const FitInput& rest, const std::string& what,
                                   Context& context);

}  // namespace partscribe::fit
