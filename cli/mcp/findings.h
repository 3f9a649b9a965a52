/// A verdict as the next task for whoever wrote the script: what is wrong, where, by how much, on which feature.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "verify/verify.h"

namespace partscribe::cli {

/// One entry for each finding that is a fault, and for each artifact that fails without one, the worst first: artifact,
/// feature, kind, text, place, direction and deviation (mm), and the `dimensions` of the feature that are off, each
/// with what the artifact says, what the scan measures and one standard deviation of that (mm, angles in degrees).
nlohmann::ordered_json tasks_of(const Verdict& verdict);

}  // namespace partscribe::cli
