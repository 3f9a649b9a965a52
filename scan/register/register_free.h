/// Motions of placed views that the data do not fix.
#pragma once

#include <vector>

#include "scan/register/register_joint.h"

namespace partscribe::scan {

/// What the normal matrix leaves free, and the motions (`joined`, of each view) that the search found to lead to other
/// poses as good and that are not among those; one entry for all views that move alike. `used`: the views of `joint`.
std::vector<FreeMotion> free_motions(const JointResult& joint, const std::vector<std::vector<Pose>>& joined,
                                     const std::vector<std::size_t>& used);

/// The same as the surfaces themselves say it: normals of noisy points tell the middle of a small cap to a tenth of its
/// radius only. Every view is moved a quarter of the part's size along each of its free motions and adjusted there;
/// what leads from its pose to the new one is the motion. Motions along which views do not fit as well stay as they
/// were.
std::vector<FreeMotion> followed_motions(const std::vector<ViewSurface>& surfaces, const JointResult& joint,
                                         const std::vector<std::vector<Pose>>& joined,
                                         const std::vector<std::size_t>& used, JointOptions options, Context& context);

/// Whether others looked through more of one of the views than true poses leave, or saw nothing where more of it should
/// be.
bool any_in_trouble(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                    const std::vector<std::size_t>& views);

/// Poses of views that were moved along what surfaces leave free to several of them together (each has the others for
/// it, so that alone none would move) to where clearly less contradicts them; `poses` if there is no such place.
std::vector<Pose> freed_of_contradictions(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                                          const std::vector<std::size_t>& views, bool contours, Context& context);

}  // namespace partscribe::scan
