#include "geometry/segment/simple_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/number.h"
#include "geometry/segment/hole_patterns.h"
#include "geometry/segment/holes.h"
#include "geometry/segment/round_pieces.h"

namespace partscribe::geometry {
namespace {

constexpr double half_turn_slack = 0.6;      // rad that the ends of slots may lack of half a turn, or have beyond it
constexpr double widest_blend = 0.97 * pi;   // rad of arc: a round or fillet turns less than half a turn
constexpr double steep = 0.35, flat = 1.22;  // rad, 20 and 70 degrees: how a chamfer stands to the faces beside it
constexpr double smooth = 0.1;               // rad between faces that run into each other
constexpr double narrow = 0.5;  // a wall's thickness over the size of its smaller face, a chamfer over the radius
constexpr double narrow_chamfer = 0.8;  // over the smaller face beside it
constexpr double along_most = 0.6;      // share of a border that a neighbour must hold
constexpr int grid = 8;                 // places across a face, each way, where overlap is looked at

const std::array<const char*, 13> kinds = {
    "through hole", "blind hole", "hole", "counterbored hole", "countersunk hole", "slot", "boss", "fillet",
    "round",        "chamfer",    "wall", "bolt circle",       "row of holes"};

/// What a feature is called: kinds of holes count on together.
std::string noun(const std::string& kind) {
  if (kind.ends_with("hole")) return "hole";
  if (kind == "row of holes") return "row";
  return kind;
}

class SimpleFeatures {
 public:
  explicit SimpleFeatures(const Faces& faces)
      : faces_(faces), scale_(feature_scale(faces)), pieces_(round_pieces(faces, scale_)) {}

  std::vector<SimpleFeature> all() {
    const auto holes = holes_of(faces_, pieces_, scale_);
    for (const auto& hole : holes) {
      used_.insert(used_.end(), hole.feature.faces.begin(), hole.feature.faces.end());
      features_.push_back(hole.feature);
    }
    add_slots();
    add_bosses();
    std::sort(used_.begin(), used_.end());
    add_blends();
    add_chamfers();
    add_walls();
    for (auto& pattern : hole_patterns(holes, pieces_, scale_)) features_.push_back(std::move(pattern));
    sort_and_name();
    return std::move(features_);
  }

 private:
  const Faces& faces_;
  const FeatureScale scale_;
  const std::vector<RoundPiece> pieces_;
  std::vector<SimpleFeature> features_;
  std::vector<std::uint32_t> used_;  // by holes, slots and bosses

  const Face& face(std::uint32_t f) const { return faces_.faces[f]; }
  bool is_used(std::uint32_t f) const { return std::binary_search(used_.begin(), used_.end(), f); }

  void add(std::string kind, std::vector<std::uint32_t> faces, std::vector<FeatureSize> sizes) {
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    features_.push_back({"", std::move(kind), std::move(faces), std::move(sizes)});
  }

  /// From one plane to a parallel one, positive to where they point, with its sigma: from the one whose direction is
  /// better known, at the middle of the other.
  static std::pair<double, double> between(const Face& a, const Face& b) {
    const bool from_a = a.fit.sigma_axis <= b.fit.sigma_axis;
    const Face &from = from_a ? a : b, &to = from_a ? b : a;
    const double value = distance(from.surface(), to.middle - distance(to.surface(), to.middle) * to.surface().axis);
    const Vec3 apart = to.middle - from.middle;
    const double lever = (apart - apart.dot(from.surface().axis) * from.surface().axis).norm();
    const double places = std::hypot(a.fit.sigma_point, b.fit.sigma_point);
    return {value, std::hypot(places, lever * from.fit.sigma_axis)};
  }

  // ---------------------------------------------------------------- slots

