/// Whether the relations that a sketch names hold between its curves.
#pragma once

#include <optional>
#include <string>

#include "geometry/surfaces/curve2.h"
#include "model/shapes.h"

namespace partscribe::model {

/// What is wrong with a relation: a role that no piece has or several have, a kind that does not fit, or one that the
/// numbers contradict by more than 1e-6 (mm, rad); nothing if it holds.
std::optional<std::string> fault_of(const SketchRelation& relation, const Outline2& outline);

}  // namespace partscribe::model
