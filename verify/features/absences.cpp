#include "verify/features/absences.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/number.h"
#include "verify/compare/clusters.h"
#include "verify/features/inspect.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t fewest_points = 9;  // that can prove a face across a hole
constexpr std::size_t fewest_on_wall = 20;
constexpr int most_walls = 6;         // of one connected piece of scanned surface
constexpr double across_axis = 0.26;  // cosine between a cylinder's axis and its normals, at most
constexpr double seen_of = 0.35;      // share of a feature that is there
constexpr int sectors = 36;

std::string axis_text(const Vec3& axis) {
  const std::string text = direction_text(axis);
  return text.size() == 2 ? text.substr(1) : text;
}

/// Radius of a cylinder or cone so far along its axis.
double radius_at(const Primitive& p, double along) {
  return p.radius + (p.kind == PrimitiveKind::cone ? along * std::tan(p.half_angle) : 0);
}

bool is_round_feature(const MeshFeature& f) {
  return f.primitive && (f.kind == "hole" || f.kind == "boss" || f.kind == "cone");
}

/// "hole", "boss", "countersink", "cone".
std::string noun_of(const Absence& a) {
  if (a.axis.kind == PrimitiveKind::cone) return a.hollow ? "countersink" : "cone";
  return a.hollow ? "hole" : "boss";
}

std::string plural_of(const std::string& noun) { return noun + (noun == "boss" ? "es" : "s"); }

/// A cylinder, or a cone, that at least half of the points whose normals suit it lie on, and half the way around.
/// `on`: which points are on it.
std::optional<Absence> wall_of(PrimitiveKind kind, const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                               double close, double tolerance, std::vector<char>& on) {
  std::vector<Vec3> axes = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  Mat3 moments = Mat3::Zero();
  for (const auto& n : normals) moments += n * n.transpose();
  const Mat3 principal = Eigen::SelfAdjointEigenSolver<Mat3>(moments).eigenvectors();
  axes.push_back(principal.col(0));
  if (kind == PrimitiveKind::cone) axes.push_back(principal.col(2));
  std::optional<Absence> best;
  std::size_t most = 0;
  for (const auto& axis : axes) {
    std::vector<Vec3> wall, outward;
    std::vector<std::size_t> index;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double along = std::abs(normals[i].dot(axis));
      if (kind == PrimitiveKind::cylinder ? along < across_axis : along > across_axis && along < 0.97)
        wall.push_back(points[i]), outward.push_back(normals[i]), index.push_back(i);
    }
    if (wall.size() < fewest_on_wall || 4 * wall.size() < points.size()) continue;
    PrimitiveFitOptions how;
    how.robust = 2.5;
    const auto fit = fit_primitive(kind, wall, outward, how);
    if (!fit || !fit->determined || fit->sigma_radius > tolerance || std::abs(fit->primitive.axis.dot(axis)) < 0.94)
      continue;
    Absence a;
    a.axis = fit->primitive;
    Eigen::Index along;
    a.axis.axis.cwiseAbs().maxCoeff(&along);
    if (kind == PrimitiveKind::cylinder && a.axis.axis[along] < 0) a.axis.axis = -a.axis.axis;
    const Mat3 frame = rotation_onto_axis(a.axis.axis);
    std::array<bool, sectors> seen{};
    std::vector<char> members(points.size(), 0);
    std::size_t on_it = 0;
    a.low = 1e300, a.high = -1e300;
    for (std::size_t i = 0; i < wall.size(); ++i) {
      if (std::abs(distance(a.axis, wall[i])) > close) continue;
      ++on_it, members[index[i]] = 1;
      const Vec3 q = frame.transpose() * (wall[i] - a.axis.point);
      a.low = std::min(a.low, q.z()), a.high = std::max(a.high, q.z());
      seen[std::min<std::size_t>(
          sectors - 1, static_cast<std::size_t>((std::atan2(q.y(), q.x()) + pi) / (2 * pi) * sectors))] = true;
    }
    if (on_it < fewest_on_wall || 2 * on_it < wall.size() || on_it <= most) continue;
    if (2 * std::count(seen.begin(), seen.end(), true) < sectors) continue;
    most = on_it, best = a, on = members;
  }
  if (best) best->center = best->axis.point + 0.5 * (best->low + best->high) * best->axis.axis;
  return best;
}

}  // namespace