  std::vector<std::uint32_t> smooth_planes(const RoundPiece& piece) const {
    std::vector<std::uint32_t> planes;
    for (const auto f : piece.faces)
      for (const auto& n : face(f).neighbours)
        if (face(n.face).kind == FaceKind::plane && (n.edge == EdgeKind::tangent || n.angle < smooth) &&
            std::abs(face(n.face).surface().axis.dot(piece.axis)) < smooth)
          planes.push_back(n.face);
    return planes;
  }

  void add_slots() {
    std::vector<const RoundPiece*> ends;
    for (const auto& piece : pieces_)
      if (piece.hollow && piece.kind == FaceKind::cylinder && std::abs(piece.arc - pi) < half_turn_slack)
        ends.push_back(&piece);
    std::vector<char> taken(ends.size(), 0);
    for (std::size_t i = 0; i < ends.size(); ++i)
      for (std::size_t j = i + 1; j < ends.size() && !taken[i]; ++j)
        if (!taken[j] && add_slot(*ends[i], *ends[j])) taken[i] = taken[j] = 1;
  }

  bool add_slot(const RoundPiece& a, const RoundPiece& b) {
    if (!about_equal(a.radius(), a.sigma_radius, b.radius(), b.sigma_radius, scale_.fine)) return false;
    if (!about_parallel(a.axis, b.axis, std::hypot(a.sigma_axis, b.sigma_axis))) return false;
    const double apart = from_axis(a.point, a.axis, b.point);
    if (apart < 0.05 * a.radius()) return false;
    const auto beside_a = smooth_planes(a), beside_b = smooth_planes(b);
    for (const auto p : beside_a)
      for (const auto q : beside_b) {
        const Primitive &left = face(p).surface(), &right = face(q).surface();
        if (left.axis.dot(right.axis) > -0.99 || !meets_both(p, beside_b) || !meets_both(q, beside_a)) continue;
        const auto [width, sigma] = between(face(p), face(q));
        if (std::abs(width - 2 * a.radius()) > 0.05 * a.radius() + 4 * scale_.coarse) continue;
        const PieceRim low = rim_of(faces_, a, -1, scale_), high = rim_of(faces_, a, 1, scale_);
        std::vector<std::uint32_t> members = {p, q};
        for (const auto* end : {&a, &b}) members.insert(members.end(), end->faces.begin(), end->faces.end());
        for (const auto* end : {&a, &b}) used_.insert(used_.end(), end->faces.begin(), end->faces.end());
        const double radius = a.radius() + b.radius();
        add("slot", members,
            {length_of("length", apart + radius,
                       std::sqrt(a.sigma_point * a.sigma_point + b.sigma_point * b.sigma_point +
                                 a.sigma_radius * a.sigma_radius + b.sigma_radius * b.sigma_radius)),
             length_of("width", width, sigma),
             length_of("depth", high.place - low.place, std::hypot(low.sigma, high.sigma))});
        return true;
      }
    return false;
  }

  /// The plane itself, or one that lies in it, is among these.
  bool meets_both(std::uint32_t plane, const std::vector<std::uint32_t>& others) const {
    return std::any_of(others.begin(), others.end(), [&](std::uint32_t other) {
      return other == plane || (face(plane).surface().axis.dot(face(other).surface().axis) > 0.999 &&
                                std::abs(distance(face(plane).surface(), face(other).middle)) <
                                    scale_.coarse + 4 * face(plane).fit.sigma_point);
    });
  }

  // ---------------------------------------------------------------- bosses

  void add_bosses() {
    for (const auto& piece : pieces_) {
      if (piece.hollow || piece.kind != FaceKind::cylinder || !piece.full_turn()) continue;
      const PieceRim low = rim_of(faces_, piece, -1, scale_), high = rim_of(faces_, piece, 1, scale_);
      const bool on_low = low.state == RimState::closed && low.plane,
                 on_high = high.state == RimState::closed && high.plane;
      if (on_low == on_high || low.state == high.state) continue;
      used_.insert(used_.end(), piece.faces.begin(), piece.faces.end());
      add("boss", piece.faces,
          {length_of("diameter", 2 * piece.radius(), 2 * piece.sigma_radius),
           length_of("height", high.place - low.place, std::hypot(low.sigma, high.sigma))});
    }
  }

