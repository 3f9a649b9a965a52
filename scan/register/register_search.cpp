#include "scan/register/register_search.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/number.h"
#include "core/parallel.h"

namespace partscribe::scan {
namespace {

constexpr std::size_t few = 300;  // surfels of a view, for its axes and the coarse search

}  // namespace

Mat3 main_axes(const Surfels& surfels) {
  const auto most_common = [&](const auto& allowed) {
    Vec3 best = Vec3::Zero();
    std::size_t most = 0;
    for (const Vec3& n : surfels.normals) {
      if (!allowed(n)) continue;
      std::size_t like = 0;
      for (const Vec3& m : surfels.normals) like += std::abs(n.dot(m)) > 0.98;
      if (like > most) most = like, best = n;
    }
    return best;
  };
  Mat3 axes;
  axes.col(0) = most_common([](const Vec3&) { return true; });
  Vec3 second = most_common([&](const Vec3& n) { return std::abs(n.dot(axes.col(0))) < 0.2; });
  if (second.isZero()) second = axes.col(0).unitOrthogonal();
  axes.col(1) = (second - second.dot(axes.col(0)) * axes.col(0)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

bool connected(const Placement& placement, std::size_t view, const PoseCandidate& a, const PoseCandidate& b) {
  for (const double share : {0.25, 0.5, 0.75}) {
    const Pose pose = between(a.pose, b.pose, share);
    const Agreement there = placement.judge(view, pose, 2, 150);
    if (there.overlap() < 0.8 * std::min(a.agreement.overlap(), b.agreement.overlap())) return false;
    if (there.contradiction() > std::max(a.agreement.contradiction(), b.agreement.contradiction()) + 0.1) return false;
  }
  return true;
}

void sort_by_score(std::vector<PoseCandidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(), [](const PoseCandidate& a, const PoseCandidate& b) {
    return a.agreement.score() > b.agreement.score();
  });
}

std::vector<PoseCandidate> distinct(const std::vector<PoseCandidate>& candidates, const ViewSurface& surface,
                                    double within, std::size_t most) {
  std::vector<PoseCandidate> result;
  for (const PoseCandidate& c : candidates) {
    if (result.size() >= most) break;
    if (std::none_of(result.begin(), result.end(), [&](const PoseCandidate& r) {
          return same_place(surface, r.pose, c.pose, within, within * surface.radius);
        }))
      result.push_back(c);
  }
  return result;
}

std::vector<Pose> symmetric_turns(const Mat3& axes, const Pose& pose, const Vec3& center) {
  std::vector<Pose> result;
  const Mat3 world = pose.rotation * axes;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (const double a : {1.0, -1.0})
        for (const double b : {1.0, -1.0}) {
          if (i == j || (i == 0 && j == 1 && a > 0 && b > 0)) continue;
          Mat3 image;
          image << a * world.col(i), b * world.col(j), a * world.col(i).cross(b * world.col(j));
          const Mat3 turn = image * world.transpose();
          result.push_back(Pose{turn, center - turn * center} * pose);
        }
  return result;
}

std::vector<Pose> rivals_of(const ViewSurface& surface, const Mat3& axes, const Pose& pose) {
  std::vector<Pose> result = symmetric_turns(axes, pose, pose * surface.center);
  for (int axis = 0; axis < 3; ++axis)
    for (const double slide : {-1.0, -0.5, -0.25, 0.25, 0.5, 1.0})
      result.push_back(Pose{Mat3::Identity(), slide * surface.radius * (pose.rotation * axes.col(axis))} * pose);
  return result;
}

std::vector<Mat3> turns_all_round() {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  const Mat3 generators[] = {rotation_of(0.4 * pi * Vec3(0, 1, golden).normalized()),
                             rotation_of(2 * pi / 3 * Vec3::Ones().normalized())};
  std::vector<Mat3> turns{Mat3::Identity()};
  for (std::size_t k = 0; k < turns.size(); ++k)
    for (const Mat3& generator : generators) {
      const Mat3 turn = generator * turns[k];
      if (std::none_of(turns.begin(), turns.end(), [&](const Mat3& t) { return (t - turn).norm() < 0.1; }))
        turns.push_back(turn);
    }
  return turns;
}

Mat3 main_axes(const ViewSurface& surface) { return main_axes(sample_surfels(surface, few)); }

PoseSearch::PoseSearch(const Placement& placement, std::size_t view, int threads, bool mapped)
    : placement_(placement), view_(view), threads_(threads), surface_(placement.surfaces[view]) {
  coarse_ = place_surfaces(placement.surfaces, placement.poses, placement.placed,
                           std::max(surface_.radius / 12, 2 * surface_.spacing), mapped);
  fine_ = place_surfaces(placement.surfaces, placement.poses, placement.placed, 1.5 * surface_.spacing);
  few_ = sample_surfels(surface_, few), many_ = sample_surfels(surface_, 1000);
  if (mapped) fewer_ = sample_surfels(surface_, 200), seen_ = seen_by_others();
}

Mat3 PoseSearch::axes() const { return main_axes(few_); }

std::vector<PoseCandidate> PoseSearch::from(const std::vector<Pose>& starts,
                                            const std::vector<PoseCandidate>& known) const {
  AlignOptions rough;
  rough.start_reach = 0.35 * surface_.radius, rough.end_reach = coarse_->cell, rough.noise = 0.1 * coarse_->cell,
  rough.iterations = 40;
  if (guess) rough.settled = 1e-2;
  std::vector<PoseCandidate> found;
  for (const Pose& start : guess ? under_way(with_places(starts), rough) : starts) found.push_back({start, {}});
  if (guess) rough.start_reach *= 0.36;  // they come from there
  align(found, few_, *coarse_, rough, 4, 200);
  constexpr double near_known = 0.05;  // rad, share of the radius
  std::erase_if(found, [&](const PoseCandidate& c) {
    return std::any_of(known.begin(), known.end(), [&](const PoseCandidate& k) {
      return same_place(surface_, c.pose, k.pose, near_known, near_known * surface_.radius);
    });
  });
  found = distinct(found, surface_, 0.1, 32);
  constexpr double hopeless_coarse = 0.6, hopeless = 0.2;
  if (guess) drop_contradicted(found, known, hopeless_coarse);
  if (!starts.empty() && known.empty())
    found.insert(found.begin(), {starts.front(), {}});  // which may be better than coarse cells can tell
  AlignOptions exact;
  exact.start_reach = (guess ? 1 : 2) * coarse_->cell,
  exact.end_reach = std::max(1.5 * surface_.spacing, 4 * surface_.sigma),
  exact.noise = std::max(0.5 * surface_.sigma, 0.02 * surface_.spacing);
  if (guess) exact.settled = 3e-3;
  align(found, few_, *fine_, exact, 2, 400);
  found = families(distinct(found, surface_, 0.05, found.size()));
  if (guess) drop_contradicted(found, known, hopeless);
  slide(found, exact);
  exact.start_reach = exact.end_reach;
  if (guess) exact.settled = 1e-3;
  align(found, many_, *fine_, exact, 1.5, 1000);
  return found;
}

std::vector<PoseSearch::Seen> PoseSearch::seen_by_others() const {
  std::vector<Seen> others;
  for (const std::size_t o : placement_.placed) {
    const Pose& pose = placement_.poses[o];
    const ViewSurface& other = placement_.surfaces[o];
    Seen seen{sample_surfels(other, 200), pose.rotation * other.raster.ray(other.center)};
    for (Vec3& p : seen.surfels.points) p = pose * p;
    for (Vec3& n : seen.surfels.normals) n = pose.rotation * n;
    others.push_back(std::move(seen));
  }
  return others;
}

/// Where a guess is turned about is not known, so that a right turn may come with a wrong place.
std::vector<Pose> PoseSearch::with_places(const std::vector<Pose>& starts) const {
  constexpr double facing = -0.2;  // cosine to the sight of the other sensor
  std::vector<Pose> result;
  for (const Pose& start : starts) {
    result.push_back(start);
    const Vec3 sight = start.rotation * surface_.raster.ray(surface_.center);
    Vec3 own = Vec3::Zero(), theirs = Vec3::Zero();
    int own_count = 0, their_count = 0;
    for (const Seen& seen : seen_)
      for (std::size_t i = 0; i < seen.surfels.points.size(); ++i)
        if (seen.surfels.normals[i].dot(sight) < facing) theirs += seen.surfels.points[i], ++their_count;
    for (std::size_t i = 0; i < fewer_.points.size(); ++i) {
      const Vec3 n = start.rotation * fewer_.normals[i];
      if (std::any_of(seen_.begin(), seen_.end(), [&](const Seen& seen) { return n.dot(seen.sight) < facing; }))
        own += start * fewer_.points[i], ++own_count;
    }
    if (own_count < 10 || their_count < 10) continue;
    const Vec3 shift = theirs / their_count - own / own_count;
    if (shift.norm() > 0.1 * surface_.radius) result.push_back({start.rotation, start.translation + shift});
  }
  return result;
}

/// A few of each set of poses that free motions join, and a few sets.
std::vector<PoseCandidate> PoseSearch::families(const std::vector<PoseCandidate>& candidates) const {
  constexpr int most_of_one = 2;
  constexpr std::size_t most_heads = 6;
  std::vector<PoseCandidate> heads, result;
  std::vector<int> count;
  for (const PoseCandidate& c : candidates) {
    std::size_t of = 0;
    while (of < heads.size() && !connected(placement_, view_, heads[of], c)) ++of;
    if (of == heads.size()) {
      if (heads.size() == most_heads) continue;
      heads.push_back(c), count.push_back(0);
    }
    if (++count[of] <= most_of_one) result.push_back(c);
  }
  return result;
}

/// Poses after a few rounds from each start, while partners are far: where several are on their way to one place, one
/// of them.
std::vector<Pose> PoseSearch::under_way(const std::vector<Pose>& starts, AlignOptions rough) const {
  constexpr double alike = 0.05;  // rad, share of the radius
  rough.iterations = 8;
  std::vector<Pose> all(starts.size()), result;
  parallel_for(
      starts.size(), threads_,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) all[k] = align_symmetric(few_, *coarse_, starts[k], rough);
      },
      1);
  for (const Pose& pose : all)
    if (std::none_of(result.begin(), result.end(),
                     [&](const Pose& r) { return same_place(surface_, r, pose, alike, alike * surface_.radius); }))
      result.push_back(pose);
  return result;
}

