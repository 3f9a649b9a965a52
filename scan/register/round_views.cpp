#include "scan/register/round_views.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/statistics.h"
#include "geometry/decompose.h"

namespace partscribe::scan {
namespace {

constexpr std::size_t fewest_of_a_bin = 12;  // points
constexpr std::size_t stride = 7;            // axes are fitted to every seventh point
constexpr double most_along_sight = 0.9;     // cosine between the axis and the direction of sight

/// What is fitted.
struct RoundFit {
  std::vector<std::vector<Vec3>> measured, points;  ///< of each view; as measured, and corrected
  std::vector<AxisFrame> frames;
  RadiusProfile profile;
  double width = 0, median_off = 0;
  Vec3 center, sight, aside;  ///< depth grows along `sight`, width along `aside`
  bool correct = false;
  double stretch = 0, shear = 0;  ///< added to the depth, for each mm of depth and of width

  DepthCorrection depth() const {
    return {Mat3::Identity() + sight * (stretch * sight + shear * aside).transpose(), center, stretch, shear};
  }
};

void turn_axis(AxisFrame& frame, const Vec3& change) {
  frame.line.axis = (frame.line.axis + change).normalized();
  frame.across = (frame.across - frame.across.dot(frame.line.axis) * frame.line.axis).normalized();
  frame.beside = frame.line.axis.cross(frame.across);
}

RoundFit started(const std::vector<ViewSurface>& surfaces, const AxisLine& axis) {
  RoundFit fit;
  AxisFrame common{axis, axis.axis.unitOrthogonal(), {}};
  common.beside = axis.axis.cross(common.across);
  fit.center = surfaces[0].center, fit.sight = surfaces[0].raster.axes.col(2),
  fit.aside = axis.axis.cross(fit.sight).normalized();
  double low = 1e30, high = -1e30, spacing = 0;
  for (const ViewSurface& s : surfaces) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      if (!s.smooth[i] || !round_about(axis, s, i)) continue;
      points.push_back(s.measured[i]);
      const double along = place_about(common, points.back()).along;
      low = std::min(low, along), high = std::max(high, along);
    }
    fit.measured.push_back(std::move(points)), fit.frames.push_back(common);
    spacing = std::max(spacing, s.spacing), fit.width = std::max(fit.width, 0.1 * s.radius);
  }
  fit.points = fit.measured;
  fit.profile.start = low, fit.profile.bin = 6 * spacing;
  fit.profile.radius.resize(static_cast<std::size_t>(std::max(1.0, std::ceil((high - low) / fit.profile.bin))));
  return fit;
}

void update_profile(RoundFit& fit, std::size_t every) {
  RadiusProfile& profile = fit.profile;
  std::vector<std::vector<double>> bins(profile.radius.size());
  for (std::size_t v = 0; v < fit.points.size(); ++v)
    for (std::size_t i = 0; i < fit.points[v].size(); i += every) {
      const CylinderPlace c = place_about(fit.frames[v], fit.points[v][i]);
      const double k = std::floor((c.along - profile.start) / profile.bin);
      if (k >= 0 && k < static_cast<double>(bins.size())) bins[static_cast<std::size_t>(k)].push_back(c.radius);
    }
  for (std::size_t k = 0; k < bins.size(); ++k)
    profile.radius[k] = bins[k].size() < fewest_of_a_bin ? -1 : median_in_place(bins[k]);
}

/// The median distance of the points from the profile.
double median_off(const RoundFit& fit) {
  std::vector<double> off;
  for (std::size_t v = 0; v < fit.points.size(); ++v)
    for (std::size_t i = 0; i < fit.points[v].size(); i += 4 * stride) {
      const CylinderPlace c = place_about(fit.frames[v], fit.points[v][i]);
      if (const auto here = fit.profile.at(c.along)) off.push_back(std::abs(c.radius - here->first));
    }
  return median_in_place(off);
}

/// One step of Gauss-Newton for all axes and the depth at once: r - R(s) changes by -u.(shift + (s + R' r) tilt) and,
/// by what is added to the depth, with u.sight. The profile moves with them: of a part seen from its front only,
/// another radius and slope is made up for by the axis, and steps in turns would hardly get on.
void update_axes(RoundFit& fit) {
  const RadiusProfile& profile = fit.profile;
  const auto of_axes = static_cast<Eigen::Index>(4 * fit.points.size()), n = of_axes + (fit.correct ? 2 : 0);
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
  struct Bin {
    Eigen::VectorXd rows;
    double weight = 0, residual = 0;
  };
  std::vector<Bin> bins(profile.radius.size(), Bin{Eigen::VectorXd::Zero(n)});
  for (std::size_t v = 0; v < fit.points.size(); ++v) {
    const AxisFrame& frame = fit.frames[v];
    const auto at = static_cast<Eigen::Index>(4 * v);
    for (std::size_t i = 0; i < fit.points[v].size(); i += stride) {
      const CylinderPlace c = place_about(frame, fit.points[v][i]);
      const auto here = profile.at(c.along);
      if (!here) continue;
      const double e = c.radius - here->first, w = std::exp(-e * e / (2 * fit.width * fit.width)),
                   arm = c.along + here->second * c.radius;
      const double x = std::cos(c.angle), y = std::sin(c.angle);
      const Eigen::Vector4d row(-x, -y, -arm * x, -arm * y);
      Bin& bin = bins[static_cast<std::size_t>((c.along - profile.start) / profile.bin)];
      h.block<4, 4>(at, at) += w * row * row.transpose(), g.segment<4>(at) += w * e * row;
      bin.rows.segment<4>(at) += w * row, bin.weight += w, bin.residual += w * e;
      if (!fit.correct) continue;
      const Vec3 q = fit.measured[v][i] - fit.center;
      const Eigen::Vector2d deeper =
          (x * frame.across + y * frame.beside).dot(fit.sight) * Eigen::Vector2d(fit.sight.dot(q), fit.aside.dot(q));
      h.block<4, 2>(at, of_axes) += w * row * deeper.transpose(),
          h.block<2, 4>(of_axes, at) += w * deeper * row.transpose();
      h.bottomRightCorner<2, 2>() += w * deeper * deeper.transpose(), g.tail<2>() += w * e * deeper;
      bin.rows.tail<2>() += w * deeper;
    }
  }
  for (const Bin& bin : bins)
    if (bin.weight > 0) h -= bin.rows * bin.rows.transpose() / bin.weight, g -= bin.residual / bin.weight * bin.rows;
  const Eigen::VectorXd step = -solve_ldlt(h, g);
  if (!step.allFinite()) return;
  for (std::size_t v = 0; v < fit.frames.size(); ++v) {
    AxisFrame& frame = fit.frames[v];
    const Eigen::Vector4d d = step.segment<4>(static_cast<Eigen::Index>(4 * v));
    frame.line.point += d[0] * frame.across + d[1] * frame.beside;
    turn_axis(frame, d[2] * frame.across + d[3] * frame.beside);
  }
  if (!fit.correct) return;
  fit.stretch += step[of_axes], fit.shear += step[of_axes + 1];
  const DepthCorrection depth = fit.depth();
  for (std::size_t v = 0; v < fit.points.size(); ++v)
    for (std::size_t i = 0; i < fit.points[v].size(); ++i) fit.points[v][i] = depth * fit.measured[v][i];
}

