/// Parts that some turn lays onto themselves, all but a little: many a view could stand on another side as well.
#pragma once

#include <vector>

#include "scan/register/register_search.h"

namespace partscribe::scan {

/// A turn that lays most of the placed surfaces onto themselves.
struct AlikeTurn {
  Pose turn;  ///< world_from_world
  std::vector<std::size_t>
      open;  ///< views that lie as well if they, alone or with some others, are turned by it: nothing tells
};

/// What the views say of the turns after which the part looks alike.
struct AlikeSides {
  std::vector<AlikeTurn> turns;
  std::vector<Pose>
      better;  ///< poses of all views on the sides where clearly less speaks against them; empty if nothing is better

  bool any_open() const;
};

/// For parts that look alike from two or more sides: compares the present arrangement of the views on these sides with
/// the others. The evidence is the places that one view measured where another saw through, saw nothing, or measured
/// another surface; places beside creases do not count. Pairs of views that change sides together say the same in both.
/// A part that may be turned continuously (round about an axis) is not meant: that is a free motion. `poses`:
/// world_from_view; `views` are those that are placed, of which the first stays.
AlikeSides alike_sides(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                       const std::vector<std::size_t>& views, Context& context);

/// Whether a motion lays the surface of placed views onto itself as far as they tell; the far side may be unseen.
bool alike_after(const Placement& placement, const Pose& motion);

}  // namespace partscribe::scan
