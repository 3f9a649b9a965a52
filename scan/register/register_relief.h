/// Views of a round part that turned about its axis: how far it turned is told by the small shapes on its surface.
#pragma once

#include <optional>
#include <vector>

#include "core/context.h"
#include "scan/register/round_views.h"

namespace partscribe::scan {

/// The poses, first_from_view, that lay the relief of each view onto that of the view before. Relief is the height over
/// the profile that all views share, less its mean over some millimetres around and less what stands still in all views
/// (the table, flaws of the sensor). It is shifted about and along the axis, by cells of edge `cell` (mm), to where the
/// two are most alike. `views`: all that was measured. Nothing if in any step no position is clearly better than all
/// others, as on a smooth part.
std::optional<std::vector<Pose>> poses_by_relief(const std::vector<RegisterView>& views, const RoundViews& round,
                                                 double cell, Context& context);

}  // namespace partscribe::scan
