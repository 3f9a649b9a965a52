#include "verify/features/inspect.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/number.h"
#include "core/statistics.h"
#include "verify/evaluate/evaluate.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t most_points = 2500;  // that one fit takes
constexpr double same_face = 0.85;         // cosine between scanned and true normal of a point on the feature
constexpr double fine_facets = 0.15;       // of the tolerance: by how much they may lie inside
constexpr double coarse_facets = 0.5;      // of the tolerance: by how much they must lie inside to be blamed
constexpr double wanted_facets = 0.25;     // of the tolerance: by how much they may lie inside after they are mended
constexpr double least_arc = 0.6;   // of the feature's own arc that a radius of quite another size must be seen over
constexpr double known_well = 0.5;  // of the tolerance: a number less certain says nothing

/// A scanned point as it would lie if the facets of a coarse polygon were the true surface: moved by as much as the
/// facet below it lies inside. So a scan of the same polygon deviates by nothing.
Vec3 without_facets(const Compared& c, const Primitive& nominal, const Vec3& point) {
  const MeshHit hit = c.surface.closest(point);
  return point - distance(nominal, hit.point) * surface_normal(nominal, hit.point);
}

struct Fitted {
  PrimitiveFit fit;
  std::vector<Vec3> points;
  double inflation = 1;               // sigma grows so much because neighbours err together
  double shift = 0, sigma_shift = 0;  // mm, largest distance between nominal and measured surface at the points
};

/// How much larger the scatter of local means is than independent errors would make it.
double inflation_of(const Primitive& primitive, const std::vector<Vec3>& points) {
  Box3 box;
  for (const auto& p : points) box.add(p);
  const double edge = std::max(box.diagonal() / 6, 1e-9);
  struct Cell {
    double sum = 0;
    std::size_t count = 0;
  };
  std::map<std::array<int, 3>, Cell> cells;
  double squares = 0;
  for (const auto& p : points) {
    const Vec3 q = (p - box.low) / edge;
    auto& cell = cells[{int(q.x()), int(q.y()), int(q.z())}];
    const double d = distance(primitive, p);
    cell.sum += d, ++cell.count, squares += d * d;
  }
  const double variance = squares / static_cast<double>(points.size());
  if (!(variance > 0)) return 1;
  double ratio = 0;
  std::size_t used = 0;
  for (const auto& [key, cell] : cells)
    if (cell.count >= 4) ratio += cell.sum * cell.sum / (static_cast<double>(cell.count) * variance), ++used;
  if (used < 4) return 1.5;
  return std::sqrt(std::max(1.0, ratio / static_cast<double>(used)));
}

std::size_t unknowns_of(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::plane:
      return 3;
    case PrimitiveKind::sphere:
      return 4;
    case PrimitiveKind::cylinder:
      return 5;
    case PrimitiveKind::cone:
      return 6;
    default:
      return 7;
  }
}

class Inspector {
 public:
  Inspector(const Compared& compared, const MeshFeature& feature, const FeatureVerdict& row,
            const VerifyOptions& options)
      : c_(compared),
        feature_(feature),
        nominal_(*feature.primitive),
        row_(row),
        name_(row.name),
        tolerance_(options.tolerance),
        words_(options.tolerance) {}

  Inspection run(const std::vector<std::uint32_t>& points) {
    if (!gather(points) || !measure()) return {};
    describe();
    if (result_.dimensions.empty()) return {};
    const double limit = std::max(tolerance_, 3 * found_.sigma_shift);
    if (found_.shift > limit) {
      blame(limit);
      tell();
    } else if (round_ && row_.verdict != Outcome::verified && feature_.sagitta > coarse_facets * tolerance_) {
      tell_coarse();
    }
    return finished();
  }