  // ---------------------------------------------------------------- rounds and fillets

  /// A blend goes on in another of the same radius around a corner: this is not one of the faces that it joins.
  static bool goes_on(double radius, const Face& other) {
    const Primitive& p = other.surface();
    const double other_radius = other.kind == FaceKind::torus ? p.tube : p.radius;
    return other.kind != FaceKind::plane && other.kind != FaceKind::free_form && other.kind != FaceKind::cone &&
           std::abs(other_radius - radius) < 0.05 * radius;
  }

  void add_blends() {
    for (std::uint32_t f = 0; f < faces_.faces.size(); ++f) {
      const Face& blend = face(f);
      const bool cylinder = blend.kind == FaceKind::cylinder, torus = blend.kind == FaceKind::torus;
      if ((!cylinder && !torus) || is_used(f) || (cylinder && blend.arc > widest_blend)) continue;
      const Primitive& p = blend.surface();
      const double radius = cylinder ? p.radius : p.tube;
      double beside = 0, largest = 0;
      int joined = 0;
      for (const auto& n : blend.neighbours) {
        if ((n.edge != EdgeKind::tangent && n.angle > smooth) || goes_on(radius, face(n.face))) continue;
        ++joined, beside += n.length, largest = std::max(largest, face(n.face).area);
      }
      const double length = cylinder ? blend.high - blend.low : blend.arc * std::max(p.radius - p.tube, 0.0);
      if (joined < 2 || beside < 2 * along_most * length || largest < blend.area) continue;
      std::vector<FeatureSize> sizes = {
          length_of("radius", radius, cylinder ? blend.fit.sigma_radius : blend.fit.sigma_tube)};
      if (cylinder) sizes.push_back(length_of("length", length, scale_.coarse / 3));
      add(blend.hollow ? "fillet" : "round", {f}, std::move(sizes));
    }
  }

  // ---------------------------------------------------------------- chamfers

  struct Beside {
    std::uint32_t face;
    double angle, length;
  };

  void add_chamfers() {
    for (std::uint32_t f = 0; f < faces_.faces.size(); ++f) {
      const Face& chamfer = face(f);
      if ((chamfer.kind != FaceKind::plane && chamfer.kind != FaceKind::cone) || is_used(f)) continue;
      std::vector<Beside> beside;
      for (const auto& n : chamfer.neighbours)
        if (n.edge == EdgeKind::convex && n.angle > steep && n.angle < flat)
          beside.push_back({n.face, n.angle, n.length});
      std::stable_sort(beside.begin(), beside.end(),
                       [](const Beside& a, const Beside& b) { return a.length > b.length; });
      bool done = false;
      for (std::size_t i = 0; i < beside.size() && !done; ++i)
        for (std::size_t j = i + 1; j < beside.size() && !done; ++j)
          done = chamfer.kind == FaceKind::plane ? add_flat_chamfer(f, beside[i], beside[j])
                                                 : add_round_chamfer(f, beside[i], beside[j]);
    }
  }

