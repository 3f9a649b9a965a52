#include "scan/register/register_measured.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "geometry/points/nearest_again.h"
#include "scan/register/register_steps.h"

namespace partscribe::scan {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Vec6 = Eigen::Matrix<double, 6, 1>;

constexpr std::size_t most_places = 50000;    // of a view; all that range images of the usual size have
constexpr double same_face = 0.9;             // cosine of 26 degrees
constexpr double border_share = 0.2;          // of what borders weigh beside filtered places; see adjust_by_measured
constexpr double kernel = 2, own_kernel = 3;  // deviations, of both and of either: mixed pixels of slanted faces lie
                                              // three to five off, all to one side
constexpr int rounds = 3, rounds_of_two = 2;  // one pose is there after two
constexpr std::size_t enough_places = 12000;  // of one of two views: the way back finds much the same pairs

/// How far a place was measured from the surface through its neighbours, in deviations.
double off_surface(const ViewSurface& surface, std::size_t i) {
  return (surface.measured[i] - surface.points[i]).dot(surface.normals[i]) / surface.sigma;
}

/// What a place is worth that a view sees under this cosine. Of many views noise averages out, and what is wrong for
/// whole slanted faces stays; of two noise is most of the error, and slanted faces are needed against it.
double worth_of(double cosine, std::size_t views) {
  const double c = std::max(cosine, 1e-3);
  return views > 2 ? c * c : c;
}

/// A measured place against that of its partner in another view.
struct Match {
  Vec6 row;
  double e = 0;               // mm
  double odds = 0;            // that neither is a mixed pixel
  std::size_t place = 0;      // of the first view's points
  double own = 0, other = 0;  // worth
};

std::vector<Match> matches_of(const std::vector<ViewSurface>& surfaces, const AdjustedViews& adjusted,
                              const std::vector<Pose>& poses, const std::pair<std::size_t, std::size_t>& pair,
                              NearestAgain& partners) {
  const std::size_t a = adjusted.views[pair.first], b = adjusted.views[pair.second];
  const ViewSurface &from = surfaces[a], &to = surfaces[b];
  const Pose there = poses[b].inverse() * poses[a];
  const std::size_t stride = from.points.size() / most_places + 1;
  std::vector<Match> result;
  result.reserve(from.points.size() / stride + 1);
  for (std::size_t i = 0; i < from.points.size(); i += stride) {
    if (!from.smooth[i]) continue;
    const Vec3 place = there * from.points[i], nx = there.rotation * from.normals[i];
    if (nx.dot(to.raster.ray(place)) > 0.1) continue;
    const std::uint32_t near = partners.nearest(i, place, 3 * to.spacing);
    if (near == NearestAgain::nobody || !to.smooth[near]) continue;
    const Vec3& ny = to.normals[near];
    if (nx.dot(ny) < same_face) continue;
    const Vec3 n = (nx + ny).normalized(), across = place - to.points[near];
    if ((across - across.dot(n) * n).norm() > to.spacing) continue;
    const Vec3 d = there * from.measured[i] - to.measured[near];
    const Vec3 middle = poses[b] * (to.measured[near] + 0.5 * d), normal = poses[b].rotation * n;
    Match match;
    match.row << ((middle - adjusted.center) / adjusted.size).cross(normal), normal;
    const double own = off_surface(from, i), other = off_surface(to, near);
    match.e = d.dot(n), match.odds = std::exp(-(own * own + other * other) / (2 * own_kernel * own_kernel)),
    match.place = i;
    match.own = worth_of(from.cosine[i], adjusted.views.size()),
    match.other = worth_of(to.cosine[near], adjusted.views.size());
    result.push_back(match);
  }
  return result;
}

/// By view and place: what all views that show the place are worth there.
std::vector<std::vector<double>> worth_of_places(const std::vector<ViewSurface>& surfaces,
                                                 const AdjustedViews& adjusted,
                                                 const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
                                                 const std::vector<std::vector<Match>>& matches) {
  std::vector<std::vector<double>> worth;
  for (const std::size_t view : adjusted.views) worth.emplace_back(surfaces[view].points.size(), 0.0);
  for (std::size_t k = 0; k < pairs.size(); ++k)
    for (const Match& match : matches[k]) {
      double& all = worth[pairs[k].first][match.place];
      all += all > 0 ? match.other : match.own + match.other;
    }
  return worth;
}

}  // namespace

void adjust_by_measured(const std::vector<ViewSurface>& surfaces, const AdjustedViews& adjusted,
                        std::vector<Pose>& poses, Context& context) {
  if (adjusted.fixed.cols() == 0) return;
  const auto unknowns = static_cast<Eigen::Index>(6 * (adjusted.views.size() - 1));
  VectorXd border_g = border_share * adjusted.border_g;
  const bool two = adjusted.views.size() == 2;
  auto pairs = adjusted.pairs;
  if (two && pairs.size() == 2 && surfaces[adjusted.views[0]].points.size() > enough_places) pairs.pop_back();
  std::vector<NearestAgain> partners;
  for (const auto& [a, b] : pairs) {
    const ViewSurface &from = surfaces[adjusted.views[a]], &to = surfaces[adjusted.views[b]];
    partners.emplace_back(*to.tree, to.points, from.points.size(), to.grid.get());
  }
  for (int round = 0; round < (two ? rounds_of_two : rounds) && !context.cancelled; ++round) {
    std::vector<std::vector<Match>> matches(pairs.size());
    parallel_for(
        matches.size(), context.threads,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t k = begin; k < end; ++k)
            matches[k] = matches_of(surfaces, adjusted, poses, pairs[k], partners[k]);
        },
        1);
    std::vector<double> residuals;
    for (const auto& of_pair : matches)
      for (const Match& match : of_pair) residuals.push_back(match.e);
    if (residuals.empty()) return;
    const double sigma = std::max(spread_of(std::move(residuals)), 1e-12), wide = kernel * sigma;
    MatrixXd h = MatrixXd::Zero(unknowns, unknowns);
    VectorXd g = VectorXd::Zero(unknowns);
    // Of m views that show a place m - 1 hold against each, though it is one measurement: all of them against their
    // weighted mean is the sum over pairs of the product of their worths, over the sum of all.
    const auto worth = worth_of_places(surfaces, adjusted, pairs, matches);
    for (std::size_t k = 0; k < matches.size(); ++k) {
      Mat6 pair_h = Mat6::Zero();
      Vec6 pair_g = Vec6::Zero();
      for (const Match& match : matches[k]) {
        const double shared = 2 * match.own * match.other / worth[pairs[k].first][match.place];
        const double w = shared * match.odds * std::exp(-match.e * match.e / (2 * wide * wide)) / (sigma * sigma);
        pair_h += w * match.row * match.row.transpose(), pair_g -= w * match.e * match.row;
      }
      const auto& [a, b] = pairs[k];
      add_pair(a, b, pair_h, h), add_pull(a, b, pair_g, g);
    }
    h += border_share * adjusted.border_h, g += border_g;
    const VectorXd step = answer_of(h, adjusted.fixed) * g;
    border_g -= border_share * adjusted.border_h * step;
    for (std::size_t k = 1; k < adjusted.views.size(); ++k) {
      Pose& pose = poses[adjusted.views[k]];
      pose = moved_about(pose, adjusted.center, step.segment<3>(first_unknown(k)) / adjusted.size,
                         step.segment<3>(first_unknown(k) + 3));
    }
  }
}

}  // namespace partscribe::scan
