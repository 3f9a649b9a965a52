#include "scan/register/register_start.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "core/statistics.h"
#include "scan/register/register_alike.h"
#include "scan/register/register_features.h"
#include "scan/register/register_free.h"
#include "scan/register/register_joint.h"
#include "scan/register/register_planes.h"
#include "scan/register/register_search.h"
#include "scan/register/register_steps.h"
#include "scan/register/register_words.h"

namespace partscribe::scan {
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
  std::stable_sort(result.begin(), result.end(),
                   [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  return result;
}

}  // namespace

double confirm_reach(const std::vector<ViewSurface>& surfaces) {
  double reach = 0;
  for (const ViewSurface& s : surfaces) reach = std::max({reach, 3 * s.sigma, 0.5 * s.spacing});
  return reach;
}

namespace {

/// Whether the evidence tells a worse pose from the better. More overlap is little evidence, for a face lies on any
/// other face: what is not contradicted and overlaps `little` as much is as possible.
bool clearly_better(const Agreement& a, const Agreement& b, double little) {
  if (b.contradiction() > 1.5 * a.contradiction() + 0.02) return true;
  return b.overlap() < little * a.overlap() && a.contradiction() < 1.5 * b.contradiction() + 0.02;
}

/// How far a pose lies from another.
struct Distance {
  double angle = 0, shift = 0;
};

Distance distance(const ViewSurface& surface, const Pose& a, const Pose& b) {
  return {rotation_vector(a.rotation.transpose() * b.rotation).norm(),
          (a * surface.center - b * surface.center).norm()};
}

std::string apart(const Distance& d) {
  return in_degrees(d.angle) + " degrees and " + in_steps(d.shift, 0.1) + " mm apart";
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
  bool nearly_whole = false;  ///< most views are placed, so that none of the others lies beside them all
  bool either_side = false;   ///< of two places between which a turn lies that lays the others onto themselves, one is
                              ///< taken: all views together tell

  /// The best pose of a view against others, among those reached from `starts`; false with a reason if there is none or
  /// more than one. `adjusted`: all others are there; the first start is where the view lies and stays unless another
  /// is clearly better, and without guesses it is tried turned all round as well.
  bool place(std::size_t view, const std::vector<Pose>& starts, const std::vector<std::size_t>& others, bool adjusted,
             Context& context);
  /// The first start as it is, and its guess turned every way that is allowed.
  std::vector<Pose> starts_around(std::size_t view, const Pose& start) const {
    std::vector<Pose> starts{start};
    for (const Vec3& turn : turns)
      starts.push_back(moved_about(guesses[view], guesses[view] * surfaces[view].center, turn, Vec3::Zero()));
    return starts;
  }
};

bool Growth::place(std::size_t view, const std::vector<Pose>& starts, const std::vector<std::size_t>& others,
                   bool adjusted, Context& context) {
  const ViewSurface& surface = surfaces[view];
  std::string& reason = result.reason[view];
  const Placement placement{surfaces, result.poses, others, reach, guessed ? Creases::left_out : Creases::count};
  const Pose start = starts.front();
  const auto too_far = [&](const Pose& pose) {
    if (!guessed) return false;
    const Distance d = distance(surface, guesses[view], pose);
    return d.angle > 1.1 * options.guess_angle + 0.05 || d.shift > most_shift;
  };
  PoseSearch search(placement, view, context.threads, guessed || adjusted);
  if (guessed) search.guess = &guesses[view], search.too_far = too_far;
  std::vector<Pose> all = starts;
  if (adjusted && !guessed) {
    std::vector<Pose> turned;
    for (const Mat3& turn : turns_all_round())
      turned.push_back({turn * start.rotation, start * surface.center - turn * start.rotation * surface.center});
    const std::vector<Pose> placed_there = search.with_places(turned);
    all.insert(all.end(), placed_there.begin(), placed_there.end());
  }
  std::vector<PoseCandidate> found = search.from(all);
  std::erase_if(found, [&](const PoseCandidate& c) { return too_far(c.pose); });
  // What was found says where else to look.
  std::vector<Pose> elsewhere;  // without a guess the starts hold such turns already
  if (guessed) {
    const Mat3 axes = search.axes();
    for (std::size_t k = 0; k < std::min<std::size_t>(2, found.size()); ++k)
      for (const Pose& pose : rivals_of(surface, axes, found[k].pose))
        if (!too_far(pose)) elsewhere.push_back(pose);
  }
  std::vector<PoseCandidate> more = search.from(elsewhere, found);
  std::erase_if(more, [&](const PoseCandidate& c) { return too_far(c.pose); });
  if (nearly_whole || either_side)
    std::erase_if(found, [&](const PoseCandidate& c) { return c.agreement.overlap() < options.min_overlap; });
  found.insert(found.end(), more.begin(), more.end());
  // Searches may drift along free motions, beyond what the guess allows.
  if (found.empty() && adjusted && !too_far(start)) found.push_back({start, placement.judge(view, start, 1.5, 1000)});
  sort_by_score(found);
  found = distinct(found, surface, 0.03, found.size());
  if (found.empty()) {
    reason = !guessed ? "no features like those of another view"
                      : "no pose within " + in_degrees(options.guess_angle) + " degrees and " +
                            in_steps(most_shift, 0.1) + " mm of the guess fits";
    return false;
  }
  // Of a free motion the pose nearest to the start that shows most of what can be shown; not where the start is to be
  // doubted.
  PoseCandidate chosen = found.front();
  std::vector<Pose> joined;
  // One other view only looked at little of what it could contradict, but without guesses features have compared all.
  // Where most views are placed the right place is confirmed nearly whole, but so is a wrong one of a part alike from
  // two sides: there views come to lie upon one another, and the right place, uncontradicted, shows a third as much.
  const double little = guessed && others.size() == 1 ? 0.2 : nearly_whole ? 0.35 : 0.5;
  reason.clear();
  result.on_a_side[view] = 0;
  for (std::size_t k = 1; k < found.size(); ++k) {
    if (same_place(surface, found[k].pose, found[0].pose, 0.03, 0.05 * surface.radius) ||
        clearly_better(found[0].agreement, found[k].agreement, little))
      continue;
    if (!connected(placement, view, found[0], found[k])) {
      if (either_side && alike_after(placement, found[k].pose * found[0].pose.inverse())) {
        result.on_a_side[view] = 1;
        if (clearly_better(found[k].agreement, chosen.agreement, little)) chosen = found[k];
        continue;
      }
      if (reason.empty())
        reason = "fits in two places that are " + apart(distance(surface, found[0].pose, found[k].pose));
      continue;
    }
    joined.push_back(found[k].pose * found[0].pose.inverse());
    if (!nearly_whole && found[k].agreement.overlap() > 0.8 * found[0].agreement.overlap() &&
        distance(surface, start, found[k].pose).angle < distance(surface, start, chosen.pose).angle)
      chosen = found[k];
  }
  result.joined[view] = std::move(joined);
  if (adjusted) {
    const PoseCandidate kept{start, placement.judge(view, start, 1.5, 1000)};
    if (!clearly_better(chosen.agreement, kept.agreement, little) && connected(placement, view, kept, chosen))
      chosen = kept;
  }
  result.poses[view] = chosen.pose;
  if (!reason.empty()) return false;
  if (chosen.agreement.overlap() < options.min_overlap)
    reason =
        "only " + in_percent(chosen.agreement.overlap()) + " of its points are confirmed by the views placed before it";
  else if (chosen.agreement.seen_through() > 2 * options.max_seen_through)
    reason = "another view looked through " + in_percent(chosen.agreement.seen_through()) + " of its points";
  return reason.empty();
}

/// mm, from where a view was guessed to be.
double most_shift(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                  const RegisterOptions& options) {
  if (options.guess_shift > 0) return options.guess_shift;
  Box3 box;
  for (std::size_t v = 0; v < surfaces.size(); ++v)
    for (std::size_t i = 0; i < surfaces[v].points.size(); i += 16) box.add(guesses[v] * surfaces[v].points[i]);
  return 0.35 * box.diagonal();
}

Growth growth_from_guesses(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                           const RegisterOptions& options, StartResult start) {
  return {surfaces,
          guesses,
          options,
          most_shift(surfaces, guesses, options),
          confirm_reach(surfaces),
          turns_within(options.guess_angle),
          std::move(start),
          {},
          true};
}

/// All views adjusted at once from their guesses; those that the others then confirm.
std::vector<std::size_t> agreeing(Growth& growth, const std::vector<std::size_t>& usable, Context& context) {
  double radius = 0;
  for (const std::size_t v : usable) radius = std::max(radius, growth.surfaces[v].radius);
  JointOptions rough;
  rough.start_reach = 0.25 * radius, rough.contours = growth.options.contours, rough.roughly = true;
  const JointResult joint = adjust_jointly(growth.surfaces, growth.guesses, usable, rough, context);
  std::vector<std::size_t> good = usable;
  // One wrong view spoils what is said of its neighbours: the worst leaves first.
  while (good.size() > 1) {
    std::size_t worst = 0;
    double least = 0;
    for (std::size_t k = 1; k < good.size(); ++k) {
      const Agreement a =
          agreement(growth.surfaces, joint.poses, good[k], joint.poses[good[k]], good, growth.reach, 500);
      const Distance d = distance(growth.surfaces[good[k]], growth.guesses[good[k]], joint.poses[good[k]]);
      const bool far = d.angle > 1.1 * growth.options.guess_angle + 0.05 || d.shift > growth.most_shift;
      const double margin =
          far ? -1
              : std::min(a.overlap() - growth.options.min_overlap, growth.options.max_seen_through - a.seen_through());
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
  Growth growth = growth_from_guesses(surfaces, guesses, options, StartResult::at(guesses, false));
  StartResult& result = growth.result;
  std::vector<std::size_t> usable;
  for (std::size_t v = 0; v < n; ++v) {
    if (surfaces[v].usable())
      usable.push_back(v);
    else
      result.reason[v] =
          "expected at least 50 points on smooth surface, found " + std::to_string(surfaces[v].samples.size());
  }
  if (usable.empty()) return result;
  std::vector<std::size_t>& placed = growth.placed;
  placed = agreeing(growth, usable, context);
  context.say("agree from their guesses: " + std::to_string(placed.size()) + " of " + std::to_string(usable.size()));
  std::vector<std::size_t> failed_at(n, 0);  // how many were placed when it failed
  // Each is tried in other places as well; what fits elsewhere no worse is not known.
  for (std::size_t k = 1; k < placed.size() && !context.cancelled;) {
    std::vector<std::size_t> others = placed;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    if (growth.place(placed[k], growth.starts_around(placed[k], result.poses[placed[k]]), others, true, context))
      ++k;
    else
      failed_at[placed[k]] = others.size(), placed = others;
  }
  std::vector<std::size_t> waiting;
  for (const std::size_t v : usable)
    if (std::find(placed.begin(), placed.end(), v) == placed.end()) waiting.push_back(v);
  while (!waiting.empty() && !context.cancelled) {
    // The one that by its guess shares most with what is placed; those that failed wait until more is there.
    std::size_t best = waiting.size();
    double best_share = -1;
    for (std::size_t k = 0; k < waiting.size(); ++k) {
      const std::size_t v = waiting[k];
      if (failed_at[v] == placed.size()) continue;
      const double share =
          agreement(surfaces, result.poses, v, guesses[v], placed, 0.2 * surfaces[v].radius, 150).overlap();
      if (share > best_share) best_share = share, best = k;
    }
    if (best == waiting.size()) break;
    const std::size_t view = waiting[best];
    if (!growth.place(view, growth.starts_around(view, guesses[view]), placed, false, context)) {
      failed_at[view] = placed.size();
      continue;
    }
    placed.push_back(view);
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(best));
  }
  for (const std::size_t v : placed) result.placed[v] = 1;
  return result;
}

std::vector<std::size_t> placed_after_all(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                                          const RegisterOptions& options, std::vector<std::size_t> placed,
                                          const std::vector<std::size_t>& refused, StartResult& start,
                                          Context& context) {
  Growth growth = growth_from_guesses(surfaces, guesses, options, std::move(start));
  std::vector<std::size_t> back;
  for (const std::size_t view : refused) {
    if (context.cancelled) break;
    const Pose before = growth.result.poses[view];
    if (!surfaces[view].usable()) continue;
    if (growth.place(view, growth.starts_around(view, before), placed, true, context))
      placed.push_back(view), back.push_back(view);
    else
      growth.result.poses[view] = before;
  }
  start = std::move(growth.result);
  return back;
}

namespace {

/// One view against one other: where it may lie, the likeliest first.
struct PairCandidates {
  std::size_t target, source;
  std::vector<PoseCandidate> found;  // target_from_source
};

std::vector<PairCandidates> compare_pairs(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<std::size_t>& usable, double reach, Context& context) {
  double radius = 0, spacing = 0;
  for (const std::size_t v : usable)
    radius += surfaces[v].radius / static_cast<double>(usable.size()), spacing = std::max(spacing, surfaces[v].spacing);
  const double cell = std::max(radius / 16, 2 * spacing);
  std::vector<std::unique_ptr<Features>> features(surfaces.size());
  constexpr std::size_t most_planes = 12, most_of_features = 24, most_of_planes = 16;
  std::vector<std::vector<ViewPlane>> planes(surfaces.size());
  for (const std::size_t v : usable)
    features[v] = features_of(surfaces[v], cell), planes[v] = planes_of(surfaces[v], most_planes);
  std::vector<PairCandidates> pairs;
  for (const std::size_t a : usable)
    for (const std::size_t b : usable)
      if (a < b) pairs.push_back({a, b, {}});
  parallel_for(
      pairs.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end && !context.cancelled; ++k) {
          PairCandidates& pair = pairs[k];
          const std::vector<Pose> poses(surfaces.size());
          const std::vector<std::size_t> target{pair.target};
          const Placement placement{surfaces, poses, target, reach};
          // Histograms of normals tell the faces of a block apart poorly; planes know nothing of what is round.
          std::vector<Pose> starts = feature_poses(*features[pair.source], *features[pair.target], most_of_features);
          const std::vector<Pose> by_planes = plane_poses(planes[pair.source], planes[pair.target], surfaces,
                                                          pair.source, pair.target, reach, most_of_planes);
          starts.insert(starts.end(), by_planes.begin(), by_planes.end());
          pair.found = PoseSearch(placement, pair.source, 1, false).from(starts);
        }
      },
      1);
  return pairs;
}

/// Where a view may lie by its pairs with `others`, the likeliest first; empty if no pair fits.
std::vector<PoseCandidate> places_by_pairs(const Growth& growth, const std::vector<PairCandidates>& pairs,
                                           std::size_t view, const std::vector<std::size_t>& others) {
  const Placement placement{growth.surfaces, growth.result.poses, others, growth.reach};
  std::vector<PoseCandidate> places;
  for (const PairCandidates& pair : pairs) {
    const bool forward = pair.source == view, backward = pair.target == view;
    const std::size_t other = forward ? pair.target : pair.source;
    if ((!forward && !backward) || std::find(others.begin(), others.end(), other) == others.end()) continue;
    for (const PoseCandidate& c : pair.found) {
      const Pose pose = growth.result.poses[other] * (forward ? c.pose : c.pose.inverse());
      places.push_back({pose, placement.judge(view, pose, 2, 300)});
    }
  }
  sort_by_score(places);
  return places;
}

/// `places` and the turns that symmetric parts are mistaken for, about the middle of `others`.
std::vector<Pose> starts_from(const Growth& growth, const std::vector<PoseCandidate>& places, std::size_t view,
                              const std::vector<std::size_t>& others) {
  constexpr std::size_t most = 20;
  std::vector<Pose> starts;
  for (std::size_t s = 0; s < std::min(places.size(), most); ++s) starts.push_back(places[s].pose);
  if (starts.empty()) return starts;
  Vec3 center = Vec3::Zero();
  for (const std::size_t v : others)
    center += growth.result.poses[v] * growth.surfaces[v].center / static_cast<double>(others.size());
  for (const Pose& pose : symmetric_turns(main_axes(growth.surfaces[view]), starts.front(), center))
    starts.push_back(pose);
  return starts;
}

/// Views placed one after the other upon those that are, the one that agrees best with them first.
void grow(Growth& growth, const std::vector<PairCandidates>& pairs, const std::vector<std::size_t>& usable,
          Context& context) {
  std::vector<std::size_t>& placed = growth.placed;
  std::vector<std::size_t> waiting;
  for (const std::size_t v : usable)
    if (std::find(placed.begin(), placed.end(), v) == placed.end()) waiting.push_back(v);
  std::vector<std::size_t> failed_at(growth.surfaces.size(), 0);  // how many were placed when it failed
  while (!waiting.empty() && !context.cancelled) {
    double best_score = -1e30;
    std::size_t best = waiting.size();
    std::vector<PoseCandidate> best_places;
    for (std::size_t k = 0; k < waiting.size(); ++k) {
      if (failed_at[waiting[k]] == placed.size()) continue;
      std::vector<PoseCandidate> places = places_by_pairs(growth, pairs, waiting[k], placed);
      if (places.empty() || places[0].agreement.score() <= best_score) continue;
      best_score = places[0].agreement.score(), best = k, best_places = std::move(places);
    }
    if (best == waiting.size()) break;
    const std::size_t view = waiting[best];
    if (!growth.place(view, starts_from(growth, best_places, view, placed), placed, false, context)) {
      failed_at[view] = placed.size();
      continue;
    }
    placed.push_back(view);
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(best));
  }
  for (const std::size_t v : waiting)
    if (growth.result.reason[v].empty()) growth.result.reason[v] = "no features like those of another view";
  for (const std::size_t v : placed) growth.result.placed[v] = 1;
}

/// Hardly less than are asked for in the end: of two parts seven of ten views, that were all ten after that.
bool worth_trying_again(std::size_t placed, std::size_t of) { return 5 * placed >= 3 * of; }

/// Views that a part alike from several sides let stand on a wrong one go over, as many together as that takes.
void to_better_sides(Growth& growth, Context& context) {
  constexpr int most_rounds = 4;
  double spacing = 0;
  for (const std::size_t v : growth.placed) spacing = std::max(spacing, growth.surfaces[v].spacing);
  JointOptions adjust;
  adjust.start_reach = 6 * spacing, adjust.contours = growth.options.contours, adjust.roughly = true;
  for (int round = 0; round < most_rounds && !context.cancelled; ++round) {
    std::vector<Pose> poses =
        adjust_jointly(growth.surfaces, growth.result.poses, growth.placed, adjust, context).poses;
    AlikeSides sides = alike_sides(growth.surfaces, poses, growth.placed, context);
    if (sides.better.empty()) return;
    growth.result.poses = std::move(sides.better);
  }
}

/// Of coarse images creases hide what tells the sides of a part apart: of blocks alike from two sides, seen with 60
/// pixels, four of 12 came out with their two halves upon one another or half a turn round where this was not asked.
bool fine_enough(const std::vector<ViewSurface>& surfaces, const std::vector<std::size_t>& views) {
  constexpr double places_in_a_radius = 14;
  std::vector<double> of;
  for (const std::size_t v : views) of.push_back(surfaces[v].radius / surfaces[v].spacing);
  return median(std::move(of)) > places_in_a_radius;
}

/// Each view is tried in other places once all are there: what was best while few were placed need not be so among all.
/// The most contradicted first, until none moves; what fits elsewhere no worse then is not known.
void place_again(Growth& growth, const std::vector<PairCandidates>& pairs, const std::vector<std::size_t>& usable,
                 Context& context) {
  constexpr int most_rounds = 4;
  constexpr double moves = 0.1;  // rad, share of the radius
  growth.nearly_whole = true, growth.either_side = fine_enough(growth.surfaces, usable);
  std::vector<std::size_t>& placed = growth.placed;
  StartResult& result = growth.result;
  std::vector<std::size_t> asked = placed, unsure;
  for (int round = 0; round < most_rounds && placed.size() > 2 && !asked.empty(); ++round) {
    to_better_sides(growth, context);
    std::vector<std::pair<double, std::size_t>> order;
    for (const std::size_t v : asked)
      order.emplace_back(-agreement(growth.surfaces, result.poses, v, result.poses[v], placed, growth.reach, 300)
                              .contradiction_by_all(),
                         v);
    std::sort(order.begin(), order.end());
    bool moved = false;
    unsure.clear();
    for (const auto& [contradiction, view] : order) {
      if (context.cancelled) return;
      std::vector<std::size_t> others = placed;
      std::erase(others, view);
      const Pose before = result.poses[view];
      std::vector<Pose> starts = starts_from(growth, places_by_pairs(growth, pairs, view, others), view, others);
      starts.insert(starts.begin(), before);
      const bool one = growth.place(view, starts, others, true, context);
      if (!one) unsure.push_back(view), result.poses[view] = before;
      const Distance d = distance(growth.surfaces[view], before, result.poses[view]);
      if (d.angle > moves || d.shift > moves * growth.surfaces[view].radius) {
        moved = true;
        context.say("view " + std::to_string(view) + " lies better " + apart(d));
      }
    }
    const std::vector<std::size_t> known = placed;
    grow(growth, pairs, usable, context);
    asked = placed;
    if (moved) continue;
    if (placed.size() == known.size()) break;
    // Those that are sure of their place among fewer are so among more.
    const auto holds = [](const std::vector<std::size_t>& views, std::size_t v) {
      return std::find(views.begin(), views.end(), v) != views.end();
    };
    std::erase_if(asked, [&](std::size_t v) { return holds(known, v) && !holds(unsure, v); });
  }
  for (const std::size_t view : unsure) std::erase(placed, view), result.placed[view] = 0;
}

}  // namespace

