#include "geometry/segment/hole_patterns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/number.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t least_holes = 3;
constexpr std::size_t most_for_triples = 40;  // holes of a group for circles about nothing: 9,880 triples

/// Equal parallel holes, seen along their axis.
class Group {
 public:
  Group(const std::vector<FoundHole>& holes, const std::vector<std::uint32_t>& members,
        const std::vector<RoundPiece>& pieces, const FeatureScale& scale)
      : holes_(holes), members_(members), free_(members.size(), 1) {
    const FoundHole& first = holes_[members_.front()];
    frame_ = rotation_onto_axis(first.axis);
    for (const auto m : members_) {
      centres_.push_back(flat(holes_[m].point));
      sigma_ = std::max(sigma_, holes_[m].sigma_point);
    }
    tolerance_ = 4 * sigma_ + scale.fine;
    for (const auto& piece : pieces)
      if (about_parallel(piece.axis, first.axis, std::hypot(piece.sigma_axis, first.sigma_axis))) {
        const Vec2 middle = flat(piece.point);
        if (!near_any(centres_, middle) && !near_any(middles_, middle)) middles_.push_back(middle);
      }
  }

  std::vector<SimpleFeature> patterns() {
    circles_about_axes();
    rows();
    circles_about_nothing();
    return std::move(result_);
  }

 private:
  const std::vector<FoundHole>& holes_;
  const std::vector<std::uint32_t>& members_;
  std::vector<char> free_;  // in no pattern yet
  Mat3 frame_;
  std::vector<Vec2> centres_, middles_;  // of the holes; of other round faces
  double sigma_ = 0, tolerance_ = 0;
  std::vector<SimpleFeature> result_;

  Vec2 flat(const Vec3& place) const { return (frame_.transpose() * place).head<2>(); }

  bool near_any(const std::vector<Vec2>& places, const Vec2& place) const {
    return std::any_of(places.begin(), places.end(), [&](const Vec2& p) { return (p - place).norm() <= tolerance_; });
  }