void refine(RoundFit& fit, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    update_profile(fit, stride);
    update_axes(fit);
    fit.median_off = median_off(fit);
    fit.width = std::max(0.75 * fit.width, 3 * 1.4826 * fit.median_off);
  }
  update_profile(fit, 1);
}

/// Standard errors of stretch and shear by leaving out one view after the other: residuals are correlated, so that
/// their number says little.
void jackknife(const RoundFit& fit, DepthCorrection& depth) {
  const std::size_t n = fit.points.size();
  if (n < 3) return;
  double stretch = 0, shear = 0;
  for (std::size_t v = 0; v < n; ++v) {
    RoundFit without = fit;
    const auto at = static_cast<std::ptrdiff_t>(v);
    without.measured.erase(without.measured.begin() + at), without.points.erase(without.points.begin() + at),
        without.frames.erase(without.frames.begin() + at);
    refine(without, 10);
    stretch += std::pow(without.stretch - fit.stretch, 2), shear += std::pow(without.shear - fit.shear, 2);
  }
  const double share = double(n - 1) / double(n);
  depth.stretch_sigma = std::sqrt(share * stretch), depth.shear_sigma = std::sqrt(share * shear);
}

RoundViews views_of(const RoundFit& fit) { return {fit.frames, fit.profile, fit.width, fit.median_off, fit.depth()}; }

bool clearly_rounder(const RoundViews& corrected, const RoundViews& raw) {
  constexpr double of_distance = 0.85;  // of the points from the profile
  constexpr double least = 0.01, sigmas = 4;
  const DepthCorrection& d = corrected.depth;
  const bool stretched = std::abs(d.stretch) > std::max(least, sigmas * d.stretch_sigma),
             sheared = std::abs(d.shear) > std::max(least, sigmas * d.shear_sigma);
  return (stretched || sheared) && corrected.median_off < of_distance * raw.median_off;
}

}  // namespace

double off_axis(const AxisLine& line, const Vec3& p, const Vec3& normal, double least) {
  const Vec3 q = p - line.point, across = q - q.dot(line.axis) * line.axis;
  return std::abs(normal.dot(line.axis.cross(across))) / std::max(across.norm(), least);
}

bool round_about(const AxisLine& line, const ViewSurface& surface, std::size_t place) {
  constexpr double most_off_axis = 0.35;
  return off_axis(line, surface.points[place], surface.normals[place], 0.02 * surface.radius) <= most_off_axis;
}

std::optional<std::pair<double, double>> RadiusProfile::at(double along) const {
  const double x = (along - start) / bin - 0.5;
  const auto k = static_cast<std::ptrdiff_t>(std::floor(x));
  if (k < 0 || k + 1 >= static_cast<std::ptrdiff_t>(radius.size())) return {};
  const double a = radius[static_cast<std::size_t>(k)], b = radius[static_cast<std::size_t>(k) + 1];
  if (a < 0 || b < 0 || std::abs(b - a) > bin) return {};
  return std::pair(a + (x - static_cast<double>(k)) * (b - a), (b - a) / bin);
}

CylinderPlace place_about(const AxisFrame& frame, const Vec3& p) {
  const Vec3 q = p - frame.line.point;
  const double x = q.dot(frame.across), y = q.dot(frame.beside);
  return {q.dot(frame.line.axis), std::hypot(x, y), std::atan2(y, x)};
}

RoundFits round_views(const std::vector<ViewSurface>& surfaces, const AxisLine& axis) {
  constexpr int rounds = 80;
  RoundFit fit = started(surfaces, axis);
  refine(fit, rounds);
  RoundFits result{views_of(fit), {}};
  if (std::abs(axis.axis.dot(fit.sight)) >= most_along_sight) return result;
  fit.correct = true;
  refine(fit, rounds);
  RoundViews corrected = views_of(fit);
  jackknife(fit, corrected.depth);
  if (clearly_rounder(corrected, result.raw)) result.rounder = std::move(corrected);
  return result;
}

}  // namespace partscribe::scan
