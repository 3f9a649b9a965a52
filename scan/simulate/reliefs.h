/// Sculpted reliefs whose truth is a formula: a face mask and a hand, as range images of them would show.
///
/// They stand in for the two range images of the 1993 paper that are no longer to be had. Both look along z; mm.
#pragma once

namespace partscribe::scan {

/// A face some 140 x 190 mm wide and 60 deep, its nose at x = 0 and its forehead up (y > 0); NaN outside of its
/// outline, where it is steep. Smooth.
double face_mask_height(double x, double y);

/// The palm side of a right hand some 100 mm wide, 180 mm long from the wrist (y = 0) to the tip of the middle finger,
/// and 30 deep; NaN outside of it, between the fingers too. Smooth but where pieces meet at its rim, and where the
/// round ends of fingers begin.
double hand_height(double x, double y);

}  // namespace partscribe::scan
