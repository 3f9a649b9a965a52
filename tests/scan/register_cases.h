/// Parts that are registered in tests, their scans, and how far off the answers are.
#pragma once

#include <vector>

#include "scan/register.h"
#include "scan/simulate.h"

namespace partscribe::registration_cases {

/// Half spaces n.p <= d; a ray meets a convex part where it enters the last of them.
struct Side {
  Vec3 normal;
  double offset;
};
Surface convex(const std::vector<Side>& sides, double reach);

/// A block with little beside its large faces: two edges and a corner are cut off.
Surface plain_block();

/// A block that nothing turns onto itself: every corner is cut differently.
Surface cut_block();

struct Ball {
  Vec3 center;
  double radius;
};
Surface union_of(const std::vector<Ball>& parts, double reach);

/// Balls grown together: creases everywhere and no two alike.
Surface balls();

Surface ball(double radius);

/// Radius 10, height 30, about z.
Surface cylinder();

/// The same with balls grown into it.
Surface drum_with(const std::vector<Ball>& bumps, const Vec3& reach);

struct Case {
  std::vector<RegisterView> views;
  std::vector<Pose> truth;
};
/// With guesses so far off: rad, mm.
Case scan_of(const Surface& surface, SimulateOptions options, double angle, double shift);

/// Eight views of 72 x 72 pixels.
SimulateOptions small();

/// Registration is expected to give an answer, whatever it is.
Registration run(const std::vector<RegisterView>& views, const RegisterOptions& options = {}, int threads = 2);

/// Of views whose poses are forgotten.
Registration run_from_nothing(Case scan);

/// Largest rotation and shift off the truth, relative to the reference view.
struct Off {
  double angle = 0, shift = 0;
};
Off off_truth(const Registration& found, const std::vector<Pose>& truth);

int count(const Registration& registration, ViewStatus status);

}  // namespace partscribe::registration_cases
