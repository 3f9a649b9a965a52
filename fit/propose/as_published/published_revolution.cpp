#include "fit/propose/as_published/published_revolution.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"
#include "core/statistics.h"
#include "fit/surface/published_spline.h"
#include "geometry/least_squares.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t fewest_sections = 5;
constexpr std::size_t fewest_points = 8;  // of a section: an ellipse has five numbers
constexpr double steepest = 2;            // mm of radius per mm of height

/// Where points stand about an axis: x and y across it, z along it.
struct AxisFrame {
  Vec3 point, direction;
  std::vector<Vec3> from(const std::vector<Vec3>& points) const {
    const Mat3 turn = rotation_onto_axis(direction).transpose();
    std::vector<Vec3> result;
    result.reserve(points.size());
    for (const Vec3& p : points) result.push_back(turn * (p - point));
    return result;
  }
};

/// The radius at a height, straight between the sections' middles and beyond them.
double radius_at(const std::vector<ConicSection>& sections, double height) {
  const auto above = std::lower_bound(sections.begin() + 1, sections.end() - 1, height,
                                      [](const ConicSection& s, double h) { return s.height < h; });
  const ConicSection &a = *(above - 1), &b = *above;
  const double share = (height - a.height) / (b.height - a.height);
  return a.conic.mean_radius() + share * (b.conic.mean_radius() - a.conic.mean_radius());
}

/// Of slices of equal height. `known`: sections of a round before, along whose profile points slide to the middle of
/// their slice; empty: they are projected onto it.
std::vector<ConicSection> sections_of(const std::vector<Vec3>& points, int count,
                                      const std::vector<ConicSection>& known) {
  double low = points.front().z(), high = low;
  for (const Vec3& p : points) low = std::min(low, p.z()), high = std::max(high, p.z());
  std::vector<std::vector<Vec2>> slices(static_cast<std::size_t>(count));
  const double step = (high - low) / count;
  if (!(step > 0)) return {};
  const auto middle = [&](std::size_t k) { return low + (static_cast<double>(k) + 0.5) * step; };
  for (const Vec3& p : points) {
    const auto k = std::min(static_cast<std::size_t>((p.z() - low) / step), slices.size() - 1);
    Vec2 q = p.head<2>();
    if (known.size() >= 2) {
      const double slide = radius_at(known, middle(k)) - radius_at(known, p.z()), r = q.norm();
      if (r > std::abs(slide) && std::abs(slide) < steepest * step) q *= (r + slide) / r;
    }
    slices[k].push_back(q);
  }
  std::vector<ConicSection> result;
  for (std::size_t k = 0; k < slices.size(); ++k) {
    if (slices[k].size() < fewest_points) continue;
    const auto conic = fitted_ellipse(slices[k]);
    if (!conic) continue;
    double sum = 0;
    for (const Vec2& q : slices[k]) sum += conic->off(q) * conic->off(q);
    result.push_back({middle(k), *conic, slices[k].size(), std::sqrt(sum / static_cast<double>(slices[k].size()))});
  }
  return result;
}

/// r r' of every section, from its neighbours.
std::vector<double> radius_changes(const std::vector<ConicSection>& sections) {
  std::vector<double> result;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const ConicSection &a = sections[i > 0 ? i - 1 : 0], &b = sections[std::min(i + 1, sections.size() - 1)];
    const double ra = a.conic.mean_radius(), rb = b.conic.mean_radius();
    result.push_back(0.5 * (rb * rb - ra * ra) / (b.height - a.height));
  }
  return result;
}

/// Those that are ellipses and stand upright enough to say where the axis is.
std::vector<ConicSection> telling(const std::vector<ConicSection>& sections) {
  if (sections.size() < fewest_sections) return {};
  std::vector<double> rms;
  for (const ConicSection& s : sections) rms.push_back(s.rms);
  const double most = 4 * median(rms);
  const std::vector<double> change = radius_changes(sections);
  std::vector<ConicSection> result;
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (sections[i].rms <= most && std::abs(change[i]) <= steepest * sections[i].conic.mean_radius())
      result.push_back(sections[i]);
  return result;
}

/// centre(h) = offset + tilt (h + r r'), with weights that leave sections out which do not agree.
struct CenterLine {
  Vec2 offset = Vec2::Zero(), tilt = Vec2::Zero();
  double lever = 0;  ///< spread of h + r r', as a share of that of h
};