/// Leaves out what is contradicted by so much more than the best place that may be taken that nothing after this would
/// make it a rival. Overlap is not asked: a right place may have a fifth of a wrong one's.
void PoseSearch::drop_contradicted(std::vector<PoseCandidate>& found, const std::vector<PoseCandidate>& known,
                                   double more) const {
  const Agreement* best = nullptr;
  for (const auto* list : {&std::as_const(known), &std::as_const(found)})
    for (const PoseCandidate& c : *list)
      if (allowed(c.pose) && (!best || c.agreement.score() > best->score())) best = &c.agreement;
  if (!best) return;
  const double most = 1.5 * best->contradiction() + more;
  std::erase_if(found, [&](const PoseCandidate& c) { return c.agreement.contradiction() > most; });
}

void PoseSearch::align(std::vector<PoseCandidate>& candidates, const Surfels& source, const PlacedModel& model,
                       const AlignOptions& options, double factor, std::size_t samples) const {
  parallel_for(
      candidates.size(), threads_,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          candidates[k].pose = align_symmetric(source, model, candidates[k].pose, options);
          candidates[k].agreement = placement_.judge(view_, candidates[k].pose, factor, samples);
        }
      },
      1);
  sort_by_score(candidates);
}

/// Where surfaces leave a view free, what was looked through says where it cannot lie: it moves only as that improves.
void PoseSearch::away_from_contradiction(PoseCandidate& best, const Surfels& source, const AlignOptions& exact) const {
  for (const double size : {0.5, 0.25, 0.12, 0.06}) {
    if (best.agreement.contradiction() < 0.01) return;
    const auto motions = weak_motions(source, *fine_, best.pose, 2 * exact.end_reach, exact.noise, 0.02);
    bool moved = false;
    for (int round = 0; round < 3; ++round) {
      const double before = best.agreement.score();
      for (const WeakMotion& motion : motions)
        for (const double way : {size, -size}) {
          const Pose pose = motion.by(way * surface_.radius) * best.pose;
          if (!allowed(pose)) continue;
          const Agreement found = placement_.judge(view_, pose, 2, 250);
          if (found.score() > best.agreement.score() && found.contradiction() < best.agreement.contradiction() - 0.005)
            best = {pose, found}, moved = true;
        }
      if (best.agreement.score() <= before) break;
    }
    if (moved) best.pose = align_symmetric(source, *fine_, best.pose, exact);
  }
}

