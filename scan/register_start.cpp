#include "scan/register_start.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "scan/register_features.h"
#include "scan/register_joint.h"

namespace partscribe {
namespace {

/// Rotation vectors on a lattice within a ball, the middle first.
std::vector<Vec3> turns_within(double most) {
  const double step = std::min(0.4, std::max(0.7 * most, 1e-3));
  const int n = static_cast<int>(std::ceil(most / step));
  std::vector<Vec3> result;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; ++k)
        if (const Vec3 v = step * Vec3(i, j, k); v.norm() <= 1.001 * most && v.norm() <= pi) result.push_back(v);
  std::stable_sort(result.begin(), result.end(), [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  return result;
}

Pose turned(const Pose& pose, const Vec3& center, const Vec3& turn) {
  const Mat3 rotation = rotation_of(turn);
  const Vec3 place = pose * center;
  return Pose{rotation, place - rotation * place} * pose;
}

}  // namespace

double confirm_reach(const std::vector<ViewSurface>& surfaces) {
  double reach = 0;
  for (const ViewSurface& s : surfaces) reach = std::max({reach, 3 * s.sigma, 0.5 * s.spacing});
  return reach;
}

/// A pose of one view that was found, and what speaks for it.
struct PoseCandidate {
  Pose pose;
  Agreement agreement;
};

namespace {

struct Placement {
  const std::vector<ViewSurface>& surfaces;
  const std::vector<Pose>& poses;
  const std::vector<std::size_t>& placed;
  double reach;  // confirm_reach

  Agreement judge(std::size_t view, const Pose& pose, double factor, std::size_t samples) const {
    return agreement(surfaces, poses, view, pose, placed, factor * reach, samples);
  }
};

bool same_place(const ViewSurface& surface, const Pose& a, const Pose& b, double angle, double shift) {
  return rotation_vector(a.rotation.transpose() * b.rotation).norm() < angle && (a * surface.center - b * surface.center).norm() < shift;
}

/// All the way from one pose to the other fits as well: a free motion, not two answers.
bool connected(const Placement& placement, std::size_t view, const PoseCandidate& a, const PoseCandidate& b) {
  for (const double share : {0.25, 0.5, 0.75}) {
    const Pose pose = between(a.pose, b.pose, share);
    if (placement.judge(view, pose, 1.5, 300).overlap() < 0.8 * std::min(a.agreement.overlap(), b.agreement.overlap())) return false;
  }
  return true;
}

/// Poses a view ends in from many starts, best first, each place once.
std::vector<PoseCandidate> candidates_from(const Placement& placement, std::size_t view, const std::vector<Pose>& starts, int threads) {
  const ViewSurface& surface = placement.surfaces[view];
  const double fine_cell = 1.5 * surface.spacing;
  const auto coarse = place_surfaces(placement.surfaces, placement.poses, placement.placed, std::max(surface.radius / 12, 2 * surface.spacing));
  const Surfels few = sample_surfels(surface, 300);
  AlignOptions rough;
  rough.start_reach = 0.35 * surface.radius, rough.end_reach = coarse->cell, rough.noise = 0.1 * coarse->cell, rough.iterations = 40;
  std::vector<PoseCandidate> rough_results(starts.size());
  parallel_for(starts.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      rough_results[k].pose = align_symmetric(few, *coarse, starts[k], rough);
      rough_results[k].agreement = placement.judge(view, rough_results[k].pose, 4, 200);
    }
  }, 1);
  std::stable_sort(rough_results.begin(), rough_results.end(), [](const PoseCandidate& a, const PoseCandidate& b) { return a.agreement.score() > b.agreement.score(); });
  std::vector<PoseCandidate> result;
  for (const PoseCandidate& c : rough_results) {
    bool known = false;
    for (const PoseCandidate& r : result) known = known || same_place(surface, r.pose, c.pose, 0.1, 0.1 * surface.radius);
    if (!known) result.push_back(c);
    if (result.size() >= 6) break;
  }
  const auto fine = place_surfaces(placement.surfaces, placement.poses, placement.placed, fine_cell);
  const Surfels many = sample_surfels(surface, 1000);
  AlignOptions exact;
  exact.start_reach = coarse->cell, exact.end_reach = std::max(1.5 * surface.spacing, 4 * surface.sigma), exact.noise = std::max(0.5 * surface.sigma, 0.02 * surface.spacing);
  parallel_for(result.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      result[k].pose = align_symmetric(many, *fine, result[k].pose, exact);
      result[k].agreement = placement.judge(view, result[k].pose, 1.5, 1000);
    }
  }, 1);
  std::stable_sort(result.begin(), result.end(), [](const PoseCandidate& a, const PoseCandidate& b) { return a.agreement.score() > b.agreement.score(); });
  return result;
}

