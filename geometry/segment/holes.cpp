#include "geometry/segment/holes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/disjoint_sets.h"
#include "core/number.h"

namespace partscribe::geometry {
namespace {

constexpr double least_countersink = 1.4;  // times the hole's diameter; what is less is a chamfer
constexpr double eccentric = 0.01;         // of the radius that steps of one hole may lie beside each other
constexpr double pointed = 0.1;            // a cone that ends below this share of its wide radius ends in a point

/// A piece in the frame of the narrowest bore of its hole.
struct Segment {
  const RoundPiece* piece;
  int sense;         // +1: the piece's axis is that of the hole
  double low, high;  // mm along the hole's axis
  double low_radius, high_radius;

  PieceRim rim(const Faces& faces, int side, const FeatureScale& scale) const {
    return rim_of(faces, *piece, side * sense, scale);
  }
  /// A place along the piece's axis, along the hole's.
  double along_hole(double place) const {
    return 0.5 * (low + high) + sense * (place - 0.5 * (piece->low + piece->high));
  }
};

/// Do two bores on one axis follow each other, by a step, a cone or a small round between them?
bool follow(const Faces& faces, const RoundPiece& a, const RoundPiece& b, const FeatureScale& scale) {
  const double middle = a.along(b.point), sense = a.axis.dot(b.axis) > 0 ? 1 : -1;
  const double low = middle + (sense > 0 ? b.low : -b.high), high = middle + (sense > 0 ? b.high : -b.low);
  const double gap = std::max(low - a.high, a.low - high);
  const double overlap_allowed = scale.coarse + 0.2 * std::min(a.high - a.low, high - low);
  if (gap < -overlap_allowed || gap > scale.coarse + 0.5 * std::max(a.radius(), b.radius())) return false;
  for (const auto f : a.faces)
    for (const auto g : b.faces) {
      if (meeting(faces.faces[f], g)) return true;
      for (const auto& n : faces.faces[f].neighbours) {
        const Face& between = faces.faces[n.face];
        if (between.kind == FaceKind::plane && std::abs(between.surface().axis.dot(a.axis)) < 0.9) continue;
        if (meeting(between, g)) return true;
      }
    }
  return false;
}

/// May two bores on one axis be one hole whose middle was not seen, because views reach a short way in from either
/// side? Nothing bars the ends that look at each other, or only the shoulder of the wider one.
bool seen_from_both_sides(const Faces& faces, const RoundPiece& a, const RoundPiece& b, const FeatureScale& scale) {
  if (a.kind != FaceKind::cylinder || b.kind != FaceKind::cylinder) return false;
  const int to_b = a.along(b.point) > 0.5 * (a.low + a.high) ? 1 : -1;
  const int to_a = b.along(a.point) > 0.5 * (b.low + b.high) ? 1 : -1;
  const RimState end_a = rim_of(faces, a, to_b, scale).state, end_b = rim_of(faces, b, to_a, scale).state;
  if (end_a == RimState::unknown && end_b == RimState::unknown)
    return about_equal(a.radius(), a.sigma_radius, b.radius(), b.sigma_radius, scale.fine);
  if (end_a == RimState::unknown) return end_b == RimState::closed && b.radius() > a.radius() + scale.fine;
  return end_b == RimState::unknown && end_a == RimState::closed && a.radius() > b.radius() + scale.fine;
}

class Hole {
 public:
  Hole(const Faces& faces, const std::vector<const RoundPiece*>& pieces, const FeatureScale& scale)
      : faces_(faces), scale_(scale) {
    for (const auto* piece : pieces)
      if (piece->kind == FaceKind::cylinder && (!core_ || piece->radius() < core_->radius() - scale.fine))
        core_ = piece;
    if (!core_) return;
    for (const auto* piece : pieces) segments_.push_back(segment(*piece));
    std::stable_sort(segments_.begin(), segments_.end(),
                     [](const Segment& a, const Segment& b) { return a.low + a.high < b.low + b.high; });
    for (std::size_t i = 0; i < segments_.size(); ++i)
      if (segments_[i].piece == core_) first_ = last_ = i;
    while (last_ + 1 < segments_.size() && is_core(segments_[last_ + 1])) ++last_;
    while (first_ > 0 && is_core(segments_[first_ - 1])) --first_;
  }