/// Along free motions the guess is all that is known: back towards it, as far as nothing speaks against that.
void PoseSearch::back_to_guess(PoseCandidate& best, const Surfels& source, const AlignOptions& exact) const {
  const auto motions = weak_motions(source, *fine_, best.pose, 2 * exact.end_reach, exact.noise, 1e-3);
  if (motions.empty()) return;
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  const auto distance_to = [&](const Pose& pose) {
    Vec6 e;
    e << surface_.radius * rotation_vector(pose.rotation * guess->rotation.transpose()),
        pose * surface_.center - *guess * surface_.center;
    return e;
  };
  Pose nearest = best.pose;
  for (int round = 0; round < 4; ++round) {
    const Vec6 e = distance_to(nearest);
    Eigen::MatrixXd j(6, static_cast<Eigen::Index>(motions.size()));
    for (std::size_t k = 0; k < motions.size(); ++k)
      j.col(static_cast<Eigen::Index>(k)) << surface_.radius * motions[k].turn,
          motions[k].turn.cross(nearest * surface_.center - motions[k].center) + motions[k].shift;
    const Eigen::VectorXd step = j.completeOrthogonalDecomposition().solve(e);
    for (std::size_t k = 0; k < motions.size(); ++k)
      nearest = motions[k].by(-step[static_cast<Eigen::Index>(k)]) * nearest;
  }
  const double chance = 0.02 + 0.1 * best.agreement.overlap();
  for (const double share : {1.0, 0.5, 0.25}) {
    const Pose pose = align_symmetric(source, *fine_, between(best.pose, nearest, share), exact);
    if (distance_to(pose).norm() > distance_to(best.pose).norm()) continue;
    const Agreement found = placement_.judge(view_, pose, 2, 250);
    if (found.score() < best.agreement.score() - chance ||
        found.contradiction() > best.agreement.contradiction() + 0.02)
      continue;
    best = {pose, found};
    return;
  }
}

void PoseSearch::slide(std::vector<PoseCandidate>& candidates, AlignOptions exact) const {
  const Surfels& source = few_;
  exact.start_reach = exact.end_reach;
  parallel_for(
      candidates.size(), threads_,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          candidates[k].agreement = placement_.judge(view_, candidates[k].pose, 2, 250);
          away_from_contradiction(candidates[k], source, exact);
          if (guess) back_to_guess(candidates[k], source, exact);
        }
      },
      1);
}

}  // namespace partscribe::scan
