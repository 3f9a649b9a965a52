#include "scan/register/register_pair.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/statistics.h"
#include "geometry/decompose.h"
#include "geometry/points/nearest_again.h"

namespace partscribe::scan {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// Cube, and which way the normal faces, so that the two sides of a thin wall stay apart.
using Cell = std::array<std::int64_t, 4>;

Cell cell_of(const Vec3& p, const Vec3& n, double size) {
  int axis = 0;
  n.cwiseAbs().maxCoeff(&axis);
  const auto k = [&](double x) { return static_cast<std::int64_t>(std::floor(x / size)); };
  return {k(p.x()), k(p.y()), k(p.z()), axis * 2 + (n[axis] > 0)};
}

/// `count` of `n` at equal strides, each by its index.
template <class IndexOf>
Surfels strided(std::size_t n, std::size_t count, const IndexOf& index_of, const std::vector<Vec3>& points,
                const std::vector<Vec3>& normals) {
  Surfels result;
  const std::size_t some = std::min(count, n);
  for (std::size_t k = 0; k < some; ++k) {
    const auto i = index_of((2 * k + 1) * n / (2 * some));
    result.points.push_back(points[i]), result.normals.push_back(normals[i]);
  }
  return result;
}

}  // namespace

Vec3 rotation_vector(const Mat3& rotation) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(rotation).normalized());
  return turn.angle() * turn.axis();
}

FixedLine fixed_line(const Pose& rotation, const Vec3& near) {
  const Vec3 turn = rotation_vector(rotation.rotation);
  const double angle = turn.norm();
  const Vec3 axis = turn / std::max(angle, 1e-12);
  const Vec3 moved = rotation * near - near;
  const Vec3 across = moved - moved.dot(axis) * axis;
  return {near + 0.5 * (across + axis.cross(across) / std::tan(0.5 * angle)), axis, angle};
}

Pose rotation_about(const Vec3& point, const Vec3& axis, double angle) {
  const Mat3 r = rotation_of(angle * axis);
  return {r, point - r * point};
}

Pose between(const Pose& a, const Pose& b, double share) {
  const Pose change = b * a.inverse();
  const Vec3 turn = rotation_vector(change.rotation);
  const double sq = turn.squaredNorm();
  if (sq < 1e-12) return {a.rotation, a.translation + share * change.translation};
  // (1 - R) point = the part of the shift across the axis.
  const Vec3 along = turn.dot(change.translation) / sq * turn, across = change.translation - along;
  const Vec3 axis = turn / std::sqrt(sq);
  const Vec3 point = 0.5 * (across + axis.cross(across) / std::tan(0.5 * std::sqrt(sq)));
  const Mat3 rotation = rotation_of(share * turn);
  return Pose{rotation, point - rotation * point + share * along} * a;
}

Surfels sample_surfels(const ViewSurface& surface, std::size_t count) {
  Surfels result;
  for (const auto i : spread_sample(surface.points, surface.normals, surface.samples, count))
    result.points.push_back(surface.points[i]), result.normals.push_back(surface.normals[i]);
  return result;
}

Surfels strided_surfels(const ViewSurface& surface, std::size_t count) {
  return strided(
      surface.samples.size(), count, [&](std::size_t k) { return surface.samples[k]; }, surface.points,
      surface.normals);
}

Surfels strided_surfels(const Surfels& all, std::size_t count) {
  return strided(
      all.points.size(), count, [](std::size_t k) { return k; }, all.points, all.normals);
}

namespace {

struct CellSum {
  Cell cell{};
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  int count = 0;
};

/// Sums by cell, in the order in which the cells were met; means_of puts them in theirs.
class CellSums {
 public:
  const std::vector<CellSum>& all() const { return sums_; }

  /// Stays until another cell is asked for.
  CellSum& at(const Cell& cell) {
    if (2 * sums_.size() >= slots_.size()) grow();
    const std::size_t slot = slot_of(cell);
    if (slots_[slot] == 0) sums_.emplace_back().cell = cell, slots_[slot] = static_cast<std::uint32_t>(sums_.size());
    return sums_[slots_[slot] - 1];
  }

 private:
  std::size_t slot_of(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t k : cell)
      hash = (hash ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15ull, hash ^= hash >> 32;
    std::size_t slot = hash & (slots_.size() - 1);
    while (slots_[slot] != 0 && sums_[slots_[slot] - 1].cell != cell) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }
  void grow() {
    slots_.assign(slots_.empty() ? 4096 : 4 * slots_.size(), 0);
    for (std::uint32_t i = 0; i < sums_.size(); ++i) slots_[slot_of(sums_[i].cell)] = i + 1;
  }
  std::vector<CellSum> sums_;
  std::vector<std::uint32_t> slots_;  // a power of two; index in `sums_` and one
};

void add_cells(const ViewSurface& surface, const Pose& pose, double cell, CellSums& cells) {
  Cell last{};
  CellSum* sum = nullptr;  // neighbours mostly share their cell
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Vec3 p = pose * surface.points[i], n = pose.rotation * surface.normals[i];
    const Cell key = cell_of(p, n, cell);
    if (!sum || key != last) sum = &cells.at(key), last = key;
    sum->point += p, sum->normal += n, ++sum->count;
  }
}