  std::optional<FoundHole> found() {
    if (!core_) return {};
    const End low = end(-1), high = end(1);
    if (low.state == RimState::closed && high.state == RimState::closed) return {};
    FoundHole hole;
    hole.point = core_->point;
    hole.sigma_point = core_->sigma_point, hole.sigma_axis = core_->sigma_axis;
    auto& sizes = hole.feature.dimensions;
    sizes.push_back(length_of("diameter", 2 * core_->radius(), 2 * core_->sigma_radius));
    sizes.push_back(length_of("depth", high.place - low.place, std::hypot(high.sigma, low.sigma)));
    use(*core_);
    for (std::size_t i = first_; i <= last_; ++i) use(*segments_[i].piece);
    bool bored = false, sunk = false;
    const bool closed = low.state == RimState::closed || high.state == RimState::closed;
    int mouth = high.state != RimState::open && low.state == RimState::open ? -1 : 1;
    for (const int side : {-1, 1}) {
      const bool before = bored || sunk;
      widen(side, side > 0 ? high : low, sizes, bored, sunk);
      if (!before && (bored || sunk)) mouth = side;
    }
    hole.mouth = core_->point + (mouth > 0 ? high : low).place * core_->axis;
    hole.axis = mouth * core_->axis, hole.far_end = (mouth > 0 ? low : high).state;
    const bool open = low.state == RimState::open && high.state == RimState::open;
    hole.feature.kind = bored    ? "counterbored hole"
                        : sunk   ? "countersunk hole"
                        : closed ? "blind hole"
                        : open   ? "through hole"
                                 : "hole";
    for (const End* e : {&low, &high})
      if (e->tip) {
        sizes.push_back(angle_of("tip angle", 2 * e->tip->half_angle, 2 * e->tip->sigma_half_angle));
        use(*e->tip);
      }
    std::sort(used_.begin(), used_.end());
    used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
    hole.feature.faces = used_;
    return hole;
  }

 private:
  /// Where the whole hole ends on one side; the tip of a drill is beyond it.
  struct End {
    RimState state = RimState::unknown;
    double place = 0, sigma = 0;
    const RoundPiece* tip = nullptr;
  };

  const Faces& faces_;
  const FeatureScale& scale_;
  const RoundPiece* core_ = nullptr;
  std::vector<Segment> segments_;     // along the core's axis
  std::size_t first_ = 0, last_ = 0;  // of the segments as narrow as the core
  std::vector<std::uint32_t> used_;

  Segment segment(const RoundPiece& piece) const {
    const double middle = core_->along(piece.point);
    const int sense = piece.axis.dot(core_->axis) > 0 ? 1 : -1;
    if (sense > 0) return {&piece, sense, middle + piece.low, middle + piece.high, piece.low_radius, piece.high_radius};
    return {&piece, sense, middle - piece.high, middle - piece.low, piece.high_radius, piece.low_radius};
  }

  bool is_core(const Segment& s) const {
    return s.piece->kind == FaceKind::cylinder &&
           about_equal(s.piece->radius(), s.piece->sigma_radius, core_->radius(), core_->sigma_radius, scale_.fine);
  }

  void use(const RoundPiece& piece) { used_.insert(used_.end(), piece.faces.begin(), piece.faces.end()); }

  End end(int side) const {
    std::size_t i = side > 0 ? segments_.size() - 1 : 0;
    End result;
    const auto narrow = [&](const Segment& s) { return side > 0 ? s.high_radius : s.low_radius; };
    const auto wide = [&](const Segment& s) { return side > 0 ? s.low_radius : s.high_radius; };
    if (segments_.size() > 1 && segments_[i].piece->kind == FaceKind::cone &&
        narrow(segments_[i]) < pointed * wide(segments_[i])) {
      result.tip = segments_[i].piece;
      i = side > 0 ? i - 1 : i + 1;
    }
    const PieceRim rim = segments_[i].rim(faces_, side, scale_);
    result.state = result.tip ? RimState::closed : rim.state;
    result.place = segments_[i].along_hole(rim.place), result.sigma = rim.sigma;
    return result;
  }

