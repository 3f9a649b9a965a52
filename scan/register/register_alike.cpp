#include "scan/register/register_alike.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/number.h"
#include "core/parallel.h"
#include "scan/register/register_pair.h"
#include "scan/register/register_search.h"
#include "scan/register/register_start.h"

namespace partscribe::scan {
namespace {

/// What two views say to their poses, each asked about the places of the other.
struct Evidence {
  double against = 0;  ///< places
  double shared = 0;   ///< of which they could have said so

  Evidence& operator+=(const Evidence& e) { return against += e.against, shared += e.shared, *this; }
};

/// Where a turn lays the surface of placed views.
struct Onto {
  double on = 0;       ///< share that comes to lie where a view measured a surface
  double against = 0;  ///< share that a view looked through
  /// Of what the views know.
  double share() const { return on + against > 0 ? on / (on + against) : 0; }
  /// Of a part alike from two sides, of whose other side not much needs to be seen.
  bool alike() const { return on > 0.1 && share() > 0.8; }
};

Onto laid_onto_itself(const Placement& placement, const Pose& turn) {
  constexpr std::size_t samples = 1200;
  constexpr double faces = 0.5;  // cosine; what is seen at a slant returns where another surface begins
  Onto result;
  std::vector<Pose> view_from_world;
  double spacing = 0;
  for (const std::size_t v : placement.placed)
    view_from_world.push_back(placement.poses[v].inverse()), spacing = std::max(spacing, placement.surfaces[v].spacing);
  const double margin = 3 * placement.reach + 4 * spacing;
  double all = 0;
  for (const std::size_t v : placement.placed) {
    const Surfels some = strided_surfels(placement.surfaces[v], samples / placement.placed.size());
    const Pose there = turn * placement.poses[v];
    for (std::size_t i = 0; i < some.points.size(); ++i) {
      const Vec3 p = there * some.points[i], n = there.rotation * some.normals[i];
      bool on = false, against = false;
      for (std::size_t w = 0; w < view_from_world.size() && !against; ++w) {
        const SightRaster& raster = placement.surfaces[placement.placed[w]].raster;
        const Vec3 seen = view_from_world[w] * p;
        if (-(view_from_world[w].rotation * n).dot(raster.ray(seen)) < faces) continue;
        const Sight sees = sight(raster, seen, margin);
        on = on || sees == Sight::measured, against = sees == Sight::in_front || sees == Sight::empty;
      }
      ++all, result.on += on && !against, result.against += against;
    }
  }
  if (all > 0) result.on /= all, result.against /= all;
  return result;
}

/// The turns after which placed views look alike.
class Turns {
 public:
  Turns(const Placement& placement, int threads);
  /// One of each family that turns continuously.
  std::vector<Pose> all() const;

 private:
  struct Turn {
    Pose pose;
    double share;
  };
  std::vector<Pose> starts() const;
  /// All the way from one to the other fits as well.
  bool continuous(const Turn& a, const Turn& b) const;
  bool same(const Pose& a, const Pose& b, double within) const;