StartResult start_from_features(const std::vector<ViewSurface>& surfaces, const RegisterOptions& options,
                                Context& context) {
  const std::size_t n = surfaces.size();
  const std::vector<Pose> none(n);
  const StartResult nothing = StartResult::at(none, false);
  StartResult result = nothing;
  std::vector<std::size_t> usable;
  for (std::size_t v = 0; v < n; ++v)
    if (surfaces[v].usable())
      usable.push_back(v);
    else
      result.reason[v] =
          "expected at least 50 points on smooth surface, found " + std::to_string(surfaces[v].samples.size());
  if (usable.empty()) return result;
  context.report("comparing views", 0);
  std::vector<PairCandidates> pairs = compare_pairs(surfaces, usable, confirm_reach(surfaces), context);
  std::erase_if(pairs, [](const PairCandidates& p) { return p.found.empty(); });
  std::stable_sort(pairs.begin(), pairs.end(), [](const PairCandidates& a, const PairCandidates& b) {
    return a.found[0].agreement.score() > b.found[0].agreement.score();
  });
  // A pair that only seems to fit does not grow far: a few are tried, the largest structure wins.
  std::vector<std::size_t> tried, largest;
  std::size_t most = 0;
  for (const PairCandidates& pair : pairs) {
    if (tried.size() >= 4 || most == usable.size()) break;
    if (std::find(tried.begin(), tried.end(), pair.target) != tried.end()) continue;
    tried.push_back(pair.target);
    Growth growth{surfaces, none, options, 0, confirm_reach(surfaces), {}, nothing, {}, false};
    growth.placed.assign(1, pair.target);
    grow(growth, pairs, usable, context);
    context.say("from view " + std::to_string(pair.target) + ": " + std::to_string(growth.placed.size()) + " placed");
    if (growth.placed.size() > most) most = growth.placed.size(), result = growth.result, largest = growth.placed;
  }
  bool either_side = false;
  if (!worth_trying_again(most, usable.size()) && !largest.empty() && fine_enough(surfaces, usable)) {
    Growth growth{surfaces, none, options, 0, confirm_reach(surfaces), {}, result, largest, false};
    growth.either_side = true;
    grow(growth, pairs, usable, context);
    context.say("with views on either side " + std::to_string(growth.placed.size()) + " placed");
    either_side = growth.placed.size() > most;
    if (either_side) most = growth.placed.size(), result = growth.result, largest = growth.placed;
  }
  if (worth_trying_again(most, usable.size())) {
    Growth growth{surfaces, none, options, 0, confirm_reach(surfaces), {}, std::move(result), largest, false};
    place_again(growth, pairs, usable, context);
    largest = growth.placed, most = largest.size();
    result = std::move(growth.result);
    if (any_in_trouble(surfaces, result.poses, largest)) {
      std::vector<Pose> freed = freed_of_contradictions(surfaces, result.poses, largest, options.contours, context);
      // Beside a view that lies wrong the right ones would be moved for its sake.
      if (!any_in_trouble(surfaces, freed, largest)) result.poses = std::move(freed);
    }
  }
  // Few views that agree among themselves may do so by chance; of many that is unlikely.
  if (!enough_agree(most, usable.size(), either_side)) {
    for (const std::size_t v : usable) {
      result.placed[v] = v == usable.front();
      if (result.placed[v]) continue;
      const std::string own = result.reason[v].empty() ? "" : "; of this view: " + result.reason[v];
      result.reason[v] = "only " + std::to_string(most) + " of " + std::to_string(usable.size()) +
                         " views can be laid over one another by their shapes; expected " +
                         enough_in_words(either_side) + own;
    }
    result.poses = none;
  }
  return result;
}

}  // namespace partscribe::scan
