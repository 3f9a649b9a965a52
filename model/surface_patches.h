/// The patches of a surface set as geometry knows them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/surfaces/trimmed_surface.h"
#include "model/shapes.h"

namespace partscribe::model {

/// Needs a patch without complaints.
TrimmedSurface trimmed_surface(const TrimmedPatch& patch);
std::vector<TrimmedSurface> trimmed_surfaces(const std::vector<TrimmedPatch>& patches);

TrimmedPatch trimmed_patch(const TrimmedSurface& surface, std::string name);

/// What is wrong with a patch by itself, in words that follow its name; nothing if it is right.
std::optional<std::string> complaint_about(const TrimmedPatch& patch);

/// The image behind the plane through the origin whose normal is an axis (0 .. 2); its front stays outside.
TrimmedPatch mirrored(const TrimmedPatch& patch, int axis);

}  // namespace partscribe::model
