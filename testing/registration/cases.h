/// Scans of parts that are registered in tests, and how far off the answers are.
#pragma once

#include <vector>

#include "scan/register/register.h"
#include "scan/simulate/simulate.h"
#include "testing/registration/parts.h"

namespace partscribe::testing::registration {

struct Case {
  std::vector<RegisterView> views;
  std::vector<Pose> truth;
};
/// With guesses so far off: rad, mm.
Case scan_of(const Surface& surface, SimulateOptions options, double angle, double shift);

/// One view of a part in each of several poses (scanner_from_part but for where the scanner stands), which is the same
/// as that many views of the part.
Case scan_in_poses(const Surface& surface, const std::vector<Pose>& poses, SimulateOptions options, double angle,
                   double shift);

/// Eight poses: turned from one to the next, seen from `above` (both rad).
std::vector<Pose> eight_poses(double step, double above);

/// Eight views of 72 x 72 pixels.
SimulateOptions small();

/// Registration is expected to give an answer, whatever it is.
Registration run(const std::vector<RegisterView>& views, const RegisterOptions& options = {}, int threads = 2);

/// Of views whose poses are forgotten.
Registration run_from_nothing(Case scan);

/// Largest rotation and shift off the truth, relative to the reference view; views that were said to fit in several
/// places are taken in the best of these.
struct Off {
  double angle = 0, shift = 0;
};
Off off_truth(const Registration& found, const std::vector<Pose>& truth);

int count(const Registration& registration, ViewStatus status);

}  // namespace partscribe::testing::registration
