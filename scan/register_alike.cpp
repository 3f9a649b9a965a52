#include "scan/register_alike.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/number.h"
#include "core/parallel.h"
#include "scan/register_pair.h"
#include "scan/register_search.h"
#include "scan/register_start.h"

namespace partscribe {
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
  for (const std::size_t v : placement.placed) view_from_world.push_back(placement.poses[v].inverse()), spacing = std::max(spacing, placement.surfaces[v].spacing);
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
  for (const std::size_t v : placement.placed) radius = std::max(radius, placement.surfaces[v].radius), spacing = std::max(spacing, placement.surfaces[v].spacing);
  coarse_ = place_surfaces(placement.surfaces, placement.poses, placement.placed, std::max(radius / 12, 2 * spacing), true);
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
  return rotation_vector(a.rotation.transpose() * b.rotation).norm() < within && (a * center_ - b * center_).norm() < within * radius_;
}

bool Turns::continuous(const Turn& a, const Turn& b) const {
  constexpr double as_well = 0.95;
  for (const double way : {0.25, 0.5, 0.75})
    if (laid_onto_itself(placement_, between(a.pose, b.pose, way)).share() < as_well * std::min(a.share, b.share)) return false;
  return true;
}

std::vector<Pose> Turns::all() const {
  constexpr double alike = 0.1, another = 0.3;
  const Turn stays{Pose{}, 1};
  AlignOptions rough;
  rough.start_reach = 0.2 * radius_, rough.end_reach = coarse_->cell, rough.noise = 0.1 * coarse_->cell, rough.iterations = 40;
  AlignOptions exact;
  exact.start_reach = 2 * coarse_->cell, exact.end_reach = fine_->cell, exact.noise = 0.02 * fine_->cell;
  std::vector<Pose> found = starts();
  const auto align = [&](const Surfels& source, const PlacedModel& model, const AlignOptions& options) {
    parallel_for(found.size(), threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) found[k] = align_symmetric(source, model, found[k], options);
    }, 1);
    std::vector<Pose> once;
    for (const Pose& pose : found)
      if (!same(pose, {}, another) && std::none_of(once.begin(), once.end(), [&](const Pose& o) { return same(pose, o, alike); })) once.push_back(pose);
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
    if (!continuous(stays, turn) && std::none_of(families.begin(), families.end(), [&](const Turn& f) { return continuous(f, turn); })) families.push_back(turn);
  std::vector<Pose> result;
  for (const Turn& turn : families) result.push_back(turn.pose);
  return result;
}

/// Of every two views: as they lie, and with the first of them turned.
using Table = std::vector<std::vector<Evidence>>;

/// What `other` says to the places of a view that is turned.
Evidence asked(const Placement& placement, std::size_t view, const Pose& turn, std::size_t other) {
  constexpr std::size_t samples = 1000;
  const Agreement found = agreement(placement.surfaces, placement.poses, view, turn * placement.poses[view], {other}, placement.reach, samples, Creases::left_out);
  return {double(found.odd + found.through + found.missing()), double(found.faced + found.through)};
}

Table evidence(const Placement& placement, const Pose& turn, int threads) {
  const std::size_t n = placement.placed.size();
  const Pose back = turn.inverse();
  Table table(n, std::vector<Evidence>(n));
  parallel_for(n * n, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t a = k / n, b = k % n, v = placement.placed[a], w = placement.placed[b];
      if (a == b) continue;
      table[a][b] = asked(placement, v, turn, w);
      table[a][b] += asked(placement, w, back, v);
    }
  }, 1);
  return table;
}

/// What changes if some views are turned.
struct Change {
  double more = 0;      ///< against it than against the views as they lie, beyond what usually speaks against right poses
  double variance = 0;
  /// By how many places it is worse beyond chance, and better; a few places more or less are nothing.
  double surely_worse() const { return more - chance(); }
  double surely_better() const { return -more - chance(); }

 private:
  double chance() const { return 4 * std::sqrt(variance + 4); }
};

