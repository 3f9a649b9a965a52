#include "fit/relations/relations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "core/number.h"
#include "geometry/segment/round_pieces.h"

namespace partscribe::fit {
namespace {

// Chance exceeds these once in a hundred: a normal value, and the length of a normal vector in a plane.
constexpr double one_way = 2.576, two_ways = 3.035;

// What is farther off is meant to be so: no list of pairs that nobody takes for equal. It could not be accepted either,
// for faces move by a quarter of the tolerance at most. Directions are looked at up to the draft of a casting.
constexpr double near_lengths = 2;                            // tolerances
constexpr double near_angle = 2 * pi / 180, far_angle = 0.2;  // rad; the latter of directions that are hardly known
constexpr double near_sigmas = 3.5;                           // where the sigma is larger than all that

constexpr std::size_t most_refused = 3;  // of one kind that one face comes near, the nearest first

constexpr double floor_share = 1.0 / 200;  // of the tolerance: what is finer is rounding
constexpr double shift_share = 0.25;       // of the tolerance: how far a face may be moved

/// What the tests need of one face.
struct Known {
  std::uint32_t face = 0;
  FaceKind kind = FaceKind::plane;
  Vec3 point = Vec3::Zero(), axis = Vec3::UnitZ();
  double radius = 0;  // mm, that may equal another: of a torus its tube
  double sigma_point = 0, sigma_axis = 0, sigma_radius = 0;
  double half = 0;    // mm from the middle to where a turn moves it most
  double weight = 0;  // of its direction
};

double square(double x) { return x * x; }

/// Directions up to their sense.
double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))); }

/// How far the face that moves more must move, if each moves by its share of the variance.
double largest_move(double value, double variance_a, double reach_a, double variance_b, double reach_b) {
  const double sum = variance_a + variance_b;
  return std::abs(value) * std::max(variance_a / sum * reach_a, variance_b / sum * reach_b);
}