std::string degrees_text(double angle) { return print_number(std::round(angle * 1800 / pi) / 10); }
std::string percent(double share) { return print_number(std::round(share * 1000) / 10) + " %"; }

/// Whether the evidence tells a worse pose from the better: by more than chance and a little more.
bool clearly_better(const Agreement& a, const Agreement& b) {
  const double n = std::max(a.samples, 1);
  const double margin = a.score() - b.score();
  return margin > 0.02 + 3 * std::sqrt(std::max(a.confirmed, b.confirmed) * 0.05) / n + 0.05 * a.overlap();
}

}  // namespace

namespace {

/// How far a pose lies from another.
struct Distance {
  double angle = 0, shift = 0;
};

Distance distance(const ViewSurface& surface, const Pose& a, const Pose& b) {
  return {rotation_vector(a.rotation.transpose() * b.rotation).norm(), (a * surface.center - b * surface.center).norm()};
}

std::string apart(const Distance& d) {
  return degrees_text(d.angle) + " degrees and " + print_number(std::round(d.shift * 10) / 10) + " mm apart";
}

/// Views on their way from guesses to poses.
struct Growth {
  const std::vector<ViewSurface>& surfaces;
  const std::vector<Pose>& guesses;
  const RegisterOptions& options;
  double most_shift = 0, reach = 0;
  std::vector<Vec3> turns;
  StartResult result;
  std::vector<std::size_t> placed;

  bool guessed = true;