  Inspection run_anew(const std::vector<std::uint32_t>& points) {
    anew_ = true;
    const std::size_t every = points.size() / most_points + 1;
    for (std::size_t i = 0; i < points.size(); i += every) found_.points.push_back(c_.source.points[points[i]]);
    if (!enough() || !measure()) return {};
    // Where what was fitted runs into the artifact only points on one side of it were unexplained: without them.
    const double close = 2 * std::max(3 * c_.source.noise, 0.3 * tolerance_);
    const Primitive m = found_.fit.primitive;
    std::erase_if(found_.points, [&](const Vec3& p) {
      return c_.surface.closest(p - distance(m, p) * surface_normal(m, p)).distance <= close;
    });
    if (!enough() || !measure()) return {};
    describe();
    const double limit = std::max(tolerance_, 3 * found_.sigma_shift);
    if (result_.dimensions.empty() || found_.shift <= limit) return {};
    blame(limit);
    tell();
    return finished();
  }

 private:
  const Compared& c_;
  const MeshFeature& feature_;
  const Primitive nominal_;
  const FeatureVerdict& row_;
  const std::string& name_;
  bool anew_ = false;
  bool round_ = false;  // the scan shows no facets where the artifact has coarse ones
  double tolerance_;
  Words words_;
  Fitted found_;
  Inspection result_;
  std::vector<double> moves_;         // mm, how far each dimension moves the surface; as result_.dimensions
  Vec3 displacement_ = Vec3::Zero();  // of the measured axis, centre or plane

  Inspection finished() {
    result_.measured = found_.fit.primitive;
    result_.close = std::max(4 * c_.source.noise, tolerance_);
    result_.shift = found_.shift;
    for (const auto& p : found_.points) result_.reach = std::max(result_.reach, (p - feature_.middle).norm());
    return std::move(result_);
  }

  bool enough() const { return found_.points.size() >= std::max<std::size_t>(12, 3 * unknowns_of(nominal_.kind)); }

  bool gather(const std::vector<std::uint32_t>& points) {
    std::vector<std::uint32_t> usable;
    const std::size_t step = points.size() / (2 * most_points) + 1;
    std::vector<Neighbour> near;
    for (std::size_t i = 0; i < points.size(); i += step) {
      const auto p = points[i];
      const Vec3 normal = scanned_normal(c_.source, p, near);
      if (normal.squaredNorm() > 0.5 && std::abs(normal.dot(surface_normal(nominal_, c_.source.points[p]))) < same_face)
        continue;
      usable.push_back(p);
    }
    const std::size_t every = usable.size() / most_points + 1;
    for (std::size_t i = 0; i < usable.size(); i += every) found_.points.push_back(c_.source.points[usable[i]]);
    if (!enough()) return false;
    if (feature_.sagitta > fine_facets * tolerance_) judge_facets();
    return true;
  }

  /// Where facets are coarse, the scan shows the polygon itself or the round surface that it stands for: what fits
  /// better.
  void judge_facets() {
    std::vector<Vec3> as_facets;
    for (const auto& p : found_.points) as_facets.push_back(without_facets(c_, nominal_, p));
    auto scatter = [&](const std::vector<Vec3>& points) {
      PrimitiveFitOptions how;
      how.start = nominal_;
      how.robust = 2.5;
      const auto fit = fit_primitive(nominal_.kind, points, {}, how);
      if (!fit) return std::numeric_limits<double>::infinity();
      std::vector<double> sizes;
      for (const auto& p : points) sizes.push_back(std::abs(distance(fit->primitive, p)));
      return quantile(std::move(sizes), 0.7);
    };
    if (scatter(as_facets) < scatter(found_.points))
      found_.points = std::move(as_facets);
    else
      round_ = true;
  }

