/// Views of a part that was turned about one axis: axis and steps found together.
#pragma once

#include <optional>
#include <string>

#include "scan/register/register_start.h"

namespace partscribe::scan {

struct TurntableStart {
  StartResult start;                     ///< world is the frame of the first view
  Turntable table;                       ///< with steps where they differ
  std::optional<DepthCorrection> depth;  ///< in which the poses hold; only if it was asked for
  std::string trouble;                   ///< of depths that do not fit widths, or of what was left out, in words
};

/// The line about which each view turned against the one before, in the frame that is common to all: that of the
/// sensor. With steps.
Turntable table_of(const std::vector<Pose>& first_from_view, const Vec3& near);

/// All consecutive pairs share one pure rotation, first_from_second = second_from_third = ...; it starts from features
/// and, for round parts, from the axis that the normals meet; their steps may differ if relief tells them. Fails if no
/// such rotation fits, or several do; a step of 0 is none. Of a round part only the samples that are round stay in
/// `surfaces`; of views that mostly show what stands still, such as the table, only what moves: the rest lies on itself
/// after no step at all, and says nothing of the true ones. `views` are those of `surfaces`; `contours`: as they were
/// made.
Result<TurntableStart> start_from_turntable(const std::vector<RegisterView>& views, std::vector<ViewSurface>& surfaces,
                                            bool contours, const RegisterOptions& options, Context& context);

}  // namespace partscribe::scan
