#include "scan/register_start.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"

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
struct Candidate {
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
bool connected(const Placement& placement, std::size_t view, const Candidate& a, const Candidate& b) {
  for (const double share : {0.25, 0.5, 0.75}) {
    const Pose pose = between(a.pose, b.pose, share);
    if (placement.judge(view, pose, 1.5, 300).overlap() < 0.8 * std::min(a.agreement.overlap(), b.agreement.overlap())) return false;
  }
  return true;
}

/// Poses a view ends in from many starts, best first, each place once.
std::vector<Candidate> candidates_from(const Placement& placement, std::size_t view, const std::vector<Pose>& starts, int threads) {
  const ViewSurface& surface = placement.surfaces[view];
  const double fine_cell = 1.5 * surface.spacing;
  const auto coarse = place_surfaces(placement.surfaces, placement.poses, placement.placed, std::max(surface.radius / 12, 2 * surface.spacing));
  const Surfels few = sample_surfels(surface, 300);
  AlignOptions rough;
  rough.start_reach = 0.35 * surface.radius, rough.end_reach = coarse->cell, rough.noise = 0.1 * coarse->cell, rough.iterations = 40;
  std::vector<Candidate> rough_results(starts.size());
  parallel_for(starts.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      rough_results[k].pose = align_symmetric(few, *coarse, starts[k], rough);
      rough_results[k].agreement = placement.judge(view, rough_results[k].pose, 4, 200);
    }
  }, 1);
  std::stable_sort(rough_results.begin(), rough_results.end(), [](const Candidate& a, const Candidate& b) { return a.agreement.score() > b.agreement.score(); });
  std::vector<Candidate> result;
  for (const Candidate& c : rough_results) {
    bool known = false;
    for (const Candidate& r : result) known = known || same_place(surface, r.pose, c.pose, 0.1, 0.1 * surface.radius);
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
  std::stable_sort(result.begin(), result.end(), [](const Candidate& a, const Candidate& b) { return a.agreement.score() > b.agreement.score(); });
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

StartResult start_from_guesses(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                               const RegisterOptions& options, Context& context) {
  const std::size_t n = surfaces.size();
  StartResult result{guesses, std::vector<std::uint8_t>(n, 0), std::vector<std::string>(n)};
  std::vector<std::size_t> placed, waiting;
  for (std::size_t v = 0; v < n; ++v) {
    if (!surfaces[v].usable())
      result.reason[v] = "expected at least 50 points on smooth surface, found " + std::to_string(surfaces[v].samples.size());
    else if (placed.empty())
      placed.push_back(v), result.placed[v] = 1;
    else
      waiting.push_back(v);
  }
  if (placed.empty()) return result;
  Box3 box;
  for (std::size_t v = 0; v < n; ++v)
    for (std::size_t i = 0; i < surfaces[v].points.size(); i += 16) box.add(guesses[v] * surfaces[v].points[i]);
  const double most_shift = options.guess_shift > 0 ? options.guess_shift : 0.35 * box.diagonal();
  const auto turns = turns_within(options.guess_angle);
  const double reach = confirm_reach(surfaces);
  std::vector<int> tried(n, 0);
  while (!waiting.empty() && !context.cancelled) {
    // The one that by its guess shares most with what is placed; those that failed wait until more is there.
    std::size_t best = 0;
    double best_share = -2;
    for (std::size_t k = 0; k < waiting.size(); ++k) {
      const ViewSurface& surface = surfaces[waiting[k]];
      double share = agreement(surfaces, result.poses, waiting[k], guesses[waiting[k]], placed, 0.2 * surface.radius, 150).overlap();
      share -= tried[waiting[k]];
      if (share > best_share) best_share = share, best = k;
    }
    const std::size_t view = waiting[best];
    if (tried[view] >= 2) break;
    ++tried[view];
    std::vector<Pose> starts;
    for (const Vec3& turn : turns) starts.push_back(turned(guesses[view], surfaces[view].center, turn));
    const Placement placement{surfaces, result.poses, placed, reach};
    std::vector<Candidate> found = candidates_from(placement, view, starts, context.threads);
    const auto allowed = [&](const Candidate& c) {
      return rotation_vector(guesses[view].rotation.transpose() * c.pose.rotation).norm() < options.guess_angle * 1.1 + 0.05 &&
             (guesses[view] * surfaces[view].center - c.pose * surfaces[view].center).norm() < most_shift;
    };
    std::erase_if(found, [&](const Candidate& c) { return !allowed(c); });
    if (found.empty()) {
      result.reason[view] = "no pose within " + degrees_text(options.guess_angle) + " degrees and " + print_number(std::round(most_shift * 10) / 10) + " mm of the guess fits";
      continue;
    }
    for (const Candidate& c : found)
      context.say("  score " + print_number(c.agreement.score()) + " confirmed " + print_number(c.agreement.overlap()) + " through " + std::to_string(c.agreement.through) + " " + std::to_string(c.agreement.back_through) + " missing " + std::to_string(c.agreement.missing) + " residual " + print_number(c.agreement.residual) + " turned " + degrees_text(rotation_vector(guesses[view].rotation.transpose() * c.pose.rotation).norm()));
    // Of a free motion the pose nearest to the guess.
    Candidate chosen = found.front();
    std::string ambiguous;
    for (std::size_t k = 1; k < found.size(); ++k) {
      if (same_place(surfaces[view], found[k].pose, found[0].pose, 0.03, 0.05 * surfaces[view].radius) || clearly_better(found[0].agreement, found[k].agreement)) continue;
      if (connected(placement, view, found[0], found[k])) {
        const auto off = [&](const Candidate& c) { return rotation_vector(guesses[view].rotation.transpose() * c.pose.rotation).norm(); };
        if (off(found[k]) < off(chosen)) chosen = found[k];
      } else if (ambiguous.empty()) {
        ambiguous = "fits in two places that are " + degrees_text(rotation_vector(found[0].pose.rotation.transpose() * found[k].pose.rotation).norm()) +
                    " degrees and " + print_number(std::round((found[0].pose * surfaces[view].center - found[k].pose * surfaces[view].center).norm() * 10) / 10) + " mm apart";
      }
    }
    result.poses[view] = chosen.pose;
    if (!ambiguous.empty()) result.reason[view] = ambiguous;
    else if (chosen.agreement.overlap() < options.min_overlap)
      result.reason[view] = "only " + percent(chosen.agreement.overlap()) + " of its points are confirmed by the views placed before it";
    else if (chosen.agreement.seen_through() > 2 * options.max_seen_through)
      result.reason[view] = "another view looked through " + percent(chosen.agreement.seen_through()) + " of its points";
    else {
      result.reason[view].clear(), result.placed[view] = 1;
      placed.push_back(view);
      waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(best));
    }
    context.say(std::to_string(view) + ": overlap " + print_number(chosen.agreement.overlap()) + ", through " + print_number(chosen.agreement.seen_through()) +
                ", candidates " + std::to_string(found.size()) + (result.reason[view].empty() ? "" : ", " + result.reason[view]));
  }
  return result;
}

}  // namespace partscribe
