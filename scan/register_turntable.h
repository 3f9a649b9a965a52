/// Views of a part that was turned by equal steps about one axis: axis and step found together.
#pragma once

#include <optional>

#include "scan/register_start.h"

namespace partscribe {

struct TurntableStart {
  StartResult start;  ///< world is the frame of the first view
  Turntable table;
};

/// All consecutive pairs share one pure rotation, first_from_second = second_from_third = ...; it starts from features
/// and, for round parts, from the axis that the normals meet. Nothing if no such rotation fits, or several do.
/// Of a round part only the samples that are round stay in `surfaces`.
std::optional<TurntableStart> start_from_turntable(std::vector<ViewSurface>& surfaces, const RegisterOptions& options, Context& context);

}  // namespace partscribe