std::int32_t most_of(const std::map<std::int32_t, double>& rows) {
  std::int32_t best = -1;
  double most = -1;
  for (const auto& [row, weight] : rows)
    if (row >= 0 && weight > most) most = weight, best = row;
  return best;
}

Absences::Absences(const Compared& compared, const std::vector<Spot>& spots, const VerifyOptions& options)
    : c_(compared), spots_(spots), tolerance_(options.tolerance), far_(options.tolerance + 3 * compared.source.noise) {
  find_missing();
  find_extra();
  join_moved();
  count_equal();
  for (const auto* list : {&missing_, &extra_})
    for (const auto& a : *list)
      if (!a.finding.text.empty()) findings_.push_back(a.finding);
}

std::string Absences::name_of_row(std::int32_t row) const {
  return row < 0 ? "" : c_.rows[static_cast<std::size_t>(row)].name;
}

const MeshFeature* Absences::feature_of(std::int32_t row) const {
  const auto number = row < 0 ? -1 : c_.feature_of_row[static_cast<std::size_t>(row)];
  return number < 0 ? nullptr : &c_.features.features[static_cast<std::size_t>(number)];
}

/// Walls of holes, bosses and countersinks that the scan shows and the artifact lacks.
void Absences::find_missing() {
  std::vector<Vec3> places;
  std::vector<double> reach;
  std::vector<std::uint32_t> index;
  for (std::uint32_t i = 0; i < spots_.size(); ++i)
    if (spots_[i].foreign)
      places.push_back(c_.source.points[spots_[i].point]), reach.push_back(spots_[i].reach), index.push_back(i);
  const auto groups = clusters_of(places, reach, [&](std::uint32_t a, std::uint32_t b) {
    return (spots_[index[a]].deviation > 0) == (spots_[index[b]].deviation > 0);
  });
  const double close = std::max(4 * c_.source.noise, tolerance_);
  std::vector<Neighbour> near;
  for (const auto& group : groups) {
    std::vector<std::uint32_t> rest;
    for (const auto i : group) rest.push_back(index[i]);
    for (int wall = 0; wall < most_walls && rest.size() >= fewest_on_wall; ++wall) {
      std::vector<Vec3> points, normals;
      const std::size_t step = rest.size() / 1500 + 1;
      for (std::size_t i = 0; i < rest.size(); i += step) {
        const auto p = spots_[rest[i]].point;
        const Vec3 normal = scanned_normal(c_.source, p, near);
        if (normal.squaredNorm() < 0.5) continue;
        points.push_back(c_.source.points[p]), normals.push_back(normal);
      }
      if (points.size() < fewest_on_wall) break;
      std::vector<char> on;
      auto found = wall_of(PrimitiveKind::cylinder, points, normals, close, tolerance_, on);
      if (!found) found = wall_of(PrimitiveKind::cone, points, normals, close, tolerance_, on);
      if (!found) break;
      Absence a = *found;
      Finding& f = a.finding;
      f.kind = Finding::Kind::missing_material;
      double weight = 0, nearest = 1e300;
      std::map<std::int32_t, double> rows;
      std::vector<std::uint32_t> others;
      for (const auto i : rest) {
        const Spot& s = spots_[i];
        const Vec3& p = c_.source.points[s.point];
        const double along = (p - a.axis.point).dot(a.axis.axis);
        if (std::abs(distance(a.axis, p)) > close || along < a.low - close || along > a.high + close) {
          others.push_back(i);
          continue;
        }
        f.deviation = std::max(f.deviation, std::abs(s.deviation));
        f.area += s.area, weight += s.weight, rows[s.row] += s.weight;
        if ((p - a.center).squaredNorm() < nearest) nearest = (p - a.center).squaredNorm(), f.place = p;
      }
      f.points = static_cast<std::size_t>(weight);
      f.feature = name_of_row(most_of(rows));
      // Where nobody knows from which side it was seen: a boss has an end, and what lies outside the artifact without
      // one is the wall of a hole that the artifact has too wide.
      const bool outside = spots_[rest.front()].deviation > 0;
      const double side = seen_from_axis(a.axis, rest, close);
      const bool ended = std::any_of(others.begin(), others.end(), [&](std::uint32_t i) {
        return spots_[i].foreign && holds(a, c_.source.points[spots_[i].point], -0.3 * a.axis.radius);
      });
      a.hollow = side != 0 ? side > 0 : !outside || !ended;
      a.open = a.hollow && outside;
      missing_.push_back(std::move(a));
      if (others.size() == rest.size()) break;
      rest = std::move(others);
    }
  }
  join_pieces(2 * (close + c_.source.spacing));
  for (auto& a : missing_) tell_missing(a);
}