CenterLine line_of_centers(const std::vector<ConicSection>& sections) {
  const std::vector<double> change = radius_changes(sections);
  CenterLine line;
  double mean_h = 0, mean_g = 0;
  const auto count = static_cast<double>(sections.size());
  for (std::size_t i = 0; i < sections.size(); ++i)
    mean_h += sections[i].height / count, mean_g += (sections[i].height + change[i]) / count;
  double square_h = 0, square_g = 0;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const double h = sections[i].height - mean_h, g = sections[i].height + change[i] - mean_g;
    square_h += h * h, square_g += g * g;
  }
  line.lever = std::sqrt(square_g / square_h);
  const auto fit = [&](const std::vector<double>& weights) {
    NormalSums<2> x, y;
    for (std::size_t i = 0; i < sections.size(); ++i) {
      const Vec2 row(1, sections[i].height + change[i]);
      const double weight = weights[i] * static_cast<double>(sections[i].held);
      x.add(row, sections[i].conic.center.x(), weight), y.add(row, sections[i].conic.center.y(), weight);
    }
    const Vec2 of_x = x.solution(0), of_y = y.solution(0);
    line.offset = {of_x[0], of_y[0]}, line.tilt = {of_x[1], of_y[1]};
    return true;
  };
  const auto off = [&](std::size_t i) {
    return (sections[i].conic.center - line.offset - (sections[i].height + change[i]) * line.tilt).norm();
  };
  reweighted(sections.size(), {.rounds = 5, .times = 3, .least = 1e-9}, fit, off);
  return line;
}

}  // namespace

Result<PublishedRevolution> published_revolution(const std::vector<Vec3>& points, const Vec3& assumed_point,
                                                 const Vec3& assumed_direction,
                                                 const PublishedRevolutionOptions& options) {
  ensure(options.sections >= int(fewest_sections) && options.rounds >= 1, "sections and rounds to work with");
  ensure(assumed_direction.norm() > 0, "an assumed axis has a direction");
  constexpr double least_lever = 0.1;  // of a ball it is 0: every axis through its middle is one
  constexpr double stands = 1e-7;      // rad, and of the height in mm
  AxisFrame axis{assumed_point, assumed_direction.normalized()};
  PublishedRevolution result;
  std::vector<ConicSection> sections;
  for (bool moving = true; moving && result.rounds < options.rounds; ++result.rounds) {
    if (points.empty()) return bad_input("expected points of a turned part, found none");
    {  // Heights are counted from the middle, so that a tilt does not shift.
      std::vector<double> heights;
      for (const Vec3& p : points) heights.push_back(axis.direction.dot(p - axis.point));
      const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
      axis.point += 0.5 * (*low + *high) * axis.direction;
    }
    sections = telling(sections_of(axis.from(points), options.sections, sections));
    if (sections.size() < fewest_sections)
      return bad_input("expected at least " + std::to_string(fewest_sections) +
                       " sections across the assumed axis that are ellipses, found " + std::to_string(sections.size()));
    const CenterLine line = line_of_centers(sections);
    if (!(line.lever > least_lever))
      return bad_input("the centres of sections tell no axis: those of a ball are the same about any; they vary by " +
                       print_number(std::round(1000 * line.lever) / 1000) + " of the height, expected " +
                       print_number(least_lever));
    const Mat3 turn = rotation_onto_axis(axis.direction);
    axis.point += turn * Vec3(line.offset.x(), line.offset.y(), 0);
    axis.direction = (turn * Vec3(line.tilt.x(), line.tilt.y(), 1)).normalized();
    const double height = sections.back().height - sections.front().height;
    moving = line.tilt.norm() > stands || line.offset.norm() > stands * height;
  }
  result.point = axis.point, result.direction = axis.direction;
  result.sections = telling(sections_of(axis.from(points), options.sections, sections));
  if (result.sections.size() < fewest_sections) return bad_input("sections were lost about the axis that they told");
  std::vector<Vec3> places;
  for (const ConicSection& s : result.sections) places.emplace_back(s.conic.mean_radius(), s.height, 0);
  const PublishedCurve curve =
      refined_curve(places, parameters_of(places, Parameters::chord_length), equal_spans(4), options.tolerance);
  result.profile.t = curve.curve.t;
  for (const Vec3& p : curve.curve.points) result.profile.points.push_back(p.head<2>());
  result.profile_error = curve.worst;
  return result;
}

}  // namespace partscribe::fit
