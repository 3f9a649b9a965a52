#include "geometry/segment/like_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/number.h"
#include "geometry/least_squares.h"
#include "geometry/segment/faces.h"

namespace partscribe::geometry {
namespace {

constexpr double slanted = 0.5;       // sine between a wall's normal and the plane across its axis
constexpr double same_radius = 0.05;  // of the radius
constexpr double same_axis = 0.999;   // cosine
constexpr int sectors = 12, seen_sectors = 8;
constexpr double beside_to = 4;                                    // times as far: what lies beside it
constexpr double assigned = 4;                                     // sigmas that a point may lie off
constexpr double assigned_turn = 1.0;                              // rad; near rims normals are means of both sides
constexpr int most_failures = 40;                                  // places in a row that no cylinder stands in
constexpr double saved_by_point = 2, cost_of_place = 25 + 2 * 10;  // nats, as those of any face

/// Which twelfths of a turn are seen.
class Sectors {
 public:
  void add(const Vec2& away) {
    const double turn = (std::atan2(away.y(), away.x()) / pi + 1) / 2 * sectors;
    hit_[static_cast<std::size_t>(turn) % sectors] = true;
  }
  bool most() const { return std::ranges::count(hit_, true) >= seen_sectors; }

 private:
  std::array<bool, sectors> hit_{};
};

class Finder {
 public:
  Finder(const PointCloud& cloud, std::vector<std::uint8_t>& taken, const GrownFace& like, double least_sigma,
         double pitch)
      : cloud_(cloud), taken_(taken), like_(like), least_sigma_(least_sigma), pitch_(pitch) {
    frame_ = rotation_onto_axis(like.surface.axis);
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      if (taken[i]) continue;
      const Vec3 n = frame_.transpose() * cloud.normals[i];
      if (std::abs(n.z()) > slanted) continue;
      const Vec3 p = frame_.transpose() * cloud.points[i];
      const Vec2 normal = n.head<2>().normalized();
      walls_.push_back({i, p.head<2>(), normal, p.z(), sigma_of(i)});
      ++votes_[cell_of(p.head<2>() - like.sense * radius() * normal)];
    }
  }

  std::vector<LikeFace> find() {
    std::vector<LikeFace> result;
    for (int failures = 0; failures < most_failures && !votes_.empty();) {
      const auto [cell, count] = fullest();
      if (double(count) * saved_by_point < cost_of_place) break;
      const Vec2 middle(double(cell[0]) + 0.5, double(cell[1]) + 0.5);
      auto face = about(middle * edge());
      for (long dx = -1; dx <= 1; ++dx)
        for (long dy = -1; dy <= 1; ++dy) votes_.erase({cell[0] + dx, cell[1] + dy});
      if (!face) {
        ++failures;
        continue;
      }
      failures = 0;
      for (const auto i : face->members) taken_[i] = 1;
      std::erase_if(walls_, [&](const Wall& w) { return taken_[w.point]; });
      result.push_back(std::move(*face));
    }
    return result;
  }

 private:
  using Cell = std::array<long, 2>;
  struct Wall {
    std::uint32_t point;
    Vec2 place, normal;  // across the axis
    double along, sigma;
  };

  const PointCloud& cloud_;
  std::vector<std::uint8_t>& taken_;
  const GrownFace& like_;
  double least_sigma_, pitch_;
  Mat3 frame_;
  std::vector<Wall> walls_;
  std::map<Cell, int> votes_;

  double radius() const { return like_.surface.radius; }
  double edge() const { return 0.4 * radius(); }  // normals of narrow walls are no better
  double sigma_of(std::uint32_t i) const { return std::max(least_sigma_, double(cloud_.sigma[i])); }
  Cell cell_of(const Vec2& p) const {
    return {std::lround(std::floor(p.x() / edge())), std::lround(std::floor(p.y() / edge()))};
  }

  std::pair<Cell, int> fullest() const {
    std::pair<Cell, int> best{{}, -1};
    for (const auto& [cell, own] : votes_) {
      int count = 0;
      for (long dx = -1; dx <= 1; ++dx)
        for (long dy = -1; dy <= 1; ++dy)
          if (const auto at = votes_.find({cell[0] + dx, cell[1] + dy}); at != votes_.end()) count += at->second;
      if (count > best.second) best = {cell, count};
    }
    return best;
  }

  double off(const Wall& w, const Vec2& center) const { return (w.place - center).norm() - radius(); }
  bool faces_it(const Wall& w, const Vec2& center) const {
    return like_.sense * w.normal.dot((w.place - center).normalized()) > std::cos(assigned_turn);
  }