/// Positive where the wall was seen from its axis, as that of a hole is; negative from outside; 0 where nobody knows.
double Absences::seen_from_axis(const Primitive& wall, const std::vector<std::uint32_t>& spots, double close) const {
  const bool known = c_.source.closed_surface && !c_.source.normals.empty();
  if (!known && c_.source.rays.empty()) return 0;
  double side = 0;
  for (const auto i : spots) {
    const auto p = spots_[i].point;
    const Vec3& point = c_.source.points[p];
    if (std::abs(distance(wall, point)) > close) continue;
    side += (known ? c_.source.normals[p] : Vec3(-c_.source.rays[p])).dot(surface_normal(wall, point));
  }
  return -side;
}

/// A wall that a face of the artifact cuts in two, or that lies partly outside of it, is one.
void Absences::join_pieces(double gap) {
  for (std::size_t i = 0; i < missing_.size(); ++i)
    for (std::size_t k = missing_.size(); --k > i;) {
      Absence &a = missing_[i], &b = missing_[k];
      if (!equal(a, b) || a.axis.kind != PrimitiveKind::cylinder) continue;
      const Vec3& axis = a.axis.axis;
      const Vec3 apart = b.center - a.center;
      const double along = apart.dot(axis), half = 0.5 * (b.high - b.low);
      const double middle = (a.center - a.axis.point).dot(axis) + along;  // of b, from a's point
      if ((apart - along * axis).norm() > gap || middle - half > a.high + gap || middle + half < a.low - gap) continue;
      a.low = std::min(a.low, middle - half), a.high = std::max(a.high, middle + half);
      a.center = a.axis.point + 0.5 * (a.low + a.high) * axis;
      a.open = a.open && b.open;
      if (b.finding.points > a.finding.points) a.finding.feature = b.finding.feature, a.finding.place = b.finding.place;
      a.finding.area += b.finding.area, a.finding.points += b.finding.points;
      a.finding.deviation = std::max(a.finding.deviation, b.finding.deviation);
      missing_.erase(missing_.begin() + static_cast<std::ptrdiff_t>(k));
    }
}

void Absences::tell_missing(Absence& a) const {
  const Words words(tolerance_);
  const double low = radius_at(a.axis, a.low), high = radius_at(a.axis, a.high);
  const bool cone = a.axis.kind == PrimitiveKind::cone;
  const std::string what = cone ? "conical" : "cylindrical";
  Finding& f = a.finding;
  f.extent = std::hypot(2 * std::max(low, high), a.high - a.low);
  f.reason = "the scan shows a " + what + " wall, the artifact has none";
  f.text = (a.open ? "missing material about a " : "missing ") + noun_of(a) + ": the scan shows a " + what +
           " wall of " +
           (cone ? shown(degrees(2 * a.axis.half_angle), 0.1) + " degrees, diameter " + words.mm(2 * low) + " to " +
                       words.mm(2 * high)
                 : "diameter " + words.mm(2 * a.axis.radius)) +
           " about " + words.place(a.center) + " along " + axis_text(a.axis.axis) + ", the artifact has none";
}