std::vector<OrientedPoint> oriented(const Surfels& surfels) {
  std::vector<OrientedPoint> result;
  result.reserve(surfels.points.size());
  for (std::size_t i = 0; i < surfels.points.size(); ++i)
    result.push_back(oriented_point(surfels.points[i], surfels.normals[i]));
  return result;
}

/// By coordinates, then by direction.
std::vector<std::uint32_t> in_order(const std::vector<CellSum>& sums) {
  struct Keyed {
    std::uint64_t key;
    std::uint32_t index;
  };
  constexpr std::int64_t most = std::int64_t(1) << 20;
  Cell low{}, high{};
  for (std::size_t i = 0; i < sums.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k)
      low[k] = std::min(i ? low[k] : sums[i].cell[k], sums[i].cell[k]),
      high[k] = std::max(i ? high[k] : sums[i].cell[k], sums[i].cell[k]);
  const bool fits =
      high[0] - low[0] < most && high[1] - low[1] < most && high[2] - low[2] < most;  // of the direction there are six
  std::vector<Keyed> keyed(sums.size());
  for (std::uint32_t i = 0; i < sums.size(); ++i) {
    std::uint64_t key = 0;
    for (std::size_t k = 0; fits && k < 4; ++k)
      key = (k < 3 ? key << 20 : key << 3) | static_cast<std::uint64_t>(sums[i].cell[k] - low[k]);
    keyed[i] = {key, i};
  }
  if (fits)
    std::sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
  else
    std::sort(keyed.begin(), keyed.end(),
              [&](const Keyed& a, const Keyed& b) { return sums[a.index].cell < sums[b.index].cell; });
  std::vector<std::uint32_t> result(sums.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) result[i] = keyed[i].index;
  return result;
}

Surfels means_of(const CellSums& cells) {
  Surfels result;
  result.points.reserve(cells.all().size()), result.normals.reserve(cells.all().size());
  for (const std::uint32_t i : in_order(cells.all())) {
    const CellSum& sum = cells.all()[i];
    result.points.push_back(sum.point / sum.count), result.normals.push_back(sum.normal.normalized());
  }
  return result;
}

}  // namespace

Surfels thin_surfels(const ViewSurface& surface, double cell) {
  CellSums cells;
  add_cells(surface, {}, cell, cells);
  return means_of(cells);
}

std::unique_ptr<PlacedModel> place_surfaces(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                                            const std::vector<std::size_t>& views, double cell, bool mapped) {
  CellSums cells;
  for (const std::size_t v : views) add_cells(surfaces[v], poses[v], cell, cells);
  auto model = std::make_unique<PlacedModel>();
  model->cell = cell, model->surfels = means_of(cells);
  model->oriented = oriented(model->surfels);
  model->tree = std::make_unique<KdTree>(model->surfels.points);
  if (mapped && !model->surfels.points.empty())
    model->map = std::make_unique<NearestMap>(model->surfels.points, 0.5 * cell, 150000);
  return model;
}

namespace {

/// The normal equations of sources against targets; rotations about an origin, times a size.
struct PairEquations {
  Mat6 h = Mat6::Zero();
  Vec6 g = Vec6::Zero();
  double weights = 0;

  explicit PairEquations(const SymmetricSums& sums) {
    std::size_t at = 0;
    for (int i = 0; i < 6; ++i)
      for (int j = i; j < 6; ++j) h(i, j) = h(j, i) = sums.values[at++];
    for (int i = 0; i < 6; ++i) g[i] = sums.values[at++];
    weights = sums.values[at];
  }

  /// Towards the optimum, but not along directions that are fixed by less than `weak` of what the best one is.
  Vec6 step(double weak) const {
    // The trace of h bounds its largest eigenvalue, the size of its inverse the smallest: mostly that is enough.
    const Eigen::LLT<Mat6> factors(h);
    if (factors.info() == Eigen::Success) {
      const Mat6 inverse = factors.solve(Mat6::Identity());
      if (1 > std::max(weak * h.trace(), 1e-12) * inverse.norm()) return inverse * g;
    }
    const auto eigen = eigensystem(h);
    Vec6 result = Vec6::Zero();
    for (int k = 0; k < 6; ++k)
      if (eigen.values[k] > std::max(weak * eigen.values[5], 1e-12))
        result += eigen.vectors.col(k) * (eigen.vectors.col(k).dot(g) / eigen.values[k]);
    return result;
  }
};

SymmetricRule rule_at(const Pose& pose, const Vec3& origin, double size, double reach, double noise) {
  return {pose, origin, size, reach, std::max(reach / 2, 3 * noise)};
}

/// One source and where its points have their partners.
class Partners {
 public:
  explicit Partners(const AlignPair& pair)
      : source_(pair.source),
        target_(pair.target),
        oriented_(oriented(*pair.source)),
        again_(*target_->tree, target_->surfels.points, target_->map ? 0 : oriented_.size()),
        from_(oriented_.size()),
        to_(oriented_.size()) {}

