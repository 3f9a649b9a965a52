#include "fit/search/rivals.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/propose/convex_body.h"
#include "fit/refine/refine.h"
#include "geometry/decompose.h"
#include "model/sketch.h"

namespace partscribe::fit {
namespace {

constexpr double undecided = 2, certain = 3;  // sigmas

struct Measured {
  double value = 0, sigma = 0;
  std::size_t points = 0;  // that speak about it
};

/// A length of the shape with its uncertainty; plain numbers have none.
Measured measured(const Candidate& c, const Expr& e) {
  if (!e.is_parameter()) return {e.is_number() ? e.number : 0, 0};
  for (const auto& p : c.parameters)
    if (p.name == e.parameter) return {p.fitted, p.sigma, p.points};
  return {};
}

std::string with_sigma(const Measured& m, const std::string& unit) {
  const double step = power_of_ten_below(std::max(m.sigma / 5, 1e-6));
  return print_number(snapped(m.value, step)) + " +- " + print_number(std::max(snapped(m.sigma, step), step)) + " " +
         unit;
}

/// How the one sheet bends on which nearly all points lie.
struct Bend {
  Measured curvature;  // 1/mm, across its strongest bend
  double extent = 0;   // mm, there
};

/// None where the points lie on several sheets, or are few. A quadratic form over the common plane, reweighted.
std::optional<Bend> bend_of(const FitInput& input) {
  constexpr double one_sheet = 0.85, steepest = 0.8;  // share of the points, cosine
  const PointCloud& cloud = input.cloud;
  if (cloud.size() < 50 || cloud.normals.size() != cloud.size()) return std::nullopt;
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& n : cloud.normals) scatter += n * n.transpose();
  const Vec3 up = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(2);
  const Vec3 x = up.unitOrthogonal(), y = up.cross(x), middle = input.bounds.center();
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3 d = cloud.points[i] - middle;
    if (std::abs(cloud.normals[i].dot(up)) > steepest) points.emplace_back(d.dot(x), d.dot(y), d.dot(up));
  }
  if (!(double(points.size()) > one_sheet * double(cloud.size()))) return std::nullopt;
  using Six = Eigen::Matrix<double, 6, 1>;
  const auto row = [](const Vec3& p) {
    return Six(1, p.x(), p.y(), p.x() * p.x() / 2, p.x() * p.y(), p.y() * p.y() / 2);
  };
  Six form = Six::Zero();
  Eigen::Matrix<double, 6, 6> inverse;
  std::vector<double> miss(points.size(), 0);
  double scale = 1e300;
  for (int round = 0; round < 15; ++round) {
    Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
    Six g = Six::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double u = miss[i] / scale, w = std::exp(-u * u / 12.5);
      const Six r = row(points[i]);
      h += w * r * r.transpose(), g += w * r * points[i].z();
    }
    inverse = h.inverse();
    form = inverse * g;
    std::vector<double> sizes;
    for (std::size_t i = 0; i < points.size(); ++i)
      sizes.push_back(std::abs(miss[i] = points[i].z() - row(points[i]).dot(form)));
    scale = std::max(1.4826 * quantile(sizes, 0.5), 1e-9 * input.bounds.diagonal());
  }
  Eigen::Matrix2d bends;
  bends << form[3], form[4], form[4], form[5];
  const auto eigen = eigensystem(bends);
  const int strongest = std::abs(eigen.values[0]) > std::abs(eigen.values[1]) ? 0 : 1;
  const Vec2 across = eigen.vectors.col(strongest);
  Six share = Six::Zero();
  share[3] = across.x() * across.x(), share[4] = 2 * across.x() * across.y(), share[5] = across.y() * across.y();
  std::vector<double> along;
  for (const Vec3& p : points) along.push_back(p.head<2>().dot(across));
  // The sheet may lean in this frame, which flattens its bend.
  const double lean = std::pow(1 + std::pow(form[1] * across.x() + form[2] * across.y(), 2), 1.5);
  return Bend{
      {eigen.values[strongest] / lean, scale * std::sqrt(std::max(0.0, double(share.dot(inverse * share)))) / lean},
      quantile(along, 0.98) - quantile(along, 0.02)};
}

/// Of a cone, in degrees. The errors of the sizes are correlated, at worst so that their sigmas add up.
Measured half_angle(const Candidate& c, const Cone& shape) {
  const Measured a = measured(c, shape.bottom_radius), b = measured(c, shape.top_radius), h = measured(c, shape.height);
  if (!(h.value > 0)) return {};
  const double slope = std::abs(a.value - b.value) / h.value;
  return {std::atan(slope) * 180 / pi, (a.sigma + b.sigma + slope * h.sigma) / h.value * 180 / pi};
}