  /// The best pose of a view against others, among those reached from `starts`; false with a reason if there is none or
  /// more than one.
  bool place(std::size_t view, const std::vector<Pose>& starts, const std::vector<std::size_t>& others, Context& context);
  /// The first start as it is, and its guess turned every way that is allowed.
  std::vector<Pose> starts_around(std::size_t view, const Pose& start) const {
    std::vector<Pose> starts{start};
    for (const Vec3& turn : turns) starts.push_back(turned(guesses[view], surfaces[view].center, turn));
    return starts;
  }
};

bool Growth::place(std::size_t view, const std::vector<Pose>& starts, const std::vector<std::size_t>& others, Context& context) {
  const ViewSurface& surface = surfaces[view];
  std::string& reason = result.reason[view];
  const Placement placement{surfaces, result.poses, others, reach};
  const Pose start = starts.front();
  std::vector<PoseCandidate> found = candidates_from(placement, view, starts, context.threads);
  std::erase_if(found, [&](const PoseCandidate& c) {
    if (!guessed) return false;
    const Distance d = distance(surface, guesses[view], c.pose);
    return d.angle > 1.1 * options.guess_angle + 0.05 || d.shift > most_shift;
  });
  if (found.empty()) {
    reason = !guessed ? "no features like those of another view" : "no pose within " + degrees_text(options.guess_angle) + " degrees and " + print_number(std::round(most_shift * 10) / 10) + " mm of the guess fits";
    return false;
  }
  // Of a free motion the pose nearest to the start.
  PoseCandidate chosen = found.front();
  reason.clear();
  for (std::size_t k = 1; k < found.size(); ++k) {
    if (same_place(surface, found[k].pose, found[0].pose, 0.03, 0.05 * surface.radius) || clearly_better(found[0].agreement, found[k].agreement)) continue;
    if (!connected(placement, view, found[0], found[k])) {
      if (reason.empty()) reason = "fits in two places that are " + apart(distance(surface, found[0].pose, found[k].pose));
    } else if (distance(surface, start, found[k].pose).angle < distance(surface, start, chosen.pose).angle) {
      chosen = found[k];
    }
  }
  result.poses[view] = chosen.pose;
  if (!reason.empty()) return false;
  if (chosen.agreement.overlap() < options.min_overlap)
    reason = "only " + percent(chosen.agreement.overlap()) + " of its points are confirmed by the views placed before it";
  else if (chosen.agreement.seen_through() > 2 * options.max_seen_through)
    reason = "another view looked through " + percent(chosen.agreement.seen_through()) + " of its points";
  return reason.empty();
}

/// All views adjusted at once from their guesses; those that the others then confirm.
std::vector<std::size_t> agreeing(Growth& growth, const std::vector<std::size_t>& usable, Context& context) {
  double radius = 0;
  for (const std::size_t v : usable) radius = std::max(radius, growth.surfaces[v].radius);
  JointOptions rough;
  rough.start_reach = 0.25 * radius, rough.contours = growth.options.contours;
  const JointResult joint = adjust_jointly(growth.surfaces, growth.guesses, usable, rough, context);
  std::vector<std::size_t> good = usable;
  // One wrong view spoils what is said of its neighbours: the worst leaves first.
  while (good.size() > 1) {
    std::size_t worst = 0;
    double least = 0;
    for (std::size_t k = 1; k < good.size(); ++k) {
      const Agreement a = agreement(growth.surfaces, joint.poses, good[k], joint.poses[good[k]], good, growth.reach, 500);
      const Distance d = distance(growth.surfaces[good[k]], growth.guesses[good[k]], joint.poses[good[k]]);
      const bool far = d.angle > 1.1 * growth.options.guess_angle + 0.05 || d.shift > growth.most_shift;
      const double margin = far ? -1 : std::min(a.overlap() - growth.options.min_overlap, growth.options.max_seen_through - a.seen_through());
      if (margin < least) least = margin, worst = k;
    }
    if (worst == 0) break;
    good.erase(good.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  for (const std::size_t v : good) growth.result.poses[v] = joint.poses[v];
  return good;
}

}  // namespace

StartResult start_from_guesses(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                               const RegisterOptions& options, Context& context) {
  const std::size_t n = surfaces.size();
  Growth growth{surfaces, guesses, options, 0, confirm_reach(surfaces), turns_within(options.guess_angle),
                {guesses, std::vector<std::uint8_t>(n, 0), std::vector<std::string>(n)}, {}, true};
  StartResult& result = growth.result;
  std::vector<std::size_t> usable;
  Box3 box;
  for (std::size_t v = 0; v < n; ++v) {
    if (surfaces[v].usable()) usable.push_back(v);
    else result.reason[v] = "expected at least 50 points on smooth surface, found " + std::to_string(surfaces[v].samples.size());
    for (std::size_t i = 0; i < surfaces[v].points.size(); i += 16) box.add(guesses[v] * surfaces[v].points[i]);
  }
  if (usable.empty()) return result;
  growth.most_shift = options.guess_shift > 0 ? options.guess_shift : 0.35 * box.diagonal();
  std::vector<std::size_t>& placed = growth.placed;
  placed = agreeing(growth, usable, context);
  context.say("agree from their guesses: " + std::to_string(placed.size()) + " of " + std::to_string(usable.size()));
  // Each is tried in other places as well; what fits elsewhere no worse is not known.
  for (std::size_t k = 1; k < placed.size() && !context.cancelled;) {
    std::vector<std::size_t> others = placed;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    if (growth.place(placed[k], growth.starts_around(placed[k], result.poses[placed[k]]), others, context)) ++k;
    else placed = others;
  }
  std::vector<std::size_t> waiting;
  for (const std::size_t v : usable)
    if (std::find(placed.begin(), placed.end(), v) == placed.end()) waiting.push_back(v);
  std::vector<int> tried(n, 0);
  while (!waiting.empty() && !context.cancelled) {
    // The one that by its guess shares most with what is placed; those that failed wait until more is there.
    std::size_t best = 0;
    double best_share = -3;
    for (std::size_t k = 0; k < waiting.size(); ++k) {
      const std::size_t v = waiting[k];
      const double share = agreement(surfaces, result.poses, v, guesses[v], placed, 0.2 * surfaces[v].radius, 150).overlap() - tried[v];
      if (share > best_share) best_share = share, best = k;
    }
    const std::size_t view = waiting[best];
    if (++tried[view] > 2) break;
    if (!growth.place(view, growth.starts_around(view, guesses[view]), placed, context)) continue;
    placed.push_back(view);
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(best));
  }
  for (const std::size_t v : placed) result.placed[v] = 1;
  return result;
}

namespace {

/// One view against one other: where it may lie, the likeliest first.
struct PairCandidates {
  std::size_t target, source;
  std::vector<PoseCandidate> found;  // target_from_source
};

std::vector<PairCandidates> compare_pairs(const std::vector<ViewSurface>& surfaces, const std::vector<std::size_t>& usable,
                                          double reach, Context& context) {
  double radius = 0, spacing = 0;
  for (const std::size_t v : usable) radius += surfaces[v].radius / static_cast<double>(usable.size()), spacing = std::max(spacing, surfaces[v].spacing);
  const double cell = std::max(radius / 16, 2 * spacing);
  std::vector<std::unique_ptr<Features>> features(surfaces.size());
  for (const std::size_t v : usable) features[v] = features_of(surfaces[v], cell);
  std::vector<PairCandidates> pairs;
  for (const std::size_t a : usable)
    for (const std::size_t b : usable)
      if (a < b) pairs.push_back({a, b, {}});
  parallel_for(pairs.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end && !context.cancelled; ++k) {
      PairCandidates& pair = pairs[k];
      const std::vector<Pose> poses(surfaces.size());
      const std::vector<std::size_t> target{pair.target};
      const Placement placement{surfaces, poses, target, reach};
      pair.found = candidates_from(placement, pair.source, feature_poses(*features[pair.source], *features[pair.target], 24), 1);
    }
  }, 1);
  return pairs;
}