/// Holes, bosses and countersinks of the artifact that the scan shows nothing of, or an unbroken face across.
void Absences::find_extra() {
  const Words words(tolerance_);
  std::vector<std::array<std::size_t, 3>> states(c_.rows.size(), {0, 0, 0});
  std::vector<std::map<std::int32_t, double>> rows(c_.features.features.size());  // where each feature's samples are
  for (std::size_t i = 0; i < c_.field.samples.size(); ++i) {
    if (c_.sample_row[i] < 0) continue;
    ++states[static_cast<std::size_t>(c_.sample_row[i])][static_cast<std::size_t>(c_.field.support[i])];
    ++rows[c_.features.feature_of[c_.field.samples[i].triangle]][c_.sample_row[i]];
  }
  for (std::size_t r = 0; r < c_.rows.size(); ++r) {
    const auto row = static_cast<std::int32_t>(r);
    const MeshFeature* feature = feature_of(row);
    if (!feature || c_.explained_row[r] || !is_round_feature(*feature)) continue;
    const auto& s = states[r];
    const auto total = static_cast<double>(s[0] + s[1] + s[2]);
    if (total == 0 || static_cast<double>(s[0]) > seen_of * total) continue;
    Absence a;
    a.axis = *feature->primitive, a.low = feature->low, a.high = feature->high, a.hollow = feature->hollow;
    a.row = row;
    // Scanned surface in the mouth of a hole, or where a boss should be.
    double area = 0;
    std::size_t inside = 0;
    for (const auto& spot : spots_)
      if (holds(a, c_.source.points[spot.point], -0.1 * a.axis.radius))
        area += spot.area, inside += static_cast<std::size_t>(spot.weight);
    const double mouth = pi * a.axis.radius * a.axis.radius;
    const bool across = inside >= fewest_points && area > 0.3 * mouth;
    const bool refuted = static_cast<double>(s[2]) > 0.3 * total;
    if (!across && !refuted) continue;
    Finding& f = a.finding;
    f.kind = Finding::Kind::invented_material;
    f.feature = name_of_row(most_of(rows[static_cast<std::size_t>(c_.feature_of_row[r])]));
    a.center = feature->middle;
    f.place = c_.surface.closest(a.center).point;
    f.area = feature->area, f.deviation = a.axis.radius, f.points = inside;
    f.extent = std::hypot(2 * a.axis.radius, a.high - a.low);
    f.reason = across ? "the scan shows surface across it" : "the scan contradicts its wall";
    f.text = "extra " + with_size(f.feature, *feature, tolerance_) + " at " + words.place(a.center) +
             ": the scan shows " +
             (feature->hollow ? across ? "an unbroken face there" : "no such wall"
              : across        ? "a face in its place"
                              : "nothing there");
    extra_.push_back(std::move(a));
  }
  // The wall of a hole goes on where the artifact has a countersink too many.
  std::erase_if(missing_, [&](const Absence& gone) {
    return gone.open && std::any_of(extra_.begin(), extra_.end(), [&](const Absence& extra) {
             return extra.axis.kind == PrimitiveKind::cone && holds(extra, gone.center, 0);
           });
  });
}

/// Inside the room that the feature takes, widened by `margin`.
bool Absences::holds(const Absence& a, const Vec3& point, double margin) const {
  const Vec3 d = point - a.axis.point;
  const double t = d.dot(a.axis.axis);
  const double beyond = far_ + std::max(margin, 0.0);
  return t > a.low - beyond && t < a.high + beyond && (d - t * a.axis.axis).norm() < radius_at(a.axis, t) + margin;
}

bool Absences::speak_of(const Vec3& point) const {
  const double margin = far_ + c_.source.spacing;
  for (const auto* list : {&missing_, &extra_, &moved_})
    for (const auto& a : *list)
      if (holds(a, point, margin)) return true;
  return false;
}

/// Of one kind and size, and parallel.
bool Absences::equal(const Absence& a, const Absence& b) const {
  return a.axis.kind == b.axis.kind && a.hollow == b.hollow && std::abs(a.axis.axis.dot(b.axis.axis)) > 0.985 &&
         std::abs(radius_at(a.axis, 0.5 * (a.low + a.high)) - radius_at(b.axis, 0.5 * (b.low + b.high))) <=
             3 * tolerance_;
}