  /// What is wider than the core towards one side, as long as it does not grow narrow again.
  void widen(int side, const End& end, std::vector<FeatureSize>& sizes, bool& bored, bool& sunk) {
    if (end.state == RimState::closed) return;
    double radius = core_->radius();
    for (std::size_t i = side > 0 ? last_ + 1 : first_ - 1; i<segments_.size(); side> 0 ? ++i : --i) {
      const Segment& s = segments_[i];
      if (s.piece->kind == FaceKind::cylinder) {
        if (s.piece->radius() < radius + scale_.fine) return;
        radius = s.piece->radius();
        bored = true;
        sizes.push_back(length_of("counterbore diameter", 2 * radius, 2 * s.piece->sigma_radius));
        const PieceRim bottom = s.rim(faces_, -side, scale_);
        sizes.push_back(length_of("counterbore depth", side * (end.place - s.along_hole(bottom.place)),
                                  std::hypot(end.sigma, bottom.sigma)));
        use(*s.piece);
        continue;
      }
      const double outer = side > 0 ? s.high_radius : s.low_radius;
      const bool at_end = i == (side > 0 ? segments_.size() - 1 : 0);
      if (!at_end || outer < least_countersink * radius) continue;
      sunk = true;
      // Its wide end lies where the hole ends.
      const double along = std::abs(end.place - (side > 0 ? s.high : s.low)) * std::tan(s.piece->half_angle);
      const double sign = side * (end.place - (side > 0 ? s.high : s.low)) > 0 ? 1 : -1;
      sizes.push_back(length_of("countersink diameter", 2 * (outer + sign * along),
                                2 * std::hypot(s.piece->sigma_radius, end.sigma * std::tan(s.piece->half_angle))));
      sizes.push_back(angle_of("countersink angle", 2 * s.piece->half_angle, 2 * s.piece->sigma_half_angle));
      use(*s.piece);
    }
  }
};

}  // namespace

FeatureSize length_of(std::string name, double value, double sigma) {
  return {std::move(name), FeatureSize::Quantity::length, value, sigma};
}
FeatureSize angle_of(std::string name, double value, double sigma) {
  return {std::move(name), FeatureSize::Quantity::angle, value, sigma};
}
FeatureSize count_of(std::string name, std::size_t count) {
  return {std::move(name), FeatureSize::Quantity::count, static_cast<double>(count), 0};
}

std::vector<FoundHole> holes_of(const Faces& faces, const std::vector<RoundPiece>& pieces, const FeatureScale& scale) {
  const auto one_hole = [&](const RoundPiece& a, const RoundPiece& b) {
    return coaxial(a, b, scale.coarse + eccentric * std::min(a.radius(), b.radius())) &&
           (follow(faces, a, b, scale) || seen_from_both_sides(faces, a, b, scale));
  };
  std::vector<const RoundPiece*> bores;
  for (const auto& piece : pieces)
    if (piece.hollow && piece.full_turn()) bores.push_back(&piece);
  // What goes on from a hole about its axis is part of it, if only a part of its turn was seen.
  const std::size_t whole = bores.size();
  for (const auto& piece : pieces)
    if (piece.hollow && !piece.full_turn() && piece.kind == FaceKind::cylinder &&
        std::any_of(bores.begin(), bores.begin() + std::ptrdiff_t(whole),
                    [&](const RoundPiece* bore) { return one_hole(*bore, piece); }))
      bores.push_back(&piece);
  DisjointSets sets(bores.size());
  for (std::uint32_t i = 0; i < bores.size(); ++i)
    for (std::uint32_t j = i + 1; j < bores.size(); ++j)
      if (one_hole(*bores[i], *bores[j])) sets.unite(i, j);
  std::vector<FoundHole> holes;
  for (std::uint32_t i = 0; i < bores.size(); ++i) {
    if (sets.root(i) != i) continue;
    std::vector<const RoundPiece*> members;
    for (std::uint32_t j = i; j < bores.size(); ++j)
      if (sets.root(j) == i) members.push_back(bores[j]);
    if (auto hole = Hole(faces, members, scale).found()) holes.push_back(std::move(*hole));
  }
  return holes;
}

}  // namespace partscribe::geometry