/// The difference between the longest and the shortest half axis.
Measured half_axes_apart(const Candidate& c, const Ellipsoid& shape) {
  const std::vector<Measured> radii = {measured(c, shape.radius_x), measured(c, shape.radius_y),
                                       measured(c, shape.radius_z)};
  const auto less = [](const Measured& a, const Measured& b) { return a.value < b.value; };
  const Measured low = *std::min_element(radii.begin(), radii.end(), less),
                 high = *std::max_element(radii.begin(), radii.end(), less);
  return {high.value - low.value, low.sigma + high.sigma};
}

/// A straight side of an outline along one of its axes.
struct Side {
  double at = 0;            // mm, where it stands across that axis
  double from = 0, to = 0;  // mm along the axis, `from` below `to`
  int runs = 1;             // with the axis or against it
};

/// Of the outermost loop.
std::vector<Side> sides_along(const Outline2& outline, bool along_x) {
  const int axis = along_x ? 0 : 1, across = 1 - axis;
  std::vector<Side> sides;
  for (const OutlineCurve& curve : outline.curves) {
    const auto* line = std::get_if<Line2>(&curve.curve);
    if (!line || curve.loop != 0 || std::abs(line->a[across] - line->b[across]) > sketch_join) continue;
    const double from = line->a[axis], to = line->b[axis];
    sides.push_back({line->a[across], std::min(from, to), std::max(from, to), from < to ? 1 : -1});
  }
  return sides;
}

bool overlap(const Side& a, const Side& b) { return a.from < b.to && b.from < a.to; }

/// What the deviations from the faces of a convex body cost.
double cost_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  const double sigma = std::max(input.sampling.sigma, 0.2 * input.tolerance);
  double sum = 0;
  for (const Vec3& p : input.cloud.points) sum += nats_of(convex_distance(faces, p) / sigma);
  return weight_of_samples(input.cloud.size()) * sum;
}

bool may_be_zero(const Measured& m) { return m.sigma > 0 && m.value < undecided * m.sigma; }

}  // namespace

std::string told_apart_by(const Candidate& winner, Candidate rival, const FitInput& input, Context& context) {
  const bool cone = std::holds_alternative<Cylinder>(winner.shape) && std::holds_alternative<Cone>(rival.shape);
  const bool ellipsoid = std::holds_alternative<Sphere>(winner.shape) && std::holds_alternative<Ellipsoid>(rival.shape);
  if (!cone && !ellipsoid) return {};
  RefineOptions options;
  refine(rival, input, options, context);
  const Measured apart =
      cone ? half_angle(rival, std::get<Cone>(rival.shape)) : half_axes_apart(rival, std::get<Ellipsoid>(rival.shape));
  if (!may_be_zero(apart)) return {};
  return cone ? "the data cannot tell it from a cone: half angle " + with_sigma(apart, "degrees")
              : "the data cannot tell it from an ellipsoid: its half axes differ by " + with_sigma(apart, "mm");
}

std::string simpler_kind(const Candidate& refined) {
  if (const auto* cone = std::get_if<Cone>(&refined.shape))
    return may_be_zero(half_angle(refined, *cone)) ? "cylinder" : "";
  if (const auto* ellipsoid = std::get_if<Ellipsoid>(&refined.shape))
    return may_be_zero(half_axes_apart(refined, *ellipsoid)) ? "sphere" : "";
  return {};
}

std::vector<Expr> radii_of(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return {s->radius};
  if (const auto* s = std::get_if<Ellipsoid>(&shape)) return {s->radius_x, s->radius_y, s->radius_z};
  if (const auto* s = std::get_if<Cylinder>(&shape)) return {s->radius};
  if (const auto* s = std::get_if<Cone>(&shape)) return {s->bottom_radius, s->top_radius};
  return {};
}

std::string unknown_radius(const Candidate& refined) {
  if (std::holds_alternative<Cone>(refined.shape)) return {};
  for (const Expr& e : radii_of(refined.shape))
    if (const Measured r = measured(refined, e); r.sigma > std::abs(r.value))
      return "its radius " + with_sigma(r, "mm") + " is not known";
  return {};
}