  void add(const SymmetricRule& rule, SymmetricSums& sums) {
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < oriented_.size(); ++i) {
      const Vec3 x = rule.target_from_source * source_->points[i];
      const std::uint32_t to =
          target_->map ? target_->map->near(x.x(), x.y(), x.z()) : again_.nearest(i, x, 3 * rule.reach);
      from_[count] = i, to_[count] = to;
      count += to != NearestAgain::nobody;
    }
    add_symmetric(oriented_.data(), target_->oriented.data(), from_.data(), to_.data(), count, rule, sums);
  }

 private:
  const Surfels* source_;
  const PlacedModel* target_;
  std::vector<OrientedPoint> oriented_;
  NearestAgain again_;
  std::vector<std::uint32_t> from_, to_;
};

}  // namespace

Pose align_symmetric(const std::vector<AlignPair>& pairs, const Pose& start, const AlignOptions& options) {
  Pose pose = start;
  Vec3 middle = Vec3::Zero();
  std::size_t count = 0;
  for (const AlignPair& pair : pairs) {
    if (pair.target->surfels.points.empty()) return pose;
    for (const Vec3& p : pair.source->points) middle += p;
    count += pair.source->points.size();
  }
  if (count == 0) return pose;
  middle /= static_cast<double>(count);
  double size = 0;
  for (const AlignPair& pair : pairs)
    for (const Vec3& p : pair.source->points) size += (p - middle).squaredNorm();
  size = std::max(std::sqrt(size / static_cast<double>(count)), 1e-9);
  std::vector<Partners> partners(pairs.begin(), pairs.end());
  double reach = options.start_reach;
  int at_reach = 0;
  for (int round = 0; round < options.iterations; ++round) {
    const Vec3 origin = pose * middle;
    SymmetricSums sums;
    for (Partners& p : partners) p.add(rule_at(pose, origin, size, reach, options.noise), sums);
    const PairEquations sum(sums);
    if (sum.weights < 6 && reach >= options.start_reach && at_reach > 2) break;
    const Vec6 step = sum.step(3e-4);
    Vec3 turn = step.head<3>() / size, shift = step.tail<3>();
    if (turn.norm() > 0.3) turn *= 0.3 / turn.norm();
    if (shift.norm() > 2 * reach) shift *= 2 * reach / shift.norm();
    const Mat3 rotation = rotation_of(turn);
    pose = Pose{rotation, origin + shift - rotation * origin} * pose;
    if (options.pure_rotation) {
      const Vec3 axis = rotation_vector(pose.rotation).normalized();
      pose.translation -= axis.dot(pose.translation) * axis;
      if (options.angle > 0) {
        const FixedLine line = fixed_line(pose, origin);
        pose = rotation_about(line.point, line.axis, options.angle);
      }
    }
    const double moved = turn.norm() * size + shift.norm();
    ++at_reach;
    const bool last = reach <= options.end_reach;
    if (last && (moved < options.settled * options.end_reach || at_reach > 15)) break;
    if (!last && (moved < 0.1 * reach || at_reach >= 5)) reach = std::max(0.6 * reach, options.end_reach), at_reach = 0;
  }
  return pose;
}

Pose align_symmetric(const Surfels& source, const PlacedModel& target, const Pose& start, const AlignOptions& options) {
  return align_symmetric({{&source, &target}}, start, options);
}

std::vector<WeakMotion> weak_motions(const Surfels& source, const PlacedModel& target, const Pose& pose, double reach,
                                     double noise, double weak) {
  std::vector<WeakMotion> result;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : source.points) middle += p / static_cast<double>(source.points.size());
  double size = 0;
  for (const Vec3& p : source.points) size += (p - middle).squaredNorm();
  size = std::max(std::sqrt(size / static_cast<double>(std::max<std::size_t>(source.points.size(), 1))), 1e-9);
  SymmetricSums sums;
  Partners(AlignPair{&source, &target}).add(rule_at(pose, pose * middle, size, reach, noise), sums);
  const PairEquations sum(sums);
  const auto eigen = eigensystem(sum.h);
  for (int k = 0; k < 3 && eigen.values[k] < weak * eigen.values[5]; ++k)
    result.push_back({pose * middle, eigen.vectors.col(k).head<3>() / size, eigen.vectors.col(k).tail<3>()});
  return result;
}

