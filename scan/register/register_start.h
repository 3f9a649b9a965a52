/// Rough poses for all views, from guesses or from nothing, each checked against what is placed already.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "scan/register/register_pair.h"

namespace partscribe::scan {

struct StartResult {
  std::vector<Pose> poses;  ///< world_from_view
  std::vector<std::uint8_t> placed;
  std::vector<std::string> reason;  ///< why a view could not be placed
  /// World motions of each view that lead, by a way that fits all along, to poses that fit as well.
  std::vector<std::vector<Pose>> joined;
  /// Views that were put on one of several sides from which those placed before look alike.
  std::vector<std::uint8_t> on_a_side;

  /// All views at these poses, placed or not.
  static StartResult at(std::vector<Pose> poses, bool placed) {
    const std::size_t n = poses.size();
    return {std::move(poses), std::vector<std::uint8_t>(n, placed), std::vector<std::string>(n),
            std::vector<std::vector<Pose>>(n), std::vector<std::uint8_t>(n, 0)};
  }
};

/// How far apart confirmed surfaces may lie along the normal once poses are good, mm.
double confirm_reach(const std::vector<ViewSurface>& surfaces);

/// One view after the other, the one that overlaps most with what is placed first, from its guess and from other starts
/// as far from it as `options` allow. A view that fits well in two clearly different places is not placed.
StartResult start_from_guesses(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                               const RegisterOptions& options, Context& context);

/// Views that were refused, each tried once more among those that are `placed` at last: what contradicted it may have
/// left since. The poses of `start` are those of now; those of the views returned, which fit, are changed.
std::vector<std::size_t> placed_after_all(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                                          const RegisterOptions& options, std::vector<std::size_t> placed,
                                          const std::vector<std::size_t>& refused, StartResult& start,
                                          Context& context);

/// Where no poses are known: three quarters. Of six views of a bracket, each of hardly more than one face, four were
/// once laid face on face where they did not belong, and agreed. Nine tenths where views were placed that could stand
/// on either side of a part: of a block two of eight were refused that spoke against one 2.8 mm off.
inline bool enough_agree(std::size_t views, std::size_t of, bool either_side) {
  return either_side ? 10 * views >= 9 * of : 4 * views >= 3 * of;
}
/// That share in words.
inline const char* enough_in_words(bool either_side) {
  return either_side ? "nine tenths of a part alike from several sides" : "three quarters";
}

/// Without guesses: every two views are compared by their features and planes, the pair that agrees best comes first,
/// then the view that agrees best with all that are placed. World is the frame of the first view that is placed.
StartResult start_from_features(const std::vector<ViewSurface>& surfaces, const RegisterOptions& options,
                                Context& context);

}  // namespace partscribe::scan