  const Placement& placement_;
  int threads_;
  double radius_ = 0;
  Vec3 center_ = Vec3::Zero();
  std::unique_ptr<PlacedModel> coarse_, fine_;
  Surfels few_, many_;  // of the models
};

Turns::Turns(const Placement& placement, int threads) : placement_(placement), threads_(threads) {
  double radius = 0, spacing = 0;
  for (const std::size_t v : placement.placed)
    radius = std::max(radius, placement.surfaces[v].radius), spacing = std::max(spacing, placement.surfaces[v].spacing);
  coarse_ =
      place_surfaces(placement.surfaces, placement.poses, placement.placed, std::max(radius / 12, 2 * spacing), true);
  fine_ = place_surfaces(placement.surfaces, placement.poses, placement.placed, 1.5 * spacing);
  few_ = strided_surfels(coarse_->surfels, 400), many_ = strided_surfels(fine_->surfels, 1500);
  for (const Vec3& p : few_.points) center_ += p / static_cast<double>(few_.points.size());
  for (const Vec3& p : few_.points) radius_ += (p - center_).squaredNorm() / static_cast<double>(few_.points.size());
  radius_ = std::sqrt(radius_);
}

/// As a cube and as an icosahedron are turned onto themselves, and about each main axis by what prisms are.
std::vector<Pose> Turns::starts() const {
  const Mat3 axes = main_axes(few_);
  std::vector<Pose> result = symmetric_turns(axes, {}, center_);
  for (const Mat3& turn : turns_all_round()) result.push_back({turn, center_ - turn * center_});
  for (int axis = 0; axis < 3; ++axis)
    for (const int of : {3, 5, 6, 8})
      for (int k = 1; k < of; ++k) result.push_back(rotation_about(center_, axes.col(axis), 2 * pi * k / of));
  return result;
}

bool Turns::same(const Pose& a, const Pose& b, double within) const {
  return rotation_vector(a.rotation.transpose() * b.rotation).norm() < within &&
         (a * center_ - b * center_).norm() < within * radius_;
}

bool Turns::continuous(const Turn& a, const Turn& b) const {
  constexpr double as_well = 0.95;
  for (const double way : {0.25, 0.5, 0.75})
    if (laid_onto_itself(placement_, between(a.pose, b.pose, way)).share() < as_well * std::min(a.share, b.share))
      return false;
  return true;
}

std::vector<Pose> Turns::all() const {
  constexpr double alike = 0.1, another = 0.3;
  const Turn stays{Pose{}, 1};
  AlignOptions rough;
  rough.start_reach = 0.2 * radius_, rough.end_reach = coarse_->cell, rough.noise = 0.1 * coarse_->cell,
  rough.iterations = 40;
  AlignOptions exact;
  exact.start_reach = 2 * coarse_->cell, exact.end_reach = fine_->cell, exact.noise = 0.02 * fine_->cell;
  std::vector<Pose> found = starts();
  const auto align = [&](const Surfels& source, const PlacedModel& model, const AlignOptions& options) {
    parallel_for(
        found.size(), threads_,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t k = begin; k < end; ++k) found[k] = align_symmetric(source, model, found[k], options);
        },
        1);
    std::vector<Pose> once;
    for (const Pose& pose : found)
      if (!same(pose, {}, another) &&
          std::none_of(once.begin(), once.end(), [&](const Pose& o) { return same(pose, o, alike); }))
        once.push_back(pose);
    found = std::move(once);
  };
  align(few_, *coarse_, rough), align(few_, *fine_, exact);
  exact.start_reach = exact.end_reach;
  align(many_, *fine_, exact);
  std::vector<Turn> turns;
  for (const Pose& pose : found)
    if (const Onto onto = laid_onto_itself(placement_, pose); onto.alike()) turns.push_back({pose, onto.share()});
  std::stable_sort(turns.begin(), turns.end(), [](const Turn& a, const Turn& b) { return a.share > b.share; });
  std::vector<Turn> families;
  for (const Turn& turn : turns)
    if (!continuous(stays, turn) &&
        std::none_of(families.begin(), families.end(), [&](const Turn& f) { return continuous(f, turn); }))
      families.push_back(turn);
  constexpr std::size_t most = 24;
  std::vector<Pose> result;
  for (std::size_t k = 0; k < std::min(most, families.size()); ++k) result.push_back(families[k].pose);
  return result;
}

/// Of every two views: the first turned, the other as it lies.
using Table = std::vector<std::vector<Evidence>>;

/// What `other` says to the places of a view that is turned.
Evidence asked(const Placement& placement, std::size_t view, const Pose& turn, std::size_t other) {
  constexpr std::size_t samples = 1000;
  const Agreement found = agreement(placement.surfaces, placement.poses, view, turn * placement.poses[view], {other},
                                    placement.reach, samples, Creases::left_out);
  return {double(found.odd + found.through + found.missing()), double(found.faced + found.through)};
}

Table evidence(const Placement& placement, const Pose& turn, int threads) {
  const std::size_t n = placement.placed.size();
  const Pose back = turn.inverse();
  Table table(n, std::vector<Evidence>(n));
  parallel_for(
      n * n, threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const std::size_t a = k / n, b = k % n, v = placement.placed[a], w = placement.placed[b];
          if (a == b) continue;
          table[a][b] = asked(placement, v, turn, w);
          table[a][b] += asked(placement, w, back, v);
        }
      },
      1);
  return table;
}

Table transposed(const Table& table) {
  Table result = table;
  for (std::size_t a = 0; a < table.size(); ++a)
    for (std::size_t b = 0; b < table.size(); ++b) result[a][b] = table[b][a];
  return result;
}

/// Which of the turns each view is turned by; 0 is none.
using Sides = std::vector<std::size_t>;

/// What changes if some views are turned.
struct Change {
  double more = 0;  ///< against it than against the views as they lie, beyond what usually speaks against right poses
  double variance = 0;
  /// By how many places it is worse beyond chance, and better; a few places more or less are nothing.
  double surely_worse() const { return more - chance(); }
  double surely_better() const { return -more - chance(); }

 private:
  double chance() const { return 4 * std::sqrt(variance + 4); }
};

/// All ways to share the views between the sides of a part. What two views say hangs on the turn between them alone.
class Arrangements {
 public:
  Arrangements(const Placement& placement, const std::vector<Pose>& alike, Context& context);
  std::size_t views() const { return views_; }
  std::size_t turns() const { return poses_.size(); }
  const Pose& turn(std::size_t t) const { return poses_[t]; }

