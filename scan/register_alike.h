/// Parts that some turn lays onto themselves, all but a little: many a view could stand on the other side as well.
#pragma once

#include <vector>

#include "scan/register_search.h"

namespace partscribe {

/// A turn that lays most of the placed surfaces onto themselves, and what the views say to it.
struct AlikeTurn {
  Pose turn;                        ///< world_from_world
  std::vector<std::size_t> better;  ///< views that clearly lie better if all of these are turned by it and the others stay
  double gain = 0;                  ///< places less that then speak against it, beyond chance; 0 if `better` is empty
  std::vector<std::size_t> open;    ///< views that lie as well if they, alone or with some others, are turned by it: nothing tells
};

/// Every arrangement of the views on the two sides is held against the present one, by the places that one view measured where
/// another saw through, saw nothing or measured another surface; pairs of views on one side say the same in both. Places beside creases
/// do not count. A part that may be turned continuously (round about an axis) is not meant, that is a free motion. `poses`:
/// world_from_view; `views` are those that are placed.
std::vector<AlikeTurn> alike_turns(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses, const std::vector<std::size_t>& views,
                                   Context& context);

/// Turns the `better` views of that which gains most; where the first of `views` is one of them, all the others instead, the other way.
/// False if nothing is better.
bool to_better_side(const std::vector<AlikeTurn>& turns, const std::vector<std::size_t>& views, std::vector<Pose>& poses);

/// Whether a motion lays the surface of placed views onto itself as far as they tell; the far side may be unseen.
bool alike_after(const Placement& placement, const Pose& motion);

}  // namespace partscribe