/// Half and quarter turns about the main axes of a view: what symmetric parts are mistaken for.
std::vector<Pose> symmetric_turns(const ViewSurface& surface, const Pose& pose, const Vec3& center) {
  std::vector<Pose> result;
  Mat3 spread = Mat3::Zero();
  for (const auto i : surface.samples) spread += surface.normals[i] * surface.normals[i].transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(spread);
  for (int axis = 0; axis < 3; ++axis)
    for (const double angle : {0.5 * pi, pi, 1.5 * pi}) {
      const Mat3 turn = rotation_of(pose.rotation * eigen.eigenvectors().col(axis) * angle);
      result.push_back(Pose{turn, center - turn * center} * pose);
    }
  return result;
}

}  // namespace

namespace {

/// Views placed one after the other upon a first pair.
void grow_from(Growth& growth, const std::vector<PairCandidates>& pairs, std::size_t first, const std::vector<std::size_t>& usable, Context& context) {
  const std::vector<ViewSurface>& surfaces = growth.surfaces;
  StartResult& result = growth.result;
  std::vector<std::size_t>& placed = growth.placed;
  placed.assign(1, first);
  std::vector<std::size_t> waiting;
  for (const std::size_t v : usable)
    if (v != first) waiting.push_back(v);
  std::vector<std::size_t> failed_at(surfaces.size(), 0);  // how many were placed when it failed
  while (!waiting.empty() && !context.cancelled) {
    double best_score = -1e30;
    std::size_t best = waiting.size();
    std::vector<Pose> best_starts;
    const Placement placement{surfaces, result.poses, placed, growth.reach};
    for (std::size_t k = 0; k < waiting.size(); ++k) {
      const std::size_t v = waiting[k];
      if (failed_at[v] == placed.size()) continue;
      std::vector<PoseCandidate> starts;
      for (const PairCandidates& pair : pairs) {
        const bool forward = pair.source == v, backward = pair.target == v;
        const std::size_t other = forward ? pair.target : pair.source;
        if ((!forward && !backward) || std::find(placed.begin(), placed.end(), other) == placed.end()) continue;
        for (const PoseCandidate& c : pair.found) {
          const Pose pose = result.poses[other] * (forward ? c.pose : c.pose.inverse());
          starts.push_back({pose, placement.judge(v, pose, 2, 300)});
        }
      }
      std::stable_sort(starts.begin(), starts.end(), [](const PoseCandidate& x, const PoseCandidate& y) { return x.agreement.score() > y.agreement.score(); });
      if (starts.empty() || starts[0].agreement.score() <= best_score) continue;
      best_score = starts[0].agreement.score(), best = k;
      best_starts.clear();
      for (std::size_t s = 0; s < std::min<std::size_t>(starts.size(), 20); ++s) best_starts.push_back(starts[s].pose);
    }
    if (best == waiting.size()) break;
    const std::size_t view = waiting[best];
    Vec3 center = Vec3::Zero();
    for (const std::size_t v : placed) center += result.poses[v] * surfaces[v].center / static_cast<double>(placed.size());
    for (const Pose& pose : symmetric_turns(surfaces[view], best_starts.front(), center)) best_starts.push_back(pose);
    if (!growth.place(view, best_starts, placed, context)) {
      failed_at[view] = placed.size();
      continue;
    }
    placed.push_back(view);
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(best));
  }
  for (const std::size_t v : waiting)
    if (result.reason[v].empty()) result.reason[v] = "no features like those of another view";
  for (const std::size_t v : placed) result.placed[v] = 1;
}

}  // namespace