  /// The best that is reached from `sides` by moving one view after the other; the `held` stay.
  Sides improved(Sides sides, const std::vector<std::size_t>& held) const;
  Change change(const Sides& from, const Sides& to) const;
  /// The same arrangement, seen from the side where most views are.
  Sides from_most(const Sides& sides) const;

 private:
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::size_t find(const Pose& turn) const;
  /// The same for b and a; nothing if no turn is known that leads from the one side to the other.
  const Evidence* between(std::size_t a, std::size_t side_a, std::size_t b, std::size_t side_b) const {
    if (a < b) std::swap(a, b), std::swap(side_a, side_b);
    const std::size_t turn = after_[side_b][side_a];
    return turn == none ? nullptr : &tables_[turn][a][b];
  }
  /// Of a view on each side beside another on one; what no turn is known for is not allowed.
  const double* costs(std::size_t view, std::size_t other, std::size_t side) const {
    return &costs_[((view * views() + other) * turns() + side) * turns()];
  }

  std::size_t views_;
  double size_ = 0;
  Vec3 center_ = Vec3::Zero();
  std::vector<Pose> poses_;
  std::vector<Table> tables_;                    // of every turn
  std::vector<std::vector<std::size_t>> after_;  // [b][a]: which turn leads from side b to side a
  std::vector<double> costs_;                    // [view][other][side of other][side of view]
  double usual_ = 0;
};

Arrangements::Arrangements(const Placement& placement, const std::vector<Pose>& alike, Context& context)
    : views_(placement.placed.size()) {
  for (const std::size_t v : placement.placed) {
    center_ += placement.poses[v] * placement.surfaces[v].center / static_cast<double>(views_);
    size_ = std::max(size_, placement.surfaces[v].radius);
  }
  poses_.push_back({}), tables_.push_back(evidence(placement, {}, context.threads));
  for (const Pose& turn : alike) {
    if (context.cancelled) break;
    if (find(turn) != none) continue;
    poses_.push_back(turn), tables_.push_back(evidence(placement, turn, context.threads));
    if (find(turn.inverse()) == none) poses_.push_back(turn.inverse()), tables_.push_back(transposed(tables_.back()));
  }
  Evidence all;
  for (const auto& row : tables_[0])
    for (const Evidence& e : row) all += e;
  usual_ = all.shared > 0 ? all.against / all.shared : 0;
  for (const Pose& b : poses_) {
    after_.emplace_back();
    for (const Pose& a : poses_) after_.back().push_back(find(b.inverse() * a));
  }
  // Found turns are not quite each other's inverses.
  for (std::size_t b = 0; b < turns(); ++b)
    for (std::size_t a = 0; a < b; ++a)
      if (after_[b][a] == none || after_[a][b] == none) after_[b][a] = after_[a][b] = none;
  constexpr double not_allowed = 1e7;
  costs_.reserve(views() * views() * turns() * turns());
  for (std::size_t a = 0; a < views(); ++a)
    for (std::size_t b = 0; b < views(); ++b)
      for (std::size_t side_b = 0; side_b < turns(); ++side_b)
        for (std::size_t side_a = 0; side_a < turns(); ++side_a) {
          const Evidence* e = between(a, side_a, b, side_b);
          costs_.push_back(a == b ? 0 : e ? e->against - usual_ * e->shared : not_allowed);
        }
}

std::size_t Arrangements::find(const Pose& turn) const {
  constexpr double same = 0.05;  // rad, share of the radius
  for (std::size_t t = 0; t < poses_.size(); ++t)
    if (rotation_vector(poses_[t].rotation.transpose() * turn.rotation).norm() < same &&
        (poses_[t] * center_ - turn * center_).norm() < same * size_)
      return t;
  return none;
}

Sides Arrangements::improved(Sides sides, const std::vector<std::size_t>& held) const {
  for (;;) {
    // What each view costs on each side while the others stay where they are.
    std::vector<double> sum(views() * turns(), 0);
    for (std::size_t v = 0; v < views(); ++v)
      for (std::size_t w = 0; w < views(); ++w)
        for (std::size_t s = 0; s < turns(); ++s) sum[v * turns() + s] += costs(v, w, sides[w])[s];
    // Every view moves once, for better or worse, the best move first: what several do together is found so.
    std::vector<std::uint8_t> stays(views(), 0);
    for (const std::size_t v : held) stays[v] = 1;
    Sides moved = sides, best = sides;
    double so_far = 0, least = -0.01;  // of a place
    for (std::size_t step = held.size(); step < views(); ++step) {
      std::size_t view = none, side = 0;
      double more = 0;
      for (std::size_t v = 0; v < views(); ++v)
        for (std::size_t s = 0; s < turns() && !stays[v]; ++s)
          if (const double change = sum[v * turns() + s] - sum[v * turns() + moved[v]];
              s != moved[v] && (view == none || change < more))
            view = v, side = s, more = change;
      if (view == none) break;
      for (std::size_t w = 0; w < views(); ++w)
        for (std::size_t s = 0; s < turns(); ++s)
          sum[w * turns() + s] += costs(w, view, side)[s] - costs(w, view, moved[view])[s];
      moved[view] = side, stays[view] = 1, so_far += more;
      if (so_far < least) least = so_far, best = moved;
    }
    if (best == sides) return sides;
    sides = best;
  }
}

