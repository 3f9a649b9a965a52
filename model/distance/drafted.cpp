#include "model/distance/drafted.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "core/number.h"
#include "model/draft.h"
#include "model/overloaded.h"
#include "model/sketch.h"

namespace partscribe::model {
namespace {

Vec3 raised(const Vec2& p, double z) { return {p.x(), p.y(), z}; }

Vec3 foot_on_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  return a + std::clamp((p - a).dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0) * along;
}

/// The wall over a straight edge: a plane trapezoid, counter-clockwise seen from outside.
struct PlaneWall {
  std::array<Vec3, 4> corners;
  Vec3 normal;

  PlaneWall(const Line2& low, const Line2& high, double z_low, double z_high)
      : corners{raised(low.a, z_low), raised(low.b, z_low), raised(high.b, z_high), raised(high.a, z_high)},
        normal((corners[1] - corners[0]).cross(corners[3] - corners[0]).normalized()) {}

  Foot foot(const Vec3& p) const { return foot_on_polygon(corners, normal, p); }
  /// How often a ray along x from p, at its height, crosses the wall; `up` from 0 to 1.
  int crossings(const Vec3& p, double up) const {
    const Vec3 a = corners[0] + up * (corners[3] - corners[0]), b = corners[1] + up * (corners[2] - corners[1]);
    if ((a.y() <= p.y()) == (b.y() <= p.y())) return 0;
    return a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) > p.x() ? 1 : 0;
  }
};

/// The wall over an arc: a piece of a cone about the arc's centre.
class ConeWall {
 public:
  ConeWall(const Arc2& low, const Arc2& high, double z_low, double z_high)
      : center_(low.center), radius_(low.radius, high.radius), z_(z_low, z_high) {
    from_ = std::min(low.from, low.to), half_ = std::min(std::abs(low.to - low.from) / 2, pi);
    const double last = from_ + 2 * half_;
    const bool full = half_ > pi - 1e-12;
    // Between its highest and lowest places a circle rises or falls throughout.
    std::vector<double> cuts = {from_};
    for (double k = std::floor((from_ - pi / 2) / pi) + 1; pi / 2 + k * pi < last; k += 1)
      cuts.push_back(pi / 2 + k * pi);
    cuts.push_back(last);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
      pieces_.push_back(
          {std::sin(cuts[i]), std::sin(cuts[i + 1]), std::cos((cuts[i] + cuts[i + 1]) / 2) > 0 ? 1.0 : -1.0});
    if (full) pieces_.back().to = pieces_.front().from;
  }

  Foot foot(const Vec3& p) const {
    const Vec2 d = p.head<2>() - center_;
    const double turn = std::atan2(d.y(), d.x()), off = std::remainder(turn - from_ - half_, 2 * pi);
    if (std::abs(off) <= half_) return on_ruling(p, turn);
    // Beyond the ends the ruling with the nearer azimuth is the nearest.
    return on_ruling(p, off < 0 ? from_ : from_ + 2 * half_);
  }
  int crossings(const Vec3& p, double up) const {
    const double r = radius_[0] + up * (radius_[1] - radius_[0]), y = (p.y() - center_.y()) / r;
    int count = 0;
    for (const Piece& piece : pieces_)
      if ((piece.from <= y) != (piece.to <= y))
        count += center_.x() + piece.side * r * std::sqrt(std::max(1 - y * y, 0.0)) > p.x() ? 1 : 0;
    return count;
  }

 private:
  Foot on_ruling(const Vec3& p, double turn) const {
    const Vec2 out(std::cos(turn), std::sin(turn));
    const Vec3 low = raised(center_ + radius_[0] * out, z_[0]), high = raised(center_ + radius_[1] * out, z_[1]);
    Foot f;
    f.point = foot_on_segment(low, high, p);
    f.distance = (p - f.point).norm();
    f.normal = raised((z_[1] - z_[0]) * out, radius_[0] - radius_[1]).normalized();
    return f;
  }
  /// Sines at the ends of a piece of the unit circle, and whether it lies right or left of the centre.
  struct Piece {
    double from, to, side;
  };
  Vec2 center_, radius_, z_;  // radius and height at the bottom and at the top
  double from_, half_;        // first angle and half the span
  std::vector<Piece> pieces_;
};

class Drafted : public Solid {
 public:
  explicit Drafted(const ExtrudeOf<double>& s) : Drafted(outline_of(s.sketch), -s.below, s.height, std::tan(s.draft)) {}

  LocalHit hit(const Vec3& p) const override {
    LocalHit best{1e300, 0};
    for (int i = 0; i < static_cast<int>(faces.size()); ++i)
      if (const double d = foot(p, i).distance; d < best.distance) best = {d, i};
    if (inside(p)) best.distance = -best.distance;
    return best;
  }
  Foot foot(const Vec3& p, int face) const override {
    if (face < static_cast<int>(walls_.size()))
      return std::visit([&](const auto& wall) { return wall.foot(p); }, walls_[static_cast<std::size_t>(face)]);
    const bool bottom = face == static_cast<int>(walls_.size());
    const OutlineDistance& end = bottom ? low_ : high_;
    const Vec2 flat = p.head<2>();
    Foot f;
    f.point = raised(end.inside(flat) ? flat : end(flat).foot, bottom ? z_low_ : z_high_);
    f.distance = (p - f.point).norm();
    return f;
  }

 private:
  Drafted(const Outline2& outline, double z_low, double z_high, double slope)
      : low_(moved_inwards(outline, z_low * slope)),
        high_(moved_inwards(outline, z_high * slope)),
        z_low_(z_low),
        z_high_(z_high) {
    const auto &low = low_.outline().curves, &high = high_.outline().curves;
    for (std::size_t i = 0; i < low.size(); ++i) {
      faces.push_back(low[i].name);
      if (const auto* line = std::get_if<Line2>(&low[i].curve))
        walls_.emplace_back(PlaneWall(*line, std::get<Line2>(high[i].curve), z_low, z_high));
      else
        walls_.emplace_back(ConeWall(std::get<Arc2>(low[i].curve), std::get<Arc2>(high[i].curve), z_low, z_high));
    }
    faces.push_back("bottom"), faces.push_back("top");
    for (const auto* end : {&low_, &high_}) {
      const Box3 box = flat_box(end->outline());
      bounds.add(raised(box.low.head<2>(), z_low)), bounds.add(raised(box.high.head<2>(), z_high));
    }
  }
  bool inside(const Vec3& p) const {
    if (p.z() < z_low_ || p.z() > z_high_) return false;
    const double up = (p.z() - z_low_) / (z_high_ - z_low_);
    int count = 0;
    for (const auto& wall : walls_) count += std::visit([&](const auto& w) { return w.crossings(p, up); }, wall);
    return count % 2 == 1;
  }

  OutlineDistance low_, high_;
  double z_low_, z_high_;
  std::vector<std::variant<PlaneWall, ConeWall>> walls_;
};

}  // namespace

std::unique_ptr<Solid> drafted_solid(const ExtrudeOf<double>& shape) { return std::make_unique<Drafted>(shape); }

}  // namespace partscribe::model