  bool measure() {
    PrimitiveFitOptions how;
    if (!anew_) how.start = nominal_;
    const auto first = fit_primitive(nominal_.kind, found_.points, {}, how);
    if (!first) return false;
    how.start = first->primitive;
    how.robust = 2.5;
    const auto second = fit_primitive(nominal_.kind, found_.points, {}, how);
    if (!second || !second->converged || !second->determined) return false;
    found_.fit = *second;
    Primitive& m = found_.fit.primitive;
    if (m.axis.dot(nominal_.axis) < 0) {
      m.axis = -m.axis;
      if (m.kind == PrimitiveKind::cone) return false;
    }
    const bool turned = nominal_.kind != PrimitiveKind::sphere && m.axis.dot(nominal_.axis) < std::cos(radians(20));
    if (turned || (anew_ ? !may_be(m) : std::abs(m.radius - nominal_.radius) > 0.6 * nominal_.radius + 10 * tolerance_))
      return false;
    // Most points must lie on what was fitted, or it is no such surface.
    const double close = std::max(4 * c_.source.noise, 0.7 * tolerance_);
    std::size_t on_it = 0;
    std::vector<Vec3> inliers;
    for (const auto& p : found_.points)
      if (std::abs(distance(m, p)) <= close) ++on_it, inliers.push_back(p);
    if (10 * on_it < 6 * found_.points.size()) return false;
    found_.inflation = inflation_of(m, inliers);
    const double floor = 0.1 * c_.source.noise;
    auto honest = [&](double sigma) { return sigma > 0 ? std::hypot(found_.inflation * sigma, floor) : 0.0; };
    auto& f = found_.fit;
    f.sigma_point = honest(f.sigma_point), f.sigma_radius = honest(f.sigma_radius), f.sigma_tube = honest(f.sigma_tube);
    const double reach = std::max(half_length(), 1e-9);
    f.sigma_axis = f.sigma_axis > 0 ? std::hypot(found_.inflation * f.sigma_axis, floor / reach) : 0;
    f.sigma_half_angle = f.sigma_half_angle > 0 ? std::hypot(found_.inflation * f.sigma_half_angle, floor / reach) : 0;
    std::vector<double> shifts;
    for (const auto& p : inliers) {
      const double off = distance(nominal_, p);
      shifts.push_back(std::abs(distance(m, p - off * surface_normal(nominal_, p))));
    }
    // The few largest may belong to a neighbour.
    found_.shift = quantile(std::move(shifts), 0.98);
    found_.sigma_shift = std::hypot(f.sigma_point, std::hypot(f.sigma_radius + f.sigma_tube, f.sigma_axis * reach));
    // One view may have seen one half of it, another view the other.
    found_.sigma_shift = std::hypot(found_.sigma_shift, c_.source.disagreement);
    if (feature_.arc < radians(180) && nominal_.kind != PrimitiveKind::plane && nominal_.kind != PrimitiveKind::sphere)
      found_.sigma_shift = std::min(found_.sigma_shift, 0.5 * tolerance_);  // radius and place err together
    return true;
  }

  /// The feature itself with another radius, and no other one: a round or fillet keeps to its edge, so that its axis
  /// moves as its radius grows; a hole or boss stands about the same axis. Seen over most of the arc that it should
  /// have.
  bool may_be(const Primitive& m) const {
    Vec3 moved = m.point - nominal_.point;
    moved -= moved.dot(nominal_.axis) * nominal_.axis;
    const double grown = std::abs(m.radius - nominal_.radius);
    const bool full = feature_.arc > radians(240);
    if (moved.norm() >
        (full ? 0.5 * std::max(m.radius, nominal_.radius) : 1.6 * grown + 0.5 * nominal_.radius + 10 * tolerance_))
      return false;
    const Mat3 frame = rotation_onto_axis(m.axis);
    std::vector<char> seen(72, 0);
    const double close = std::max(4 * c_.source.noise, 0.7 * tolerance_);
    for (const auto& p : found_.points) {
      if (std::abs(distance(m, p)) > close) continue;
      const Vec3 q = frame.transpose() * (p - m.point);
      seen[std::min<std::size_t>(71, static_cast<std::size_t>((std::atan2(q.y(), q.x()) + pi) / (2 * pi) * 72))] = 1;
    }
    return static_cast<double>(std::count(seen.begin(), seen.end(), 1)) / 72 * 2 * pi > least_arc * feature_.arc;
  }

  /// mm, of what the fit covers: along the axis, or across a plane.
  double half_length() const {
    if (nominal_.kind == PrimitiveKind::plane || nominal_.kind == PrimitiveKind::sphere) {
      double farthest = 0;
      for (const auto& p : found_.points) farthest = std::max(farthest, (p - feature_.middle).squaredNorm());
      return std::sqrt(farthest);
    }
    return std::max(0.5 * (feature_.high - feature_.low), 1e-6);
  }