  /// Between two planes, which it cuts in parallel lines.
  bool add_flat_chamfer(std::uint32_t f, Beside a, Beside b) {
    if (face(a.face).kind != FaceKind::plane || face(b.face).kind != FaceKind::plane) return false;
    if (face(b.face).area > face(a.face).area) std::swap(a, b);
    if (std::min(a.length, b.length) < along_most * std::max(a.length, b.length)) return false;
    const Face &chamfer = face(f), &first = face(a.face), &second = face(b.face);
    const Vec3 &n = chamfer.surface().axis, &na = first.surface().axis, &nb = second.surface().axis;
    const double corner = std::atan2(na.cross(nb).norm(), na.dot(nb));
    const double alpha = std::atan2(n.cross(na).norm(), n.dot(na)), beta = std::atan2(n.cross(nb).norm(), n.dot(nb));
    if (std::abs(corner - alpha - beta) > 0.05) return false;  // its normal lies between those beside it
    // Along the chamfer, from the line where it leaves the first to where it leaves the second.
    const Vec3 across = n.cross(na.cross(nb)).normalized(), middle = chamfer.middle;
    const double to_first = -distance(first.surface(), middle) / across.dot(na),
                 to_second = -distance(second.surface(), middle) / across.dot(nb);
    const double slant = std::abs(to_first - to_second), length = std::max(a.length, b.length);
    if (!(slant > 0) || slant > narrow_chamfer * length || chamfer.area > narrow_chamfer * second.area) return false;
    if (chamfer.area > 1.5 * slant * length) return false;  // the lines it is said to lie between are not its border
    const auto width_sigma = std::hypot(std::hypot(first.fit.sigma_point, chamfer.fit.sigma_point) / std::sin(alpha),
                                        std::hypot(first.fit.sigma_point, second.fit.sigma_point) / std::sin(corner));
    add("chamfer", {f},
        {length_of("width", slant * std::sin(beta) / std::sin(corner), width_sigma),
         angle_of("angle", alpha, std::hypot(chamfer.fit.sigma_axis, first.fit.sigma_axis)),
         length_of("length", chamfer.area / slant, scale_.coarse / 3)});
    return true;
  }

  /// Between a cylinder and a plane across its axis.
  bool add_round_chamfer(std::uint32_t f, Beside a, Beside b) {
    if (face(a.face).kind != FaceKind::cylinder) std::swap(a, b);
    const Face &chamfer = face(f), &cylinder = face(a.face), &plane = face(b.face);
    if (cylinder.kind != FaceKind::cylinder || plane.kind != FaceKind::plane) return false;
    const RoundPiece cone = round_piece(faces_, f), round = round_piece(faces_, a.face);
    if (!coaxial(cone, round, scale_.coarse) || std::abs(plane.surface().axis.dot(cone.axis)) < 0.99) return false;
    // Where the cone has the cylinder's radius, and where the plane cuts it.
    const Primitive& p = chamfer.surface();
    const double slope = std::tan(p.half_angle);
    const double at_cylinder = (cylinder.surface().radius - p.radius) / slope;
    const double at_plane = -distance(plane.surface(), p.point) / plane.surface().axis.dot(p.axis);
    const double width = std::abs(at_plane - at_cylinder);
    if (!(width > 0) || width * slope > narrow * cylinder.surface().radius) return false;
    const double edge = std::hypot(cylinder.fit.sigma_radius, chamfer.fit.sigma_radius) / slope;
    add("chamfer", {f},
        {length_of("width", width, std::hypot(edge, plane.fit.sigma_point)),
         angle_of("angle", p.half_angle, chamfer.fit.sigma_half_angle),
         length_of("diameter", 2 * cylinder.surface().radius, 2 * cylinder.fit.sigma_radius)});
    return true;
  }

  // ---------------------------------------------------------------- walls

  /// A plane face as the rectangle that has its second moments.
  struct Plate {
    std::uint32_t face;
    Vec3 middle, normal;
    std::array<Vec3, 2> half;  // mm, along its sides

    bool holds(const Vec3& place) const {
      for (const auto& h : half)
        if (std::abs((place - middle).dot(h)) > h.squaredNorm()) return false;
      return true;
    }
    double share_within(const Plate& other) const {
      int inside = 0;
      for (int i = 0; i < grid; ++i)
        for (int j = 0; j < grid; ++j) {
          const double u = (2 * i + 1.0) / grid - 1, v = (2 * j + 1.0) / grid - 1;
          inside += other.holds(middle + u * half[0] + v * half[1]);
        }
      return inside / double(grid * grid);
    }
  };

