#include "fit/refine/unknowns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/parallel.h"
#include "fit/refine/refine.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t asked_per_face = 64;

/// Up to some dozens of points of every face, evenly through the list.
std::vector<std::size_t> samples_of_faces(const std::vector<int>& face) {
  std::map<int, std::size_t> counts, seen;
  for (const int f : face) ++counts[f];
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < face.size(); ++i) {
    const std::size_t stride = (counts[face[i]] + asked_per_face - 1) / asked_per_face;
    if (seen[face[i]]++ % stride == 0) result.push_back(i);
  }
  return result;
}

/// Where a ray meets the surface.
struct RayFoot {
  double way = 0;  ///< mm along the ray from the point; positive: the point lies before the surface
  double cosine = 1;
  int face = -1;
};

/// Where along the ray the secant method from the point meets the surface from its front.
std::optional<double> met_from(const ModelDistance& distance, const Vec3& point, const Vec3& ray, double start,
                               double farthest, double exact) {
  constexpr int steps = 12;
  double way = start, before = 0, d_before = start, d = start;  // as if the ray met the surface squarely
  for (int i = 0; i < steps; ++i) {
    d = distance(point + way * ray).distance;
    if (std::abs(d) <= exact) break;
    const double slope = (d - d_before) / (way - before);
    if (!(slope < 0)) return std::nullopt;
    before = way, d_before = d;
    way -= d / slope;
    if (!(std::abs(way) < farthest) || way == before) return std::nullopt;
  }
  if (std::abs(d) > 1e3 * exact) return std::nullopt;
  return way;
}

/// Where the ray entered the body through whose back or side noise has pushed the point: back along the ray into the
/// body, out of its front, and between.
std::optional<double> entered_before(const ModelDistance& distance, const Vec3& point, const Vec3& ray, double start,
                                     double farthest, double exact) {
  const double least_step = farthest / 64;
  double way = 0, d = start, inside = 0;
  const auto step_back = [&] { way -= std::max(std::abs(d), least_step), d = distance(point + way * ray).distance; };
  while (d > 0) {
    const double before = d;
    step_back();
    if (!(d < before) || way < -farthest) return std::nullopt;  // nothing there to go through
  }
  while (d <= 0) {
    inside = way, step_back();
    if (way < -farthest) return std::nullopt;
  }
  for (int i = 0; i < 60 && std::abs(d) > exact; ++i) {
    const double middle = 0.5 * (way + inside), d_middle = distance(point + middle * ray).distance;
    if (d_middle > 0)
      way = middle, d = d_middle;
    else
      inside = middle;
  }
  return way;
}

/// Nothing if the ray grazes or passes by.
std::optional<RayFoot> foot_along(const ModelDistance& distance, const Vec3& point, const Vec3& ray, double start,
                                  double reach, double size) {
  constexpr double grazing = 0.1;  // cosine
  const double exact = 1e-10 * size, h = 1e-6 * size;
  RayFoot foot;
  if (std::abs(start) > exact) {
    // The ray determines the face. Assigned to the nearest face, points that noise pushed past the middle of a thin
    // wall or tip would count for its back, and the truncated noise of the front would bias the front outward.
    auto way = met_from(distance, point, ray, start, reach / grazing, exact);
    if (!way) way = entered_before(distance, point, ray, start, 2 * reach, exact);
    if (!way) return std::nullopt;
    foot.way = *way;
  }
  const Vec3 at = point + foot.way * ray;
  foot.cosine = (distance(at - h * ray).distance - distance(at + h * ray).distance) / (2 * h);
  foot.face = distance(at).face;
  if (!(foot.cosine > grazing) || !(std::abs(foot.way) * foot.cosine < reach)) return std::nullopt;
  return foot;
}

}  // namespace

Eigen::Matrix<double, 6, 1> motion_row(const Vec3& point, const Vec3& gradient, const Vec3& center, double size) {
  Eigen::Matrix<double, 6, 1> row;
  row << -gradient, -(point - center).cross(gradient) / size;
  return row;
}

Unknowns::Unknowns(const Candidate& candidate, const std::vector<std::string>& fixed, const Vec3& center, double size,
                   bool moves)
    : model_(bare_model(candidate)), center_(center), size_(size), moves_(moves) {
  const std::set<std::string> kept(fixed.begin(), fixed.end());
  for (std::size_t i = 0; i < candidate.parameters.size(); ++i)
    if (const Parameter& p = candidate.parameters[i];
        p.quantity != Quantity::count && !p.formula && !kept.count(p.name))
      free_.push_back(i);
  find_limits(candidate);
}

/// Exponents and tapers stop at the ends of their domains: a box lies there, and the other parameters go on.
void Unknowns::find_limits(const Candidate& candidate) {
  visit_expressions(candidate, [&](const Expr& e, Domain domain) {
    if (!e.is_parameter()) return;
    if (domain == Domain::exponent) limits_[e.parameter] = {0.1, 2.0};
    if (domain == Domain::taper) limits_[e.parameter] = {-0.95, 0.95};
  });
}

