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

/// The same patch with its whole border as trims.
TrimmedPatch with_border(const TrimmedPatch& patch);

/// What is wrong with a patch by itself, in words that follow its name; nothing if it is right.
std::optional<std::string> complaint_about(const TrimmedPatch& patch);

/// The same for a patch that is to have no trims: all of its surface counts.
std::optional<std::string> complaint_about_whole(const TrimmedPatch& patch);

/// Closed: what a whole patch passes while it moves by `direction` (mm).
std::vector<TrimmedPatch> swept(const TrimmedPatch& patch, const Vec3& direction);

/// How nearly along the surface a direction runs at worst: the smallest cosine of the angle to the normal, positive if
/// it leaves by the front everywhere, negative by the back; 0 where it does neither.
double leaving_cosine(const TrimmedPatch& patch, const Vec3& direction);

/// The image behind the plane through the origin whose normal is an axis (0 .. 2); its front stays outside.
TrimmedPatch mirrored(const TrimmedPatch& patch, int axis);

}  // namespace partscribe::model