Change Arrangements::change(const Sides& from, const Sides& to) const {
  Change change;
  for (std::size_t a = 0; a < views(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const Evidence *before = between(a, from[a], b, from[b]), *after = between(a, to[a], b, to[b]);
      if (before == after) continue;
      if (!after) return {1e9, 0};
      change.more += after->against - before->against - usual_ * (after->shared - before->shared);
      change.variance += after->against + before->against;
    }
  return change;
}

Sides Arrangements::from_most(const Sides& sides) const {
  std::vector<std::size_t> count(turns(), 0);
  for (const std::size_t s : sides) ++count[s];
  const auto most = static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
  Sides result;
  for (const std::size_t s : sides) result.push_back(after_[most][s]);
  return result;
}

}  // namespace

bool alike_after(const Placement& placement, const Pose& motion) { return laid_onto_itself(placement, motion).alike(); }

bool AlikeSides::any_open() const {
  return std::any_of(turns.begin(), turns.end(), [](const AlikeTurn& t) { return !t.open.empty(); });
}

AlikeSides alike_sides(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                       const std::vector<std::size_t>& views, Context& context) {
  AlikeSides result;
  if (views.size() < 2) return result;
  const Placement placement{surfaces, poses, views, confirm_reach(surfaces)};
  const std::vector<Pose> turns = Turns(placement, context.threads).all();
  if (turns.empty()) return result;
  const Arrangements arrangements(placement, turns, context);
  if (context.cancelled) return result;
  // With one view turned and another not: the best of all others.
  const std::size_t n = views.size();
  const auto others = [&](const Sides& from) {
    constexpr std::size_t most_fixed = 12;
    const std::size_t stride = std::max<std::size_t>(1, n / most_fixed);
    std::vector<Sides> found;
    for (std::size_t fixed = 0; fixed < n; fixed += stride)
      for (std::size_t v = 0; v < n; ++v)
        for (std::size_t t = 1; t < arrangements.turns() && v != fixed; ++t) {
          Sides sides = from;
          sides[v] = t;
          found.push_back(arrangements.improved(std::move(sides), {fixed, v}));
        }
    return found;
  };
  const Sides now(n, 0);
  Sides best = now;
  std::vector<Sides> found = others(now);
  const auto better = [&] {
    const Sides* most = nullptr;
    double gain = 0;
    for (const Sides& sides : found)
      if (const double g = arrangements.change(best, sides).surely_better(); g > gain) gain = g, most = &sides;
    if (most) best = Sides(*most);
    return most != nullptr;
  };
  while (better()) found = others(best);
  if (best != now) {
    const Pose back = arrangements.turn(best[0]).inverse();
    result.better = poses;
    for (std::size_t k = 0; k < n; ++k)
      if (best[k] != best[0]) result.better[views[k]] = back * arrangements.turn(best[k]) * poses[views[k]];
  }
  for (std::size_t t = 1; t < arrangements.turns(); ++t) result.turns.push_back({arrangements.turn(t), {}});
  std::vector<std::vector<std::uint8_t>> open(arrangements.turns(), std::vector<std::uint8_t>(n, 0));
  for (const Sides& sides : found) {
    if (arrangements.change(best, sides).surely_worse() > 0) continue;
    const Sides seen = arrangements.from_most(sides);
    for (std::size_t k = 0; k < n; ++k)
      if (seen[k] != 0) open[seen[k]][k] = 1;
  }
  for (std::size_t t = 1; t < arrangements.turns(); ++t) {
    std::string names;
    for (std::size_t k = 0; k < n; ++k)
      if (open[t][k]) result.turns[t - 1].open.push_back(views[k]), names += " " + std::to_string(views[k]);
    context.say("alike after a turn by " +
                print_number(rotation_vector(arrangements.turn(t).rotation).norm() * 180 / pi) + " degrees: open" +
                names);
  }
  std::string moved;
  for (const std::size_t s : best) moved += " " + std::to_string(s);
  if (best != now) context.say("better on sides" + moved);
  return result;
}

}  // namespace partscribe::scan