class Relations {
 public:
  Relations(const Faces& faces, double tolerance) : faces_(faces), tolerance_(tolerance) {
    const double floor = floor_share * tolerance;
    known_of_.assign(faces.faces.size(), no_face);
    for (std::uint32_t f = 0; f < faces.faces.size(); ++f) {
      const Face& face = faces.faces[f];
      if (face.kind == FaceKind::free_form || !face.fit.determined) continue;
      const Primitive& p = face.surface();
      Known known;
      known.face = f, known.kind = face.kind, known.axis = p.axis;
      known.point = face.kind == FaceKind::plane ? Vec3(face.middle - distance(p, face.middle) * p.axis) : p.point;
      known.radius = face.kind == FaceKind::torus ? p.tube : p.radius;
      known.half = reach(face);
      known.sigma_point = std::hypot(face.fit.sigma_point, floor);
      known.sigma_radius =
          std::hypot(face.kind == FaceKind::torus ? face.fit.sigma_tube : face.fit.sigma_radius, floor);
      known.sigma_axis = std::hypot(face.fit.sigma_axis, floor / std::max(known.half, floor));
      known.weight = face.area * (face.kind == FaceKind::plane ? 1 : face.kind == FaceKind::cylinder ? 0.7 : 0.3);
      known_of_[f] = static_cast<std::uint32_t>(known_.size());
      known_.push_back(known);
    }
    for (std::uint32_t i = 0; i < known_.size(); ++i) by_weight_.push_back(i);
    std::stable_sort(by_weight_.begin(), by_weight_.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return known_[a].weight > known_[b].weight; });
  }

  std::vector<FaceRelation> all() {
    const auto is_plane = [](const Known& k) { return k.kind == FaceKind::plane; };
    const auto is_round = [](const Known& k) { return k.kind != FaceKind::plane; };
    const auto has_axis = [](const Known& k) { return k.kind != FaceKind::sphere; };
    const auto has_radius = [](const Known& k) { return k.kind != FaceKind::plane && k.kind != FaceKind::cone; };
    const auto first = beside_the_largest(has_axis, [&](const Known& a, const Known& b) { return parallel(a, b); });
    orthogonal(first);
    beside_the_largest(is_round, [&](const Known& a, const Known& b) { return coaxial(a, b); });
    beside_the_largest(is_plane, [&](const Known& a, const Known& b) { return coplanar(a, b); });
    beside_the_largest(has_radius, [&](const Known& a, const Known& b) { return equal_radius(a, b); });
    for (const auto& a : known_)
      for (const auto& n : faces_.faces[a.face].neighbours) {
        if (n.face < a.face || known_of_[n.face] == no_face) continue;
        if (n.edge != EdgeKind::tangent && n.angle > far_angle) continue;
        if (const auto relation = tangent(a, known_[known_of_[n.face]])) result_.push_back(*relation);
      }
    return std::move(result_);
  }

 private:
  const Faces& faces_;
  const double tolerance_;
  std::vector<Known> known_;
  std::vector<std::uint32_t> known_of_;  // of each face
  std::vector<std::uint32_t> by_weight_;
  std::vector<FaceRelation> result_;

  /// mm from the middle of a face to where turning it moves its surface most.
  static double reach(const Face& face) {
    switch (face.kind) {
      case FaceKind::plane: {  // half the diagonal of the rectangle that spreads as far
        const double trace = face.spread.trace();
        return trace > 0 ? std::sqrt(3 * trace) : std::sqrt(0.5 * face.area);
      }
      case FaceKind::torus:
        return face.surface().radius;
      default:
        return 0.5 * (face.high - face.low);
    }
  }

  FaceRelation tested(RelationKind kind, const Known& a, const Known& b, double value, double sigma, double bound,
                      double move) const {
    FaceRelation r{kind, a.face, b.face, value, sigma, value / sigma, false};
    r.accepted = std::abs(r.z) < bound && move < shift_share * tolerance_;
    return r;
  }

  bool is_near(double length, double sigma) const {
    return std::abs(length) < std::max(near_lengths * tolerance_, near_sigmas * sigma);
  }

  using Test = std::function<std::optional<FaceRelation>(const Known&, const Known&)>;

  /// Each face beside the heaviest one with which the relation is accepted, or else becomes one to stand beside; it is
  /// refused beside those that it comes near. Returns whom each stands beside.
  std::vector<std::uint32_t> beside_the_largest(const std::function<bool(const Known&)>& takes_part, const Test& test) {
    std::vector<std::uint32_t> first(known_.size(), no_face), heads;
    for (const auto i : by_weight_) {
      if (!takes_part(known_[i])) continue;
      std::optional<FaceRelation> best;
      std::vector<FaceRelation> refused;
      std::uint32_t head = i;
      for (const auto h : heads) {
        const auto relation = test(known_[h], known_[i]);
        if (!relation) continue;
        if (!relation->accepted)
          refused.push_back(*relation);
        else if (!best || std::abs(relation->z) < std::abs(best->z))
          best = relation, head = h;
      }
      first[i] = head;
      if (best) {
        result_.push_back(*best);
        continue;
      }
      heads.push_back(i);
      std::stable_sort(refused.begin(), refused.end(),
                       [](const FaceRelation& a, const FaceRelation& b) { return std::abs(a.z) < std::abs(b.z); });
      refused.resize(std::min(refused.size(), most_refused));
      result_.insert(result_.end(), refused.begin(), refused.end());
    }
    return first;
  }

  std::optional<FaceRelation> parallel(const Known& a, const Known& b) const {
    const double value = angle_between(a.axis, b.axis), sigma = std::hypot(a.sigma_axis, b.sigma_axis);
    if (value > std::max(near_angle, std::min(far_angle, near_sigmas * sigma))) return {};
    return tested(RelationKind::parallel, a, b, value, sigma, two_ways, turn_move(value, a, b));
  }

  static double turn_move(double angle, const Known& a, const Known& b) {
    return largest_move(angle, square(a.sigma_axis), a.half, square(b.sigma_axis), b.half);
  }

  /// Between those that others stand beside; lone small faces say nothing of the frame of a part.
  void orthogonal(const std::vector<std::uint32_t>& first) {
    double all = 0;
    std::vector<int> followers(known_.size(), 0);
    for (std::uint32_t i = 0; i < known_.size(); ++i)
      if (first[i] != no_face) all += known_[i].weight, followers[first[i]] += first[i] != i;
    std::vector<std::uint32_t> heads;
    for (const auto i : by_weight_)
      if (first[i] == i && (followers[i] > 0 || known_[i].weight > 5e-3 * all)) heads.push_back(i);
    for (std::size_t i = 0; i < heads.size(); ++i)
      for (std::size_t j = i + 1; j < heads.size(); ++j) {
        const Known &a = known_[heads[i]], &b = known_[heads[j]];
        const double value = std::asin(std::clamp(a.axis.dot(b.axis), -1.0, 1.0));
        const double sigma = std::hypot(a.sigma_axis, b.sigma_axis);
        if (std::abs(value) > std::max(near_angle, std::min(far_angle, near_sigmas * sigma))) continue;
        result_.push_back(tested(RelationKind::orthogonal, a, b, value, sigma, one_way, turn_move(value, a, b)));
      }
  }

  /// How far the middle of one lies from the axis of the other: of the better known axis, for errors of direction grow
  /// with the distance. A sphere has no axis and may lie on that of another.
  std::optional<FaceRelation> coaxial(const Known& a, const Known& b) const {
    const bool a_axis = a.kind != FaceKind::sphere, b_axis = b.kind != FaceKind::sphere;
    if (!a_axis && !b_axis) return {};
    const double tilt = a_axis && b_axis ? angle_between(a.axis, b.axis) : 0;
    const double sigma_tilt = std::hypot(a.sigma_axis, b.sigma_axis);
    if (tilt > std::max(near_angle, std::min(far_angle, near_sigmas * sigma_tilt))) return {};
    const double apart = (a.point - b.point).norm();
    const bool from_a = a_axis && (!b_axis || a.sigma_axis <= b.sigma_axis);
    const double value = from_a ? from_axis(a.point, a.axis, b.point) : from_axis(b.point, b.axis, a.point);
    const double lever = apart * (from_a ? a.sigma_axis : b.sigma_axis);
    const double sigma = std::sqrt(square(a.sigma_point) + square(b.sigma_point) + square(lever));
    if (!is_near(value, sigma)) return {};
    const double move = largest_move(value, square(a.sigma_point) + (from_a ? square(lever) : 0), 1,
                                     square(b.sigma_point) + (from_a ? 0 : square(lever)), 1) +
                        turn_move(tilt, a, b);
    auto relation = tested(RelationKind::coaxial, a, b, value, sigma, two_ways, move);
    relation.accepted &= tilt < two_ways * sigma_tilt;
    return relation;
  }

  std::optional<FaceRelation> coplanar(const Known& a, const Known& b) const {
    const double tilt = angle_between(a.axis, b.axis), sigma_tilt = std::hypot(a.sigma_axis, b.sigma_axis);
    if (tilt > std::max(near_angle, std::min(far_angle, near_sigmas * sigma_tilt))) return {};
    // Along the mean normal errors of both directions count half.
    const Vec3 apart = b.point - a.point;
    const double sense = a.axis.dot(b.axis) > 0 ? 1 : -1;
    const double value = 0.5 * apart.dot(a.axis + sense * b.axis);
    const double variance_a = square(a.sigma_point) + square(0.5 * apart.norm() * a.sigma_axis),
                 variance_b = square(b.sigma_point) + square(0.5 * apart.norm() * b.sigma_axis);
    const double sigma = std::sqrt(variance_a + variance_b);
    if (!is_near(value, sigma)) return {};
    const double move = largest_move(value, variance_a, 1, variance_b, 1) + turn_move(tilt, a, b);
    auto relation = tested(RelationKind::coplanar, a, b, value, sigma, one_way, move);
    relation.accepted &= tilt < two_ways * sigma_tilt;
    return relation;
  }

  std::optional<FaceRelation> equal_radius(const Known& a, const Known& b) const {
    const double value = b.radius - a.radius, sigma = std::hypot(a.sigma_radius, b.sigma_radius);
    // Beside small radii the tolerance is no measure of what comes near.
    if (!is_near(value, sigma) || std::abs(value) > 0.5 * std::min(a.radius, b.radius)) return {};
    const double move = largest_move(value, square(a.sigma_radius), 1, square(b.sigma_radius), 1);
    return tested(RelationKind::equal_radius, a, b, value, sigma, one_way, move);
  }

  // ---------------------------------------------------------------- tangent

  /// A face in a section in which it is a line or a circle.
  struct Section {
    bool line = false;
    Vec2 point = Vec2::Zero(), normal = Vec2::Zero();
    double radius = 0;
  };

  /// Seen along `axis` if `along`, else in the half plane through it: distance from it, height. Nothing if the face is
  /// no line or circle there.
  std::optional<Section> section(const Known& k, const Vec3& origin, const Vec3& axis, bool along) const {
    const Primitive& p = faces_.faces[k.face].surface();
    const Mat3 frame = rotation_onto_axis(axis);
    const Vec3 local = frame.transpose() * (k.point - origin);
    const double tilt = k.kind == FaceKind::sphere ? 0 : angle_between(k.axis, axis);
    if (along) {
      if (k.kind == FaceKind::cylinder && tilt < near_angle) return Section{false, local.head<2>(), {}, p.radius};
      const Vec2 normal = (frame.transpose() * k.axis).head<2>();
      if (k.kind == FaceKind::plane && tilt > 0.5 * pi - near_angle)
        return Section{true, local.head<2>(), normal.normalized(), 0};
      return {};
    }
    const double aside = local.head<2>().norm();
    if (k.kind == FaceKind::plane)
      return tilt < near_angle ? std::optional(Section{true, {0, local.z()}, {0, 1}, 0}) : std::nullopt;
    if (aside > near_lengths * tolerance_ + 0.02 * p.radius || tilt > near_angle) return {};
    switch (k.kind) {
      case FaceKind::cylinder:
        return Section{true, {p.radius, local.z()}, {1, 0}, 0};
      case FaceKind::cone: {
        const double up = k.axis.dot(axis) > 0 ? 1 : -1;
        return Section{true, {p.radius, local.z()}, {std::cos(p.half_angle), -up * std::sin(p.half_angle)}, 0};
      }
      case FaceKind::sphere:
        return Section{false, {0, local.z()}, {}, p.radius};
      default:
        return Section{false, {p.radius, local.z()}, {}, p.tube};
    }
  }

  static std::optional<double> gap_between(const Section& a, const Section& b) {
    if (a.line && b.line) return {};
    if (a.line) return std::abs((b.point - a.point).dot(a.normal)) - b.radius;
    if (b.line) return gap_between(b, a);
    const double apart = (a.point - b.point).norm();
    const double outside = apart - a.radius - b.radius, inside = apart - std::abs(a.radius - b.radius);
    return std::abs(outside) < std::abs(inside) ? outside : inside;
  }

  /// By how much one surface misses the other or cuts into it.
  std::optional<FaceRelation> tangent(const Known& a, const Known& b) const {
    std::optional<double> value;
    for (const bool along : {true, false})
      for (const Known* axis : {&a, &b}) {
        // A sphere beside a plane: about the plane's normal through its centre.
        if (axis->kind == FaceKind::sphere || (axis->kind == FaceKind::plane && along)) continue;
        const Known& other = axis == &a ? b : a;
        if (axis->kind == FaceKind::plane && other.kind != FaceKind::sphere) continue;
        const Vec3 origin = axis->kind == FaceKind::plane ? other.point : axis->point;
        const auto sa = section(a, origin, axis->axis, along), sb = section(b, origin, axis->axis, along);
        if (!sa || !sb) continue;
        const auto gap = gap_between(*sa, *sb);
        if (gap && (!value || std::abs(*gap) < std::abs(*value))) value = gap;
      }
    if (!value) return {};
    const double apart = (faces_.faces[a.face].middle - faces_.faces[b.face].middle).norm();
    const auto variance = [&](const Known& k) {
      double sum = square(k.sigma_point);
      if (k.kind != FaceKind::plane) sum += square(k.sigma_radius);
      if (k.kind == FaceKind::torus) sum += square(faces_.faces[k.face].fit.sigma_radius);
      if (k.kind == FaceKind::plane || k.kind == FaceKind::cone) sum += square(std::min(apart, k.half) * k.sigma_axis);
      return sum;
    };
    const double variance_a = variance(a), variance_b = variance(b), sigma = std::sqrt(variance_a + variance_b);
    if (!is_near(*value, sigma)) return {};
    return tested(RelationKind::tangent, a, b, *value, sigma, one_way,
                  largest_move(*value, variance_a, 1, variance_b, 1));
  }
};

}  // namespace

const char* name_of(RelationKind kind) {
  switch (kind) {
    case RelationKind::parallel:
      return "parallel";
    case RelationKind::orthogonal:
      return "orthogonal";
    case RelationKind::coaxial:
      return "coaxial";
    case RelationKind::coplanar:
      return "coplanar";
    case RelationKind::equal_radius:
      return "equal_radius";
    case RelationKind::tangent:
      break;
  }
  return "tangent";
}

std::vector<FaceRelation> relations_between(const Faces& faces, double tolerance) {
  return Relations(faces, tolerance).all();
}

}  // namespace partscribe::fit