std::string unknown_wall(const Candidate& refined) {
  const auto* plate = std::get_if<Extrude>(&refined.shape);
  if (!plate || plate->sketch.loops.empty()) return {};
  Values values;
  for (const Parameter& p : refined.parameters) values[p.name] = p.fitted;
  const Outline2 outline = outline_of(std::get<ExtrudeOf<double>>(evaluate(refined.shape, values)).sketch);
  const auto stands_at = [](const Side& side, double at) { return std::abs(side.at - at) <= sketch_join; };
  for (const bool along_x : {true, false}) {
    const std::vector<Side> sides = sides_along(outline, along_x);
    for (const Parameter& p : refined.parameters) {
      if (p.quantity != Quantity::length || p.points < hardly_any_points || !(p.sigma > std::abs(p.fitted))) continue;
      for (const Side& side : sides)
        for (const Side& base : sides)  // from where the others are measured
          if (stands_at(side, p.fitted) && stands_at(base, 0) && base.runs * side.runs < 0 && overlap(base, side))
            return "a wall of " + with_sigma({p.fitted, p.sigma}, "mm") + " may be none";
    }
  }
  return {};
}

std::vector<Rival> worth_naming(std::vector<Rival> all) {
  constexpr std::size_t most = 12;
  enum Worth { another_kind, open, refused };
  std::vector<Worth> worth;
  std::set<std::string> kinds;
  for (const Rival& r : all) {
    const bool may_be =
        r.reason.find("cannot tell") != std::string::npos || r.reason.find("fits as well") != std::string::npos;
    worth.push_back(!may_be ? refused : kinds.insert(r.procedure).second ? another_kind : open);
  }
  std::vector<std::size_t> named;
  for (const Worth w : {another_kind, open, refused})
    for (std::size_t i = 0; i < all.size() && named.size() < most; ++i)
      if (worth[i] == w) named.push_back(i);
  std::ranges::sort(named);
  std::vector<Rival> result;
  for (const std::size_t i : named) result.push_back(std::move(all[i]));
  return result;
}

std::string bent_sheet(const Candidate& winner, const FitInput& input) {
  const bool flat = std::holds_alternative<Box>(winner.shape) || std::holds_alternative<Wedge>(winner.shape) ||
                    std::holds_alternative<HalfSpaces>(winner.shape) || std::holds_alternative<Extrude>(winner.shape);
  const auto sheet = flat ? bend_of(input) : std::nullopt;
  if (!sheet || !(std::abs(sheet->curvature.value) > certain * sheet->curvature.sigma)) return {};
  const double k = std::abs(sheet->curvature.value), radius = 1 / k;
  const Measured r{radius, sheet->curvature.sigma * radius * radius};
  const double degrees = std::round(sheet->extent * k * 180 / pi);
  return "the data cannot tell it from " + print_number(degrees) + " degrees of a cylinder of radius " +
         with_sigma(r, "mm");
}

std::string open_polyhedron(const Candidate& winner, double cost, const FitInput& input, Context& context) {
  const bool last_resort =
      std::holds_alternative<Superellipsoid>(winner.shape) || std::holds_alternative<Supertoroid>(winner.shape);
  const bool flat = std::holds_alternative<Box>(winner.shape) || std::holds_alternative<Wedge>(winner.shape) ||
                    std::holds_alternative<Extrude>(winner.shape);
  const bool round = std::holds_alternative<Cylinder>(winner.shape) || std::holds_alternative<Cone>(winner.shape);
  if (!last_resort && !((flat || round) && among_outliers(input))) return {};
  const auto faces = scanned_faces(input, context);
  if (faces.size() < (last_resort ? 2 : 1)) return {};
  if (!last_resort) {
    const double per_face = 4 + 1.5 * std::log(double(std::min(input.cloud.size(), deciding_samples)));
    const double margin = round || std::holds_alternative<Wedge>(winner.shape) ? told_apart : 0;
    const bool cheaper = cost_of(faces, input) + per_face * double(faces.size()) < cost + margin;
    if (round && !cheaper) return {};
    const bool corner =
        faces.size() == 3 && std::abs(faces[0].normal.dot(faces[1].normal.cross(faces[2].normal))) > 0.3;
    // Three faces around a corner end where the body ends; of three that are all across one plane both ends are open.
    if (faces.size() > 3 || (corner && !cheaper)) return {};
  } else if (!closed_body(faces, input, context).empty()) {
    return {};
  }
  const std::string number =
      faces.size() == 1 ? "one plane face holds" : print_number(double(faces.size())) + " plane faces hold";
  return "the data cannot tell: " + number +
         " nearly all points, and what closes the body was not scanned; a wedge, an extrusion or a fillet may have "
         "them too";
}

}  // namespace partscribe::fit