  void add(const std::string& what, Quantity quantity, double nominal, double measured, double sigma, double move) {
    FeatureDimension d;
    d.name = what, d.quantity = quantity, d.nominal = nominal, d.measured = measured, d.sigma = sigma;
    d.deviation = measured - nominal;
    result_.dimensions.push_back(d);
    moves_.push_back(std::abs(move));
  }

  bool known(double sigma, double lever = 1) const { return sigma * lever <= known_well * tolerance_; }

  void describe() {
    switch (nominal_.kind) {
      case PrimitiveKind::plane:
        return describe_plane();
      case PrimitiveKind::sphere:
        return describe_sphere();
      case PrimitiveKind::cylinder:
        return describe_cylinder();
      case PrimitiveKind::cone:
        return describe_cone();
      case PrimitiveKind::torus:
        return describe_torus();
      default:
        return;
    }
  }

  void describe_plane() {
    const auto& m = found_.fit.primitive;
    const Vec3& n = nominal_.axis;
    const double facing = n.dot(m.axis);
    const double off = (m.point - feature_.middle).dot(m.axis) / facing;  // along n, through the middle
    displacement_ = off * n;
    Eigen::Index axis;
    const bool square = n.cwiseAbs().maxCoeff(&axis) > std::cos(radians(0.5));
    const double sigma = found_.fit.sigma_point;
    if (!known(sigma)) return;
    if (square) {
      const double nominal = feature_.middle[axis];
      add(std::string("position ") + "xyz"[axis], Quantity::length, nominal, nominal + off * (n[axis] > 0 ? 1 : -1),
          sigma, off);
    } else {
      const double nominal = n.dot(feature_.middle);
      add("offset", Quantity::length, nominal, nominal + off, sigma, off);
    }
    add_tilt(m.axis, half_length());
  }

  void add_tilt(const Vec3& axis, double lever) {
    if (!known(found_.fit.sigma_axis, lever)) return;
    const double tilt = std::atan2(axis.cross(nominal_.axis).norm(), axis.dot(nominal_.axis));
    add("tilt", Quantity::angle, 0, tilt, found_.fit.sigma_axis, tilt * lever);
  }

  /// Coordinates of `nominal` and `measured` that the feature fixes: all of a centre, those across an axis.
  void add_position(const Vec3& nominal, const Vec3& measured, double sigma, bool has_axis) {
    displacement_ = measured - nominal;
    if (!known(sigma)) return;
    for (Eigen::Index k = 0; k < 3; ++k)
      if (!has_axis || std::abs(nominal_.axis[k]) < std::cos(radians(10)))
        add(std::string("position ") + "xyz"[k], Quantity::length, nominal[k], measured[k], sigma, displacement_[k]);
  }

  void describe_sphere() {
    const auto& m = found_.fit.primitive;
    if (!known(found_.fit.sigma_radius)) return;
    add("diameter", Quantity::length, 2 * nominal_.radius, 2 * m.radius, 2 * found_.fit.sigma_radius,
        m.radius - nominal_.radius);
    add_position(nominal_.point, m.point, found_.fit.sigma_point, false);
  }

  /// Where the measured axis passes the plane across the nominal axis at `place`.
  Vec3 axis_at(const Primitive& m, const Vec3& place) const {
    const double t = (place - m.point).dot(nominal_.axis) / m.axis.dot(nominal_.axis);
    return m.point + t * m.axis;
  }

