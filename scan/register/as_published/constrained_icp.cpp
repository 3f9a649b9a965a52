#include "scan/register/as_published/constrained_icp.h"

#include <algorithm>
#include <limits>

#include "scan/register/register_words.h"

namespace partscribe::scan {
namespace {

/// Six numbers are to be fixed.
constexpr std::size_t fewest_points = 6;

/// P -> X at a state: every point that takes part with the closest point of the closest primitive.
std::vector<PointMatch> closest_matches(const std::vector<ReferencePoint>& points,
                                        const std::vector<std::uint8_t>& visible, const PublishedModel& model,
                                        const StateVector& state) {
  const Pose pose = pose_of(state);
  std::vector<PointMatch> matches;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!visible[i]) continue;
    const Vec3 p = pose * points[i].place;
    const ClosestPoint x = model.closest(p);
    matches.push_back({p, x.place, pose.rotation * points[i].normal, x.normal});
  }
  return matches;
}

std::vector<double> residuals_of(const std::vector<PointMatch>& matches) {
  std::vector<double> residuals;
  for (const PointMatch& m : matches) residuals.push_back((m.x - m.p).norm());
  return residuals;
}

/// e(q) of the matches that count.
double error_of(const std::vector<PointMatch>& matches, const ConsistentState& found) {
  std::vector<Vec3> p, x;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (found.valid[i]) p.push_back(matches[i].p), x.push_back(matches[i].x);
  return mean_square_error(p, x, found.state);
}

/// "12 of 30 points lie on ..." or nothing.
std::string failure_of(const IcpResult& result, double pixel) {
  if (double(result.overlapping) >= least_overlap * double(result.asked)) return "";
  return "registration as published failed: at its end " + std::to_string(result.overlapping) + " of " +
         std::to_string(result.asked) + " matched points lie within " + in_steps(pixel, 0.001) +
         " mm of the views before it, expected " + in_percent(least_overlap) +
         ": most do not overlap, and the first estimate is too far off to tell which do";
}

}  // namespace

IcpResult constrained_icp(const std::vector<ReferencePoint>& points, const std::vector<std::uint8_t>& visible,
                          const PublishedModel& model, const StateVector& first_estimate, double pixel,
                          const PaperOptions& options) {
  // Points of a face that few others help to hold approach the model slowly, and would be taken for mismatches once
  // those have arrived: from one iteration to the next the limit falls by no more than this.
  constexpr double slowest = 0.98;
  constexpr double least_limit = 0.02;  // pixels: of surfaces without noise the distribution has no width
  constexpr double fallen = 1e-6;       // of e(q), below which it no longer falls
  constexpr int patience = 5;           // iterations without that: a point that joins or leaves makes e(q) jump
  IcpResult result;
  result.state = first_estimate;
  result.asked = static_cast<std::size_t>(std::count(visible.begin(), visible.end(), 1));
  result.valid.assign(points.size(), 0);
  if (result.asked < fewest_points || model.primitives() == 0) {
    result.failure = "expected at least " + std::to_string(fewest_points) +
                     " points that views before it can see by the first estimate, found " +
                     std::to_string(result.asked);
    return result;
  }
  double limit = std::numeric_limits<double>::infinity();
  int idle = 0;
  for (int k = 0; k < options.iterations && idle < patience; ++k) {
    std::vector<PointMatch> matches = closest_matches(points, visible, model, result.state);
    // Under the state of the previous iteration, which has been applied.
    const std::vector<double> residuals = residuals_of(matches);
    const double wanted = std::max(mismatch_limit(residuals, options.mismatch_deviations), least_limit * pixel);
    const bool settled = wanted >= slowest * limit;
    limit = settled || k == 0 ? wanted : slowest * limit;
    std::vector<PointMatch> kept;
    std::vector<std::size_t> index;
    for (std::size_t i = 0, m = 0; i < points.size(); ++i) {
      if (!visible[i]) continue;
      if (residuals[m] <= limit) kept.push_back(matches[m]), index.push_back(i);
      ++m;
    }
    const ConsistentState found = consistent_state(kept, options.normal_angle);
    if (found.count < fewest_points) {
      result.failure = "registration as published failed: of " + std::to_string(result.asked) +
                       " matched points only " + std::to_string(found.count) +
                       " have normals like those of the views before it, expected " + std::to_string(fewest_points);
      return result;
    }
    std::fill(result.valid.begin(), result.valid.end(), 0);
    for (std::size_t m = 0; m < kept.size(); ++m) result.valid[index[m]] = found.valid[m];
    const double error = error_of(kept, found);
    const double before = result.errors.empty() ? std::numeric_limits<double>::infinity() : result.errors.back();
    result.errors.push_back(error);
    result.state = cumulated(found.state, result.state);
    if (error < options.error_threshold * pixel * pixel) break;
    idle = settled && error >= before * (1 - fallen) ? idle + 1 : 0;
  }
  for (const PointMatch& m : closest_matches(points, visible, model, result.state))
    result.overlapping += (m.x - m.p).norm() <= pixel && normals_consistent(m, {}, options.normal_angle);
  result.failure = failure_of(result, pixel);
  return result;
}

}  // namespace partscribe::scan