/// Some of the views turned, the others not.
class Arrangements {
 public:
  Arrangements(const Table& now, const Table& turned) : now_(now), turned_(turned) {
    Evidence all;
    for (const auto& row : now)
      for (const Evidence& e : row) all += e;
    usual_ = all.shared > 0 ? all.against / all.shared : 0;
  }
  std::size_t views() const { return now_.size(); }

  Change of(const std::vector<std::uint8_t>& side) const {
    Change change;
    for (std::size_t a = 0; a < views(); ++a)
      for (std::size_t b = 0; b < views(); ++b) {
        if (!side[a] || side[b]) continue;
        const Evidence &before = now_[a][b], &after = turned_[a][b];
        change.more += after.against - before.against - usual_ * (after.shared - before.shared);
        change.variance += after.against + before.against;
      }
    return change;
  }

  /// The least that speaks against turning no more than half of the views, one of them `first`: others follow it one by one, each the
  /// one with which least does.
  std::pair<Change, std::vector<std::uint8_t>> least(std::size_t first) const {
    std::vector<std::uint8_t> side(views(), 0), best;
    side[first] = 1;
    Change least = of(side);
    best = side;
    for (std::size_t count = 2; 2 * count <= views(); ++count) {
      std::size_t next = views();
      Change with_next;
      for (std::size_t v = 0; v < views(); ++v) {
        if (side[v]) continue;
        side[v] = 1;
        const Change change = of(side);
        side[v] = 0;
        if (next == views() || change.more < with_next.more) next = v, with_next = change;
      }
      side[next] = 1;
      if (with_next.surely_worse() < least.surely_worse()) least = with_next, best = side;
    }
    return {least, best};
  }

 private:
  const Table &now_, &turned_;
  double usual_ = 0;
};

}  // namespace

bool alike_after(const Placement& placement, const Pose& motion) { return laid_onto_itself(placement, motion).alike(); }

std::vector<AlikeTurn> alike_turns(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses, const std::vector<std::size_t>& views,
                                   Context& context) {
  std::vector<AlikeTurn> result;
  if (views.size() < 2) return result;
  const Placement placement{surfaces, poses, views, confirm_reach(surfaces)};
  const std::vector<Pose> turns = Turns(placement, context.threads).all();
  if (turns.empty()) return result;
  const Table now = evidence(placement, {}, context.threads);
  for (const Pose& turn : turns) {
    if (context.cancelled) break;
    const Table turned = evidence(placement, turn, context.threads);
    const Arrangements arrangements(now, turned);
    AlikeTurn alike;
    alike.turn = turn;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const auto [change, side] = arrangements.least(v);
      if (change.surely_worse() <= 0) alike.open.push_back(views[v]);
      const double gain = change.surely_better();
      if (gain <= alike.gain) continue;
      alike.gain = gain, alike.better.clear();
      for (std::size_t k = 0; k < views.size(); ++k)
        if (side[k]) alike.better.push_back(views[k]);
    }
    std::string names, better;
    for (const auto v : alike.open) names += " " + std::to_string(v);
    for (const auto v : alike.better) better += " " + std::to_string(v);
    context.say("alike after a turn by " + print_number(rotation_vector(turn.rotation).norm() * 180 / pi) + " degrees: open" + names + ", better turned" + better);
    result.push_back(std::move(alike));
  }
  return result;
}

bool to_better_side(const std::vector<AlikeTurn>& turns, const std::vector<std::size_t>& views, std::vector<Pose>& poses) {
  const AlikeTurn* best = nullptr;
  for (const AlikeTurn& turn : turns)
    if (turn.gain > (best ? best->gain : 0)) best = &turn;
  if (!best) return false;
  const auto turned = [&](std::size_t v) { return std::find(best->better.begin(), best->better.end(), v) != best->better.end(); };
  const bool others = turned(views.front());
  const Pose motion = others ? best->turn.inverse() : best->turn;
  for (const std::size_t v : views)
    if (turned(v) != others) poses[v] = motion * poses[v];
  return true;
}

}  // namespace partscribe
