/// Pairs of views of scans with true poses, from starts ever farther off.
#pragma once

#include <string>
#include <vector>

#include "core/files.h"
#include "scan/register/register.h"

namespace partscribe::testing {

using namespace scan;

/// Two views of one part, their true poses, and a start for the second; `world_from_view` of the first is true.
struct PairCase {
  std::string name;            ///< "d3-tie-bar 2 5"
  RegisterView first, second;  ///< the second's guess is the start
  Pose truth;                  ///< of the second
  double overlap = 0;          ///< share of the second's points that the first confirms
  double start = 0;            ///< rad off
  double radius = 0;           ///< mm, of the part
  double spacing = 0;          ///< mm, of the points of the second view
};

/// The names given, or those of all folders in `folder` that hold a scan/scan.json; sorted.
std::vector<std::string> scans_in(const Path& folder, std::vector<std::string> names);

/// Up to `most` pairs in each fifth of overlap from 20 % on, each from 5, 15, 30 and 60 degrees and a twentieth of the
/// radius off. The same every time.
std::vector<PairCase> pair_cases(const Path& scan_json, const std::string& name, int most, Context& context);

/// Of one part: for overlaps of 30, 50, 70 and 90 % the eight pairs that come nearest, each from 5, 10, 20 and 30
/// degrees and a twentieth of the radius off; `overlap` is the one asked for. The same every time.
std::vector<PairCase> basin_cases(const Path& scan_json, Context& context);

/// Of the points of the second view where they truly are, in the world.
Vec3 true_middle(const PairCase& pair);

/// How far a pose of the second view is off, at the middle of its points, once the motions that were declared free are
/// followed to where it comes nearest.
struct PairError {
  double angle = 0, shift = 0;  ///< rad, mm
};
PairError pair_error(const PairCase& pair, const Pose& first_from_second, const std::vector<FreeMotion>& free);

/// Within one degree and 2 % of the radius.
bool is_right(const PairCase& pair, const PairError& error);

/// Degrees from the truth to the start, rounded.
int degrees_off(const PairCase& pair);

}  // namespace partscribe::testing