namespace {

constexpr double same_face = 0.866;  // cosine of two normals

/// Of a place where the nearest of the other view is another surface: whether there is a crease beside it, and one of
/// the faces there is within `reach` the same in both views.
bool meet_at_crease(const ViewSurface& own, const Vec3& own_place, const ViewSurface& other, const Pose& other_from_own,
                    double reach) {
  constexpr std::size_t around = 12;  // two pixels each way
  std::vector<Neighbour> mine, theirs;
  own.nearest(own_place, around, mine);
  other.nearest(other_from_own * own_place, around, theirs);
  const auto creased = [](const ViewSurface& surface, const std::vector<Neighbour>& near) {
    return std::any_of(near.begin(), near.end(), [&](const Neighbour& k) {
      return surface.normals[k.index].dot(surface.normals[near.front().index]) < same_face;
    });
  };
  if (!creased(own, mine) && !creased(other, theirs)) return false;
  for (const Neighbour& i : mine) {
    const Vec3 p = other_from_own * own.points[i.index], n = other_from_own.rotation * own.normals[i.index];
    for (const Neighbour& j : theirs)
      if (n.dot(other.normals[j.index]) > same_face &&
          std::abs((p - other.points[j.index]).dot(other.normals[j.index])) < reach)
        return true;
  }
  return false;
}

}  // namespace

Agreement agreement(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses, std::size_t view,
                    const Pose& pose, const std::vector<std::size_t>& others, double reach, std::size_t samples,
                    Creases creases) {
  Agreement result;
  const Surfels mine = strided_surfels(surfaces[view], samples);
  result.samples = static_cast<int>(mine.points.size());
  result.missing_by.assign(surfaces.size(), 0);
  std::vector<std::uint8_t> confirmed(mine.points.size(), 0);
  std::vector<double> residuals, best(mine.points.size(), 1e30);
  for (const std::size_t o : others) {
    if (o == view || !surfaces[o].usable()) continue;
    const ViewSurface& other = surfaces[o];
    const Pose there = poses[o].inverse() * pose;
    const double margin = 3 * reach + 2 * std::max(other.spacing, surfaces[view].spacing);
    int through = 0, missing = 0, back = 0;
    for (std::size_t i = 0; i < mine.points.size(); ++i) {
      const Vec3 p = there * mine.points[i], n = there.rotation * mine.normals[i];
      const double facing = -n.dot(other.raster.ray(p));
      switch (sight(other.raster, p, margin)) {
        case Sight::in_front:
          ++through;
          continue;
        case Sight::empty:
          missing += facing > 0.6;
          continue;
        case Sight::measured:
          break;
        default:
          continue;
      }
      if (facing < 0.3) continue;
      const Neighbour near = other.nearest(p);
      const bool must_return = facing > 0.4;  // beyond 65 degrees a surface may fail to
      result.faced += must_return;
      const Vec3 d = p - other.points[near.index];
      const double e = std::abs(d.dot(other.normals[near.index]));
      // Slanted surface returns more sparsely.
      if (near.sq_distance > 9 * reach * reach + 4 * std::pow(other.spacing / facing, 2) || e > reach ||
          n.dot(other.normals[near.index]) < same_face) {
        result.odd += must_return && !(creases == Creases::left_out &&
                                       meet_at_crease(surfaces[view], mine.points[i], other, there, reach));
        continue;
      }
      confirmed[i] = 1, best[i] = std::min(best[i], e);
    }
    const Surfels theirs = strided_surfels(other, samples / 2);
    const Pose here = there.inverse();
    for (std::size_t i = 0; i < theirs.points.size(); ++i) {
      const Vec3 p = here * theirs.points[i], n = here.rotation * theirs.normals[i];
      const Sight seen = sight(surfaces[view].raster, p, margin);
      back += seen == Sight::in_front;
      missing += seen == Sight::empty && -n.dot(surfaces[view].raster.ray(p)) > 0.6;
    }
    result.through = std::max(result.through, through);
    if (!theirs.points.empty())
      result.back_through =
          std::max(result.back_through, static_cast<int>(double(back) * result.samples / double(theirs.points.size())));
    result.missing_by[o] = missing;
  }
  for (std::size_t i = 0; i < confirmed.size(); ++i)
    if (confirmed[i]) ++result.confirmed, residuals.push_back(best[i]);
  result.residual = median(std::move(residuals));
  return result;
}

bool same_place(const ViewSurface& surface, const Pose& a, const Pose& b, double angle, double shift) {
  return rotation_vector(a.rotation.transpose() * b.rotation).norm() < angle &&
         (a * surface.center - b * surface.center).norm() < shift;
}

}  // namespace partscribe::scan
