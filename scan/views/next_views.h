/// Where to scan from next: what is still unseen, and which directions see most of it.
#pragma once

#include <vector>

#include "core/context.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::scan {

struct NextViewsOptions {
  int cells = 64;                 ///< along the longest side of the part; finer sees smaller gaps and takes longer
  double max_incidence = 1.0472;  ///< rad between surface and direction; beyond, a scanner returns little
  double least_overlap =
      0.3;  ///< share of a view that must be known already for its full worth: it has to be registered
  double least_gain = 0.005;  ///< share of the part's outside; views that add less are not named
  std::size_t most = 6;
};

struct NextView {
  Vec3 direction;      ///< unit, from the part to the sensor
  double gain = 0;     ///< mm^2 of the unseen border that it would see, after the views before it
  double overlap = 0;  ///< share of what it would see that was seen before
};

struct NextViews {
  std::vector<NextView> views;  ///< the best first
  double seen = 0, unseen = 0;  ///< mm^2: cells of surface, and of the border between empty and unknown space
  double hidden = 0;            ///< mm^2 of the unseen border that no direction sees
};

/// Space is empty where a view looked through it or past the part, surface where points are, else unknown. Directions
/// are tried all around; each is worth what it sees of the border of unknown space, less if too little of it is known
/// to register it (Pito 1999, Scott 2003). `scan` needs rays; nothing comes out without them.
NextViews next_views(const Scan& scan, const NextViewsOptions& options, Context& context);

}  // namespace partscribe::scan