  Plate plate(std::uint32_t f) const {
    const Face& flat_face = face(f);
    Plate p{f, flat_face.middle, flat_face.surface().axis, {}};
    const Mat3 frame = rotation_onto_axis(p.normal);
    Eigen::Matrix2d moments = (frame.transpose() * flat_face.spread * frame).topLeftCorner<2, 2>();
    if (!(moments.trace() > 0)) moments = Eigen::Matrix2d::Identity() * flat_face.area / 12;
    // The principal directions of two by two moments.
    const double angle = 0.5 * std::atan2(2 * moments(0, 1), moments(0, 0) - moments(1, 1));
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec2 d(std::cos(angle + 0.5 * pi * double(k)), std::sin(angle + 0.5 * pi * double(k)));
      p.half[k] = std::sqrt(3 * std::max(0.0, d.dot(moments * d))) * (frame.leftCols<2>() * d);
    }
    return p;
  }

  /// The nearest face behind each, if the two lie back to back.
  void add_walls() {
    std::vector<Plate> plates;
    const double area = area_of(faces_);
    for (std::uint32_t f = 0; f < faces_.faces.size(); ++f)
      if (face(f).kind == FaceKind::plane && face(f).area > 1e-3 * area) plates.push_back(plate(f));
    std::vector<std::size_t> behind(plates.size(), plates.size());
    std::vector<double> thickness(plates.size(), 0), sigmas(plates.size(), 0);
    for (std::size_t i = 0; i < plates.size(); ++i)
      for (std::size_t j = 0; j < plates.size(); ++j) {
        const Plate &a = plates[i], &b = plates[j];
        const Face &fa = face(a.face), &fb = face(b.face);
        if (a.normal.dot(b.normal) > 0 ||
            !about_parallel(a.normal, b.normal, std::hypot(fa.fit.sigma_axis, fb.fit.sigma_axis)))
          continue;
        const auto [t, sigma] = between(fa, fb);
        if (!(t < -scale_.coarse) || (behind[i] < plates.size() && -t >= thickness[i])) continue;
        if (std::max(a.share_within(b), b.share_within(a)) < 0.5) continue;
        behind[i] = j, thickness[i] = -t, sigmas[i] = sigma;
      }
    for (std::size_t i = 0; i < plates.size(); ++i) {
      const auto j = behind[i];
      if (j >= plates.size() || behind[j] != i || j < i) continue;
      const Face &a = face(plates[i].face), &b = face(plates[j].face);
      if (thickness[i] > narrow * std::sqrt(std::min(a.area, b.area))) continue;
      add("wall", {plates[i].face, plates[j].face}, {length_of("thickness", thickness[i], sigmas[i])});
    }
  }

  // ---------------------------------------------------------------- order and names

  static double main_size(const SimpleFeature& feature) {
    for (const auto& d : feature.dimensions)
      if (d.quantity == FeatureSize::Quantity::length) return d.value;
    return 0;
  }

  void sort_and_name() {
    const auto rank = [](const SimpleFeature& f) {
      return std::find(kinds.begin(), kinds.end(), f.kind) - kinds.begin();
    };
    std::stable_sort(features_.begin(), features_.end(), [&](const SimpleFeature& a, const SimpleFeature& b) {
      if (rank(a) != rank(b)) return rank(a) < rank(b);
      // Sizes that differ by rounding alone are equal.
      const double grid_size = std::max(0.1 * scale_.fine, 1e-12);
      const double sa = std::round(main_size(a) / grid_size), sb = std::round(main_size(b) / grid_size);
      return sa != sb ? sa > sb : a.faces < b.faces;
    });
    std::map<std::string, int> count;
    for (auto& feature : features_) {
      const std::string name = noun(feature.kind);
      feature.name = name + " " + std::to_string(++count[name]);
    }
  }
};

}  // namespace

std::vector<SimpleFeature> simple_features(const Faces& faces) { return SimpleFeatures(faces).all(); }

}  // namespace partscribe::geometry