  std::optional<LikeFace> about(Vec2 center) const {
    double reach = 0.5 * radius();
    for (int round = 0; round < 15; ++round) {
      NormalSums<2> sums;
      double least = 0;
      for (const Wall& w : walls_) {
        const double d = off(w, center);
        if (std::abs(d) > 2 * reach || !faces_it(w, center)) continue;
        sums.add((w.place - center).normalized(), d, welsch_weight(d, reach));
        least = std::max(least, w.sigma);
      }
      const Vec2 step = sums.solution(1e-9 + 1e-6 * sums.h.trace());
      center += step.cwiseMin(0.5 * radius()).cwiseMax(-0.5 * radius());
      if (step.norm() < 1e-6 * radius() && reach == 2 * least) break;
      reach = std::max(0.6 * reach, 2 * least);
    }
    std::vector<const Wall*> on;
    for (const Wall& w : walls_)
      if (std::abs(off(w, center)) < assigned * w.sigma && faces_it(w, center)) on.push_back(&w);
    return face_of(longest_piece(std::move(on)), center);
  }

  /// One wall is no two that stand on one axis.
  std::vector<const Wall*> longest_piece(std::vector<const Wall*> on) const {
    const double gap = std::max(radius(), 4 * pitch_);
    std::ranges::stable_sort(on, {}, &Wall::along);
    std::size_t begin = 0, best_begin = 0, best_end = 0;
    for (std::size_t k = 1; k <= on.size(); ++k) {
      if (k < on.size() && on[k]->along - on[k - 1]->along < gap) continue;
      if (k - begin > best_end - best_begin) best_begin = begin, best_end = k;
      begin = k;
    }
    return {on.begin() + std::ptrdiff_t(best_begin), on.begin() + std::ptrdiff_t(best_end)};
  }

  std::optional<LikeFace> face_of(const std::vector<const Wall*>& on, const Vec2& center) const {
    double saved = 0;
    Sectors seen;
    LikeFace face;
    for (const Wall* w : on) {
      const double u = off(*w, center) / w->sigma;
      saved += std::max(0.0, 2 * saved_by_point - 0.5 * u * u) / 2;
      seen.add(w->place - center);
      face.members.push_back(w->point);
    }
    if (saved < cost_of_place || !seen.most()) return std::nullopt;
    // Of a surface that only passes by there are as many points beside it as on it.
    double beside = 0;
    for (const Wall& w : walls_) {
      const double u = std::abs(off(w, center)) / w.sigma;
      const bool along = w.along > on.front()->along - radius() && w.along < on.back()->along + radius();
      beside += along && u > assigned && u < beside_to * assigned && faces_it(w, center);
    }
    const double chance = beside / (beside_to - 1);
    if (double(on.size()) < 3 * chance + 3 * std::sqrt(chance)) return std::nullopt;
    std::ranges::sort(face.members);
    face.face.surface = like_.surface, face.face.sense = like_.sense, face.face.gain = saved - cost_of_place;
    face.face.surface.point = frame_ * Vec3(center.x(), center.y(), on[on.size() / 2]->along);
    return face;
  }
};

}  // namespace

std::vector<LikeFace> like_faces(const PointCloud& cloud, const std::vector<std::uint8_t>& left_out,
                                 const std::vector<std::uint32_t>& label, const std::vector<GrownFace>& found,
                                 double least_sigma, double pitch) {
  std::vector<std::uint8_t> taken = left_out;
  std::vector<Sectors> seen(found.size());
  std::vector<Mat3> across;
  for (const GrownFace& face : found) across.push_back(rotation_onto_axis(face.surface.axis).transpose());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto f = label[i];
    if (f == no_face) continue;
    taken[i] = 1;
    if (found[f].surface.kind == PrimitiveKind::cylinder)
      seen[f].add((across[f] * (cloud.points[i] - found[f].surface.point)).head<2>());
  }
  std::vector<const GrownFace*> known;
  for (std::size_t f = 0; f < found.size(); ++f)
    if (found[f].surface.kind == PrimitiveKind::cylinder && seen[f].most()) known.push_back(&found[f]);
  std::ranges::stable_sort(known, std::greater{}, &GrownFace::gain);
  std::vector<LikeFace> result;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const Primitive& p = known[k]->surface;
    const bool asked_before = std::any_of(known.begin(), known.begin() + std::ptrdiff_t(k), [&](const GrownFace* f) {
      return f->sense == known[k]->sense && std::abs(f->surface.axis.dot(p.axis)) > same_axis &&
             std::abs(f->surface.radius - p.radius) < same_radius * p.radius;
    });
    if (asked_before) continue;
    for (LikeFace& face : Finder(cloud, taken, *known[k], least_sigma, pitch).find()) result.push_back(std::move(face));
  }
  return result;
}

}  // namespace partscribe::geometry