  void describe_cylinder() {
    const auto& m = found_.fit.primitive;
    const auto& f = found_.fit;
    const bool full = feature_.kind == "hole" || feature_.kind == "boss";
    if (known(f.sigma_radius)) {
      if (full)
        add("diameter", Quantity::length, 2 * nominal_.radius, 2 * m.radius, 2 * f.sigma_radius,
            m.radius - nominal_.radius);
      else
        add("radius", Quantity::length, nominal_.radius, m.radius, f.sigma_radius, 0);
    }
    // Where it meets its face; the end that looks up, or along +y, +x, counts.
    const Vec3 end = nominal_.point + feature_.high * nominal_.axis;
    const Vec3 middle = nominal_.point;
    const double at_end = std::hypot(f.sigma_point, f.sigma_axis * half_length());
    const bool by_end = known(at_end) && known(f.sigma_axis, half_length());
    const Vec3& place = by_end ? end : middle;
    if (full || feature_.arc > radians(150))
      add_position(place, axis_at(m, place), by_end ? at_end : f.sigma_point, true);
    displacement_ = axis_at(m, middle) - middle;
    if (full) add_tilt(m.axis, half_length());
  }

  void describe_cone() {
    const auto& m = found_.fit.primitive;
    const auto& f = found_.fit;
    const double lever = half_length() / std::max(std::cos(nominal_.half_angle), 0.05);
    if (known(f.sigma_half_angle, lever))
      add("half angle", Quantity::angle, nominal_.half_angle, m.half_angle, f.sigma_half_angle,
          (m.half_angle - nominal_.half_angle) * lever);
    const Vec3 place = feature_.middle;
    const Vec3 there = axis_at(m, place);
    auto radius_at = [&](const Primitive& p, const Vec3& q) {
      return p.radius + (q - p.point).dot(p.axis) * std::tan(p.half_angle);
    };
    const double nominal = radius_at(nominal_, place), measured = radius_at(m, there);
    const double sigma = std::hypot(f.sigma_radius, f.sigma_point);
    if (known(sigma))
      add("diameter in the middle", Quantity::length, 2 * nominal, 2 * measured, 2 * sigma,
          (measured - nominal) * std::cos(nominal_.half_angle));
    if (feature_.arc > radians(240)) {
      add_position(place, there, f.sigma_point, true);
      add_tilt(m.axis, half_length());
    }
  }

  void describe_torus() {
    const auto& m = found_.fit.primitive;
    const auto& f = found_.fit;
    if (feature_.kind != "torus") {
      if (known(f.sigma_tube)) add("radius", Quantity::length, nominal_.tube, m.tube, f.sigma_tube, 0);
      return;
    }
    if (known(f.sigma_radius))
      add("ring diameter", Quantity::length, 2 * nominal_.radius, 2 * m.radius, 2 * f.sigma_radius,
          m.radius - nominal_.radius);
    if (known(f.sigma_tube))
      add("tube diameter", Quantity::length, 2 * nominal_.tube, 2 * m.tube, 2 * f.sigma_tube, m.tube - nominal_.tube);
    if (feature_.arc > radians(240)) add_position(nominal_.point, m.point, f.sigma_point, false);
  }