/// A missing and an extra feature of one size are one that stands in the wrong place; of several, the nearest ones. No
/// feature is taken twice.
void Absences::join_moved() {
  const Words words(tolerance_);
  struct Pair {
    double apart;
    std::size_t gone, extra;
  };
  auto between = [&](const Absence& gone, const Absence& extra) {
    const Vec3 d = gone.center - extra.center;
    return Vec3(d - d.dot(extra.axis.axis) * extra.axis.axis);
  };
  std::vector<Pair> pairs;
  for (std::size_t g = 0; g < missing_.size(); ++g)
    for (std::size_t e = 0; e < extra_.size(); ++e)
      if (equal(missing_[g], extra_[e])) pairs.push_back({between(missing_[g], extra_[e]).norm(), g, e});
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.apart < b.apart; });
  std::vector<char> gone_taken(missing_.size(), 0), extra_taken(extra_.size(), 0);
  for (const auto& pair : pairs) {
    if (gone_taken[pair.gone] || extra_taken[pair.extra]) continue;
    gone_taken[pair.gone] = extra_taken[pair.extra] = 1;
    Absence& extra = extra_[pair.extra];
    const Vec3 apart = between(missing_[pair.gone], extra);
    Finding& f = extra.finding;
    f.kind = Finding::Kind::displaced;
    f.direction = apart.norm() > 0 ? Vec3(apart.normalized()) : Vec3::Zero();
    f.deviation = apart.norm();
    f.reason = "the scan shows it in another place";
    f.text = with_size(f.feature, *feature_of(extra.row), tolerance_) + ": centre " + words.mm(apart.norm()) +
             " mm too far in " + direction_text(-apart) + ", at " + words.place(extra.center);
    findings_.push_back(f);
    moved_.push_back(extra), moved_.push_back(missing_[pair.gone]);
  }
  auto keep = [](std::vector<Absence>& list, const std::vector<char>& taken) {
    std::vector<Absence> rest;
    for (std::size_t i = 0; i < list.size(); ++i)
      if (!taken[i]) rest.push_back(std::move(list[i]));
    list = std::move(rest);
  };
  keep(missing_, gone_taken), keep(extra_, extra_taken);
}

/// Of several equal features it is said how many either side has, and which ones only one of them.
void Absences::count_equal() {
  const Words words(tolerance_);
  for (auto* list : {&extra_, &missing_}) {
    const bool invented = list == &extra_;
    for (std::size_t i = 0; i < list->size(); ++i) {
      Absence& first = (*list)[i];
      if (first.finding.text.empty() || first.open) continue;
      std::vector<Absence*> alike = {&first};
      for (std::size_t k = i + 1; k < list->size(); ++k)
        if (!(*list)[k].finding.text.empty() && equal(first, (*list)[k])) alike.push_back(&(*list)[k]);
      auto told = [&](std::int32_t row) {
        auto has = [&](const std::vector<Absence>& some) {
          return std::any_of(some.begin(), some.end(), [&](const Absence& a) { return a.row == row; });
        };
        return c_.explained_row[static_cast<std::size_t>(row)] || has(extra_) || has(moved_);
      };
      std::size_t here = 0;  // in the artifact
      bool all_known = true;
      for (std::size_t r = 0; r < c_.rows.size(); ++r) {
        const auto row = static_cast<std::int32_t>(r);
        const MeshFeature* feature = feature_of(row);
        if (!feature || !is_round_feature(*feature)) continue;
        Absence a;
        a.axis = *feature->primitive, a.low = feature->low, a.high = feature->high, a.hollow = feature->hollow;
        if (!equal(first, a)) continue;
        ++here;
        all_known = all_known && (c_.rows[r].covered > 0 || told(row));
      }
      const std::size_t there = invented ? here - std::min(here, alike.size()) : here + alike.size();
      if (!all_known || std::max(here, there) < 2 || first.axis.kind == PrimitiveKind::cone) continue;
      std::vector<std::string> which;
      for (const auto* a : alike)
        which.push_back(invented ? a->finding.feature + " at " + words.place(a->center)
                                 : "the one about " + words.place(a->center));
      const std::string noun = noun_of(first);
      Finding f = first.finding;
      for (std::size_t k = 1; k < alike.size(); ++k) {
        f.area += alike[k]->finding.area, f.points += alike[k]->finding.points;
        alike[k]->finding.text.clear();
      }
      f.text = (here == 0 ? "no" : std::to_string(here)) + " " + (here < 2 ? noun : plural_of(noun)) + " of diameter " +
               words.mm(2 * first.axis.radius) + " in the artifact, " + (there == 0 ? "none" : std::to_string(there)) +
               " in the scan: " + listed(which) + (which.size() > 1 ? " are " : " is ") +
               (invented ? "invented" : "missing");
      first.finding = f;
    }
  }
}

}  // namespace partscribe::verify