Distances Unknowns::distances(const Candidate& c, const std::vector<Vec3>& points, int threads) const {
  const ModelDistance distance(model_, values_of(c));
  const Pose part_from_scan = c.scan_from_part.inverse();
  Distances d;
  d.value.resize(points.size()), d.face.resize(points.size());
  parallel_for(points.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ModelHit hit = distance(part_from_scan * points[i]);
      d.value[i] = hit.distance, d.face[i] = hit.face;
    }
  });
  return d;
}

RayFeet Unknowns::along_rays(const Candidate& c, const std::vector<Vec3>& points, const std::vector<Vec3>& rays,
                             Distances orthogonal, double reach, int threads) const {
  const ModelDistance distance(model_, values_of(c));
  const Pose part_from_scan = c.scan_from_part.inverse();
  RayFeet feet;
  const std::size_t n = points.size();
  feet.at = std::move(orthogonal), feet.foot = points, feet.cosine.assign(n, 1);
  parallel_for(n, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!(std::abs(feet.at.value[i]) < reach)) continue;
      const Vec3 p = part_from_scan * points[i], ray = part_from_scan.rotation * rays[i];
      const auto foot = foot_along(distance, p, ray, feet.at.value[i], reach, size_);
      if (!foot) continue;
      feet.at.value[i] = foot->way * foot->cosine, feet.at.face[i] = foot->face;
      feet.foot[i] = points[i] + foot->way * rays[i], feet.cosine[i] = foot->cosine;
    }
  });
  return feet;
}

Jacobian Unknowns::jacobian(const Candidate& c, const std::vector<Vec3>& points, const Distances& at,
                            int threads) const {
  Jacobian j;
  j.rows = Matrix::Zero(static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(count()));
  j.gradients.resize(points.size());
  const Values base = values_of(c);
  const Pose part_from_scan = c.scan_from_part.inverse();
  const double h = 1e-6 * size_;
  const auto asked = samples_of_faces(at.face);
  const ModelDistance distance(model_, base);
  for (std::size_t k = 0; k < free_.size(); ++k) {
    const auto& p = c.parameters[free_[k]];
    double step = p.quantity == Quantity::length ? h : 1e-6;
    if (const auto limit = limits_.find(p.name);
        limit != limits_.end() && base.at(p.name) + step > limit->second.second)
      step = -step;
    Values shifted = base;
    shifted[p.name] += step;
    const ModelDistance above(model_, shifted, &distance);
    const auto column = static_cast<Eigen::Index>(k);
    std::set<int> answering;
    for (const std::size_t i : asked)
      if (!answering.count(at.face[i]) && above(part_from_scan * points[i]).distance != at.value[i])
        answering.insert(at.face[i]);
    std::vector<char> asks(answering.empty() ? 0 : static_cast<std::size_t>(*answering.rbegin()) + 1, 0);
    for (const int f : answering) asks[static_cast<std::size_t>(f)] = 1;
    parallel_for(points.size(), threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto face = static_cast<std::size_t>(at.face[i]);
        if (face >= asks.size() || !asks[face]) continue;
        const double d = above(part_from_scan * points[i]).distance;
        j.rows(static_cast<Eigen::Index>(i), column) = (d - at.value[i]) / step;
      }
    });
  }
  const auto first = static_cast<Eigen::Index>(free_.size());
  // Half-spaces move with their offsets: shifting the frame as well would say the same twice.
  const bool floats = !std::holds_alternative<HalfSpaces>(c.shape);
  parallel_for(points.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 q = part_from_scan * points[i];
      Vec3 gradient;
      for (int a = 0; a < 3; ++a) gradient[a] = (distance(q + Vec3::Unit(a) * h).distance - at.value[i]) / h;
      j.gradients[i] = c.scan_from_part.rotation * gradient;
      const auto row = static_cast<Eigen::Index>(i);
      if (!moves_) continue;
      j.rows.block<1, 6>(row, first) = motion_row(points[i], j.gradients[i], center_, size_).transpose();
      if (!floats) j.rows.block<1, 3>(row, first).setZero();
    }
  });
  return j;
}

Candidate Unknowns::stepped(const Candidate& c, const Vector& step) const {
  Candidate next = c;
  for (std::size_t k = 0; k < free_.size(); ++k) {
    auto& p = next.parameters[free_[k]];
    p.value += step[static_cast<Eigen::Index>(k)];
    if (const auto limit = limits_.find(p.name); limit != limits_.end())
      p.value = std::clamp(p.value, limit->second.first, limit->second.second);
  }
  const auto first = static_cast<Eigen::Index>(free_.size());
  const Vec3 shift = step.segment<3>(first), turn = step.segment<3>(first + 3) / size_;
  const Mat3 r = rotation_of(turn);
  next.scan_from_part.rotation = r * c.scan_from_part.rotation;
  next.scan_from_part.translation = r * (c.scan_from_part.translation - center_) + center_ + shift;
  return next;
}

bool Unknowns::sensible(const Candidate& c) const {
  const Values v = values_of(c);
  bool all = true;
  visit_expressions(c, [&](const Expr& e, Domain domain) {
    if (domain == Domain::length) all = all && evaluate(e, v) > 0;
    if (domain == Domain::length_or_zero) all = all && evaluate(e, v) >= 0;
  });
  return all;
}

}  // namespace partscribe::fit