  /// The feature is off as a whole: marks the dimensions that are, at least the one that moves it most.
  void blame(double limit) {
    bool any = false;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < moves_.size(); ++i) {
      auto& d = result_.dimensions[i];
      d.within = moves_[i] <= limit;
      any = any || !d.within;
      if (moves_[i] > moves_[worst]) worst = i;
    }
    if (!any && displacement_.norm() > 0.7 * limit) {
      std::size_t best = moves_.size();
      for (std::size_t i = 0; i < moves_.size(); ++i)
        if (result_.dimensions[i].name.rfind("position", 0) == 0 && (best == moves_.size() || moves_[i] > moves_[best]))
          best = i;
      if (best < moves_.size()) worst = best;
    }
    if (!any) result_.dimensions[worst].within = false;
  }

  Finding about_it() const {
    Finding f;
    f.kind = Finding::Kind::displaced;
    f.feature = name_;
    f.points = found_.points.size();
    f.place = c_.surface.closest(feature_.middle).point;
    f.area = feature_.area;
    Box3 box;
    for (const auto& p : found_.points) box.add(p);
    f.extent = box.diagonal();
    return f;
  }

  /// The scan is where the corners are; the flat facets between them lie too far inside.
  void tell_coarse() {
    Finding f = about_it();
    f.deviation = feature_.sagitta;
    f.reason = "its flat facets leave the round surface that the scan shows";
    const int sides = sides_of(feature_);
    const double radius = std::max(nominal_.radius, nominal_.tube),
                 inside = std::min(1.0, wanted_facets * tolerance_ / radius);
    std::string mend = how_to_draw_finer(c_.file, 4 * static_cast<int>(std::ceil(pi / std::acos(1 - inside) / 4)));
    if (!mend.empty()) mend = ": " + mend;
    f.text = with_size(name_, feature_, tolerance_) + ": drawn " +
             (sides > 0 ? "with " + std::to_string(sides) + " sides" : "too coarse") + ", up to " +
             words_.mm(feature_.sagitta) + " mm inside" + mend + ", at " + words_.place(feature_.middle);
    result_.finding = f;
  }

  void tell() {
    Finding f = about_it();
    f.deviation = found_.shift;
    f.reason = "the surface fitted to its scanned points lies elsewhere";
    std::string text;
    auto say = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
    bool moved = false;
    for (std::size_t i = 0; i < result_.dimensions.size(); ++i) {
      const auto& d = result_.dimensions[i];
      if (d.within) continue;
      const bool position = d.name.rfind("position", 0) == 0 || d.name == "offset";
      if (position && moved) continue;
      if (position) {
        moved = true;
        f.direction = displacement_.normalized();
        f.deviation = displacement_.norm();
        say(std::string(nominal_.kind == PrimitiveKind::plane ? "" : "centre ") + words_.mm(displacement_.norm()) +
            " mm too far in " + direction_text(-displacement_));
      } else if (d.name == "tilt") {
        say("tilted by " + shown(degrees(d.measured), 0.01) + " degrees");
      } else if (d.quantity == Quantity::angle) {
        say(d.name + " " + shown(degrees(d.nominal), 0.01) + " degrees, the scan says " +
            shown(degrees(d.measured), 0.01) + " +- " + shown(std::max(degrees(d.sigma), 0.01), 0.01));
      } else {
        say(d.name + " " + words_.mm(d.nominal) + ", the scan says " + words_.with_sigma(d.measured, d.sigma));
      }
    }
    f.text = with_size(name_, feature_, tolerance_) + ": " + text + ", at " + words_.place(feature_.middle);
    if (feature_.kind == "plane")
      f.text = name_ + ": " + text + " over " + words_.area(f.area) + " mm^2 at " + words_.place(feature_.middle);
    result_.finding = f;
  }
};

}  // namespace

std::string with_size(const std::string& name, const MeshFeature& feature, double tolerance) {
  if (!feature.primitive) return name;
  const Words words(tolerance);
  const Primitive& p = *feature.primitive;
  if (feature.kind == "hole" || feature.kind == "boss" || feature.kind == "sphere")
    return name + " (diameter " + words.mm(2 * p.radius) + ")";
  if (feature.kind == "fillet" || feature.kind == "round" || feature.kind == "cylinder")
    return name + " (radius " + words.mm(p.kind == PrimitiveKind::torus ? p.tube : p.radius) + ")";
  if (feature.kind == "cone") return name + " (" + shown(degrees(2 * p.half_angle), 0.1) + " degrees)";
  return name;
}

Inspection inspect(const Compared& compared, const MeshFeature& feature, const FeatureVerdict& row,
                   const std::vector<std::uint32_t>& points, const VerifyOptions& options) {
  if (!feature.primitive || feature.primitive->kind == PrimitiveKind::line ||
      feature.primitive->kind == PrimitiveKind::circle || points.size() < 12)
    return {};
  return Inspector(compared, feature, row, options).run(points);
}

Inspection inspect_anew(const Compared& compared, const MeshFeature& feature, const FeatureVerdict& row,
                        const std::vector<std::uint32_t>& points, const VerifyOptions& options) {
  if (!feature.primitive || feature.primitive->kind != PrimitiveKind::cylinder) return {};
  return Inspector(compared, feature, row, options).run_anew(points);
}

}  // namespace partscribe::verify