StartResult start_from_features(const std::vector<ViewSurface>& surfaces, const RegisterOptions& options, Context& context) {
  const std::size_t n = surfaces.size();
  const std::vector<Pose> none(n);
  const StartResult nothing{none, std::vector<std::uint8_t>(n, 0), std::vector<std::string>(n)};
  StartResult result = nothing;
  std::vector<std::size_t> usable;
  for (std::size_t v = 0; v < n; ++v)
    if (surfaces[v].usable()) usable.push_back(v);
    else result.reason[v] = "expected at least 50 points on smooth surface, found " + std::to_string(surfaces[v].samples.size());
  if (usable.empty()) return result;
  context.report("comparing views", 0);
  std::vector<PairCandidates> pairs = compare_pairs(surfaces, usable, confirm_reach(surfaces), context);
  std::erase_if(pairs, [](const PairCandidates& p) { return p.found.empty(); });
  std::stable_sort(pairs.begin(), pairs.end(), [](const PairCandidates& a, const PairCandidates& b) { return a.found[0].agreement.score() > b.found[0].agreement.score(); });
  // A pair that only seems to fit does not grow far: a few are tried, the largest structure wins.
  std::vector<std::size_t> tried;
  std::size_t most = 0;
  for (const PairCandidates& pair : pairs) {
    if (tried.size() >= 4 || most == usable.size()) break;
    if (std::find(tried.begin(), tried.end(), pair.target) != tried.end()) continue;
    tried.push_back(pair.target);
    Growth growth{surfaces, none, options, 0, confirm_reach(surfaces), {}, nothing, {}, false};
    grow_from(growth, pairs, pair.target, usable, context);
    context.say("from view " + std::to_string(pair.target) + ": " + std::to_string(growth.placed.size()) + " placed");
    if (growth.placed.size() > most) most = growth.placed.size(), result = std::move(growth.result);
  }
  // Few views that agree among themselves may do so by chance; of many that is unlikely.
  if (3 * most < 2 * usable.size()) {
    for (const std::size_t v : usable) {
      result.placed[v] = v == usable.front();
      if (!result.placed[v]) result.reason[v] = "only " + std::to_string(most) + " of " + std::to_string(usable.size()) + " views can be laid over one another by their features; expected two thirds";
    }
    result.poses = none;
  }
  return result;
}

}  // namespace partscribe
