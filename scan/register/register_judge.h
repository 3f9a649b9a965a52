/// Which views may be used where they have come to lie, and why others may not.
#pragma once

#include <vector>

#include "scan/register/register.h"
#include "scan/register/register_joint.h"

namespace partscribe::scan {

/// Fills in what the adjusted poses say of each of `used`, the views of `joint`, and refuses those that break a rule;
/// returns the others. Of two views that contradict each other both break it: those that are to blame alone leave
/// first, then the most contradicted one, and the others are to be adjusted and asked again without it.
std::vector<std::size_t> judge_views(const std::vector<ViewSurface>& surfaces, const JointResult& joint,
                                     const std::vector<std::size_t>& used, const std::vector<FreeMotion>& free_motions,
                                     const RegisterOptions& options, std::vector<RegisteredView>& views);

}  // namespace partscribe::scan
