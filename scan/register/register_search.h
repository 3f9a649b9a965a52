/// The search for poses of one view against views that are placed.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "scan/register/register_pair.h"

namespace partscribe::scan {

/// A pose of one view that was found, and what speaks for it.
struct PoseCandidate {
  Pose pose;
  Agreement agreement;
};

/// Views that are placed, and against which another is judged.
struct Placement {
  const std::vector<ViewSurface>& surfaces;
  const std::vector<Pose>& poses;  ///< world_from_view
  const std::vector<std::size_t>& placed;
  double reach;  ///< mm, confirm_reach
  Creases creases = Creases::count;

  Agreement judge(std::size_t view, const Pose& pose, double factor, std::size_t samples) const {
    return agreement(surfaces, poses, view, pose, placed, factor * reach, samples, creases);
  }
};

/// All the way from one pose to the other fits as well: a free motion, not two answers.
bool connected(const Placement& placement, std::size_t view, const PoseCandidate& a, const PoseCandidate& b);

/// The best first.
void sort_by_score(std::vector<PoseCandidate>& candidates);

/// The first `most` places that are not the same within a tolerance (rad, share of the radius).
std::vector<PoseCandidate> distinct(const std::vector<PoseCandidate>& candidates, const ViewSurface& surface,
                                    double within, std::size_t most);

/// The 23 turns that lay a cube with these axes (unit, in the view's frame) onto itself, about `center`: what symmetric
/// parts are mistaken for.
std::vector<Pose> symmetric_turns(const Mat3& axes, const Pose& pose, const Vec3& center);

/// Where else a view could lie that fits at `pose`: turned as symmetric parts are mistaken, or slid.
std::vector<Pose> rivals_of(const ViewSurface& surface, const Mat3& axes, const Pose& pose);

/// The 60 turns that lay an icosahedron onto itself: every turn is within 45 degrees of one of them.
std::vector<Mat3> turns_all_round();

/// Three directions across each other: that of most normals, of most of those across it, and the third.
Mat3 main_axes(const Surfels& surfels);
/// Of a view, in its frame.
Mat3 main_axes(const ViewSurface& surface);

/// The search for poses of one view against others.
class PoseSearch {
 public:
  /// `mapped`: partners of the coarse search are looked up. Without guesses few poses are right, and these must not be
  /// missed.
  PoseSearch(const Placement& placement, std::size_t view, int threads, bool mapped);

  /// main_axes of the view.
  Mat3 axes() const;

  const Pose* guess = nullptr;               ///< where there is one
  std::function<bool(const Pose&)> too_far;  ///< from the guess

  /// Poses the view ends in from `starts`, best first, each place once. The coarse search keeps many, for what it says
  /// of a place is coarse as well. What ends there where something is `known` is left out.
  std::vector<PoseCandidate> from(const std::vector<Pose>& starts, const std::vector<PoseCandidate>& known = {}) const;

  /// Each start, and the same turn with the view laid over the middle of what both sides can see at that turn. Only if
  /// `mapped`.
  std::vector<Pose> with_places(const std::vector<Pose>& starts) const;

 private:
  /// Some of a placed view's surface, and where it was seen from.
  struct Seen {
    Surfels surfels;  // world frame
    Vec3 sight;
  };
  std::vector<Seen> seen_by_others() const;
  std::vector<PoseCandidate> families(const std::vector<PoseCandidate>& candidates) const;
  std::vector<Pose> under_way(const std::vector<Pose>& starts, AlignOptions rough) const;
  void drop_contradicted(std::vector<PoseCandidate>& found, const std::vector<PoseCandidate>& known, double more) const;
  void align(std::vector<PoseCandidate>& candidates, const Surfels& source, const PlacedModel& model,
             const AlignOptions& options, double factor, std::size_t samples) const;
  void away_from_contradiction(PoseCandidate& best, const Surfels& source, const AlignOptions& exact) const;
  void back_to_guess(PoseCandidate& best, const Surfels& source, const AlignOptions& exact) const;
  void slide(std::vector<PoseCandidate>& candidates, AlignOptions exact) const;
  bool allowed(const Pose& pose) const { return !too_far || !too_far(pose); }

  const Placement& placement_;
  std::size_t view_;
  int threads_;
  const ViewSurface& surface_;
  std::unique_ptr<PlacedModel> coarse_, fine_;
  Surfels fewer_, few_, many_;  // of the view
  std::vector<Seen> seen_;      // by the others, where there is a guess
};

}  // namespace partscribe::scan