  /// The free holes at that distance from `middle`, if they are equally spaced around it.
  std::vector<std::uint32_t> on_circle(const Vec2& middle, double radius) const {
    std::vector<std::pair<double, std::uint32_t>> turns;
    for (std::uint32_t i = 0; i < centres_.size(); ++i) {
      const Vec2 d = centres_[i] - middle;
      if (free_[i] && std::abs(d.norm() - radius) <= tolerance_) turns.push_back({std::atan2(d.y(), d.x()), i});
    }
    if (turns.size() < least_holes) return {};
    std::sort(turns.begin(), turns.end());
    std::vector<std::uint32_t> found;
    for (std::size_t k = 0; k < turns.size(); ++k) {
      const double next = k + 1 < turns.size() ? turns[k + 1].first : turns[0].first + 2 * pi;
      const double gap = next - turns[k].first - 2 * pi / static_cast<double>(turns.size());
      if (std::abs(gap) * radius > 2 * tolerance_) return {};
      found.push_back(turns[k].second);
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  SimpleFeature begun(const char* kind, const std::vector<std::uint32_t>& found) {
    SimpleFeature feature;
    feature.kind = kind;
    feature.dimensions.push_back(count_of("count", found.size()));
    for (const auto i : found) {
      free_[i] = 0;
      const auto& faces = holes_[members_[i]].feature.faces;
      feature.faces.insert(feature.faces.end(), faces.begin(), faces.end());
    }
    std::sort(feature.faces.begin(), feature.faces.end());
    return feature;
  }

  FeatureSize hole_diameter(const std::vector<std::uint32_t>& found) const {
    double sum = 0, squares = 0;
    for (const auto i : found) {
      const FoundHole& hole = holes_[members_[i]];
      sum += hole.diameter(), squares += hole.sigma_diameter() * hole.sigma_diameter();
    }
    const auto n = static_cast<double>(found.size());
    return length_of("hole diameter", sum / n, std::sqrt(squares) / n);
  }

  void add_circle(const std::vector<std::uint32_t>& found) {
    // Of equally spaced places the mean is the centre of the circle of least squares.
    Vec2 middle = Vec2::Zero();
    for (const auto i : found) middle += centres_[i];
    const auto n = static_cast<double>(found.size());
    middle /= n;
    double radius = 0;
    for (const auto i : found) radius += (centres_[i] - middle).norm() / n;
    SimpleFeature feature = begun("bolt circle", found);
    feature.dimensions.push_back(length_of("circle diameter", 2 * radius, 2 * sigma_ / std::sqrt(n)));
    feature.dimensions.push_back(hole_diameter(found));
    result_.push_back(std::move(feature));
  }

  void circles_about_axes() {
    for (const Vec2& middle : middles_) {
      std::vector<double> radii;
      for (std::uint32_t i = 0; i < centres_.size(); ++i) radii.push_back((centres_[i] - middle).norm());
      std::sort(radii.begin(), radii.end());
      for (std::size_t i = 0; i < radii.size(); ++i) {
        if (i > 0 && radii[i] - radii[i - 1] <= tolerance_) continue;
        const auto found = on_circle(middle, radii[i]);
        if (!found.empty()) add_circle(found);
      }
    }
  }

  /// The free hole near a place; members_.size() if there is none.
  std::size_t hole_at(const Vec2& place) const {
    std::size_t best = centres_.size();
    for (std::size_t i = 0; i < centres_.size(); ++i)
      if (free_[i] && (centres_[i] - place).norm() <= 2 * tolerance_ &&
          (best == centres_.size() || (centres_[i] - place).norm() < (centres_[best] - place).norm()))
        best = i;
    return best;
  }

  /// From hole i on by steps to j. Each step starts at the hole found last: errors do not add up.
  std::vector<std::uint32_t> row_from(std::uint32_t i, std::uint32_t j) const {
    const Vec2 step = centres_[j] - centres_[i];
    if (hole_at(centres_[i] - step) < centres_.size()) return {};
    std::vector<std::uint32_t> row = {i, j};
    while (true) {
      const Vec2 mean_step = (centres_[row.back()] - centres_[i]) / static_cast<double>(row.size() - 1);
      const auto next = hole_at(centres_[row.back()] + mean_step);
      if (next >= centres_.size()) break;
      row.push_back(static_cast<std::uint32_t>(next));
    }
    return row;
  }

  void rows() {
    while (true) {
      std::vector<std::uint32_t> best;
      double best_step = 0;
      for (std::uint32_t i = 0; i < centres_.size(); ++i)
        for (std::uint32_t j = i + 1; j < centres_.size(); ++j) {
          if (!free_[i] || !free_[j] || (centres_[i] - centres_[j]).norm() <= 4 * tolerance_) continue;
          // From either end the same row: the one that starts at the smaller number will do.
          for (const auto& row : {row_from(i, j), row_from(j, i)}) {
            if (row.size() < least_holes || row.front() > row.back()) continue;
            const double step = (centres_[row[1]] - centres_[row[0]]).norm();
            if (row.size() < best.size() || (row.size() == best.size() && step > best_step - tolerance_)) continue;
            best = row, best_step = step;
          }
        }
      if (best.empty()) return;
      const auto n = static_cast<double>(best.size());
      const Vec2 along = (centres_[best.back()] - centres_[best.front()]).normalized();
      double sum = 0, weights = 0;
      for (std::size_t k = 0; k < best.size(); ++k) {
        const double weight = static_cast<double>(k) - 0.5 * (n - 1);
        sum += weight * centres_[best[k]].dot(along), weights += weight * weight;
      }
      SimpleFeature feature = begun("row of holes", best);
      feature.dimensions.push_back(length_of("pitch", sum / weights, sigma_ / std::sqrt(weights)));
      feature.dimensions.push_back(hole_diameter(best));
      result_.push_back(std::move(feature));
    }
  }

  void circles_about_nothing() {
    if (centres_.size() > most_for_triples) return;
    while (true) {
      std::vector<std::uint32_t> best;
      const auto n = static_cast<std::uint32_t>(centres_.size());
      for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = i + 1; j < n; ++j)
          for (std::uint32_t k = j + 1; k < n; ++k) {
            if (!free_[i] || !free_[j] || !free_[k]) continue;
            const Vec2 b = centres_[j] - centres_[i], c = centres_[k] - centres_[i];
            const double d = 2 * (b.x() * c.y() - b.y() * c.x());
            if (std::abs(d) < 0.1 * b.norm() * c.norm()) continue;  // nearly on a line
            const Vec2 u((c.y() * b.squaredNorm() - b.y() * c.squaredNorm()) / d,
                         (b.x() * c.squaredNorm() - c.x() * b.squaredNorm()) / d);
            const auto found = on_circle(centres_[i] + u, u.norm());
            if (found.size() > best.size()) best = found;
          }
      if (best.empty()) return;
      add_circle(best);
    }
  }
};

}  // namespace

std::vector<SimpleFeature> hole_patterns(const std::vector<FoundHole>& holes, const std::vector<RoundPiece>& pieces,
                                         const FeatureScale& scale) {
  std::vector<SimpleFeature> patterns;
  std::vector<char> taken(holes.size(), 0);
  for (std::uint32_t i = 0; i < holes.size(); ++i) {
    if (taken[i]) continue;
    std::vector<std::uint32_t> members;
    for (std::uint32_t j = i; j < holes.size(); ++j) {
      const FoundHole &a = holes[i], &b = holes[j];
      if (taken[j] || a.feature.kind != b.feature.kind) continue;
      if (!about_parallel(a.axis, b.axis, std::hypot(a.sigma_axis, b.sigma_axis))) continue;
      if (!about_equal(a.diameter(), a.sigma_diameter(), b.diameter(), b.sigma_diameter(), 2 * scale.fine)) continue;
      // Holes behind each other are no pattern.
      const bool behind = std::any_of(members.begin(), members.end(), [&](std::uint32_t m) {
        return from_axis(holes[m].point, holes[m].axis, b.point) < 0.5 * b.diameter();
      });
      if (behind) continue;
      taken[j] = 1;
      members.push_back(j);
    }
    if (members.size() < least_holes) continue;
    auto found = Group(holes, members, pieces, scale).patterns();
    patterns.insert(patterns.end(), std::make_move_iterator(found.begin()), std::make_move_iterator(found.end()));
  }
  return patterns;
}

}  // namespace partscribe::geometry
