#include "fit/uncertainty/uncertainty.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "fit/evidence/one_sided.h"
#include "fit/input/smoothing.h"
#include "fit/refine/chords.h"
#include "fit/refine/refine.h"
#include "fit/uncertainty/correlation.h"
#include "fit/uncertainty/slant.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

/// Of the noise of one point: what is left of it in an instrument's own scale and straightness.
constexpr double floor_share = 0.05;

/// How far a deviation of the data moves the unknowns. Points to which the kernel gives little weight count for little.
Vector effect_of(const Deviation& deviation, const AllPoints& all, const std::vector<double>& weight,
                 const Welsch& kernel, int threads) {
  constexpr int rounds = 3;
  const Matrix& rows = all.jacobian.rows;
  std::vector<double> w = weight, moment(weight.size());
  Vector effect = Vector::Zero(rows.cols());
  if (std::all_of(deviation.begin(), deviation.end(), [](double d) { return d == 0; })) return effect;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < w.size(); ++k) {
      const double left = deviation[k] - rows.row(static_cast<Eigen::Index>(k)).dot(effect);
      if (round > 0) w[k] = weight[k] * kernel.weight(left / all.sigma[all.nodes[k].begin]);
      moment[k] = w[k] * deviation[k];
    }
    const NormalEquations normal = normal_equations(rows, w, moment, threads);
    effect = pseudo_inverse(normal.h) * normal.g;
  }
  return effect.cwiseAbs();
}

/// Where the used points would be without their noise: across the ray of their view, on the surface where that is
/// unknown.
std::vector<Vec3> noise_free_places(const AllPoints& all, const std::vector<char>& inside) {
  std::vector<Vec3> ray(static_cast<std::size_t>(all.group_count), Vec3::Zero());
  const bool across = all.by_view && !all.rays.empty();
  if (across) {
    for (std::size_t i = 0; i < all.points.size(); ++i) ray[static_cast<std::size_t>(all.group[i])] += all.rays[i];
    for (auto& r : ray) r.normalize();
  }
  std::vector<Vec3> places;
  for (std::size_t k = 0; k < all.nodes.size(); ++k)
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
      if (!all.used[i] || !inside[k]) continue;
      const Vec3& r = ray[static_cast<std::size_t>(all.group[i])];
      places.push_back(across ? Vec3(all.points[i] - all.points[i].dot(r) * r)
                              : Vec3(all.points[i] - all.at.value[i] * all.jacobian.gradients[k]));
    }
  return places;
}

/// Statistics of the points of all nodes that are `inside`.
struct Residuals {
  double count = 0, slope = 0, square = 0;  ///< means of psi' and psi^2
  double rms = 0;                           ///< mm, of those that count
  double median_sigma = 0;                  ///< mm, of one point
  Correlation correlation;
  bool tell(std::size_t unknowns) const { return count > double(unknowns) && slope > 0 && square > 0; }
  /// Variance of a residual of unit weight, for `unknowns` that were fitted; correlation left out.
  double variance(std::size_t unknowns) const { return square / (slope * slope) * count / (count - double(unknowns)); }
  double noise(std::size_t unknowns) const { return variance(unknowns) * correlation.points_per_independent; }
};

Residuals residuals_of(const AllPoints& all, const std::vector<double>& value, const std::vector<char>& inside,
                       const Welsch& kernel, int threads) {
  Residuals result;
  double weights = 0, squares = 0;
  std::vector<double> psi, sigma;
  std::vector<int> group;
  for (std::size_t k = 0; k < all.nodes.size(); ++k)
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
      if (!all.used[i] || !inside[k]) continue;
      const double u = value[i] / all.sigma[i], w = kernel.weight(u);
      psi.push_back(kernel.psi(u)), sigma.push_back(all.sigma[i]);
      result.slope += kernel.slope(u), result.square += psi.back() * psi.back();
      weights += w, squares += w * value[i] * value[i];
      group.push_back(all.by_view ? all.group[i] : 0);
    }
  result.count = double(psi.size());
  result.slope /= std::max(result.count, 1.0), result.square /= std::max(result.count, 1.0);
  // The weighted square underestimates a Gaussian's by 1 + 1/c^2.
  result.rms = std::sqrt(squares / std::max(weights, 1e-300) * (kernel.before > 0 ? 1 : 1 + 1 / (kernel.c * kernel.c)));
  result.median_sigma = median_in_place(sigma);
  const int groups = all.by_view ? all.group_count : 1;
  result.correlation = correlation_of(noise_free_places(all, inside), psi, group, groups, threads);
  return result;
}

/// A scan with correlated noise: the noise alone, and what a smoothing may have done.
struct SmoothedScan {
  SmoothingModel model;
  std::vector<char> inside;  ///< per node; 0 at rims, whose disturbance is neither noise nor views
  Residuals residuals;       ///< of the points inside
  Deviation flattened;       ///< of curved faces, if it was smoothed
  double chance = 0;         ///< that it was
  Deviation rim, one_sided;  ///< what it did to rims then; empty: no rims are known
  /// Per node: variance of a residual of unit weight, correlation included; empty: the same for all.
  std::vector<double> noise;
};

std::vector<double> as_shares(const std::vector<char>& inside) { return {inside.begin(), inside.end()}; }

/// The weight of points near rims: their error is their noise plus about the effect that smoothing would have.
std::vector<double> shares_at_rims(const AllPoints& all, const SmoothedScan& scan) {
  std::vector<double> share(all.nodes.size(), 1);
  for (std::size_t k = 0; k < scan.rim.size(); ++k) {
    const double sigma = all.sigma[all.nodes[k].begin], disturbed = std::hypot(scan.rim[k], scan.one_sided[k]);
    share[k] = 1 / (1 + scan.chance * disturbed * disturbed / (sigma * sigma));
  }
  return share;
}

/// Noise is that of points inside their faces, without what a smoothing explains of the residuals.
SmoothedScan account_for_smoothing(const Candidate& candidate, AllPoints& all, const Unknowns& unknowns,
                                   double least_sigma, const Welsch& kernel, const Residuals& raw,
                                   const ModelDistance& distance, int threads) {
  constexpr double full_strength = 0.7;  // cosine; filters that keep steps are at their full strength there
  constexpr double enough = 1000;        // points to know a correlation by
  constexpr double likely = 0.5;         // probability from which points near rims are not used to estimate the noise
  SmoothedScan result;
  const double variance = raw.correlation.smoothing;
  const SmoothingEffect effect = smoothing_effect(candidate, all, variance, distance, threads);
  result.rim = effect.rim, result.one_sided = one_sided_mean(all, variance, threads);
  result.inside.resize(all.nodes.size());
  for (std::size_t k = 0; k < all.nodes.size(); ++k) result.inside[k] = effect.rim[k] == 0 && result.one_sided[k] == 0;
  constexpr int bins = 5;        // of incidence; more would take the waves of correlated noise away with them
  constexpr int fine_bins = 10;  // they follow where a filter that keeps steps stops to reach across
  result.model = smoothing_model(all, effect.face, raw.noise(unknowns.count()), bins);
  const auto solution_in = [&](const SmoothingModel& model, const std::vector<double>& share) {
    return solved(model, sums_of(all, model.rows, share, unknowns, kernel, raw.slope, threads), threads);
  };
  const std::vector<double> rest = left_over(all, result.model, solution_in(result.model, as_shares(result.inside)));
  result.residuals = residuals_of(all, rest, result.inside, kernel, threads);
  if (!result.residuals.tell(unknowns.count())) {
    constexpr double nobody_knows = 1;
    const auto chance = chance_by_rims(all, all.at.value, effect.rim, raw.correlation.points_per_independent);
    const std::vector<char> everywhere(all.nodes.size(), 1);
    return {{all.jacobian.rows}, everywhere, raw, effect.face, chance.value_or(nobody_knows), {}, {}, {}};
  }
  const auto by_rims = chance_by_rims(all, rest, effect.rim, result.residuals.correlation.points_per_independent);
  if (by_rims) {
    result.chance = *by_rims;
  } else if (!all.cosine.empty()) {
    // Silhouettes are the best evidence of what a filter does on slopes.
    std::vector<double> share(all.nodes.size());
    for (std::size_t k = 0; k < share.size(); ++k) share[k] = effect.rim[k] == 0;
    const SmoothingModel fine = smoothing_model(all, effect.face, raw.noise(unknowns.count()), fine_bins);
    result.chance = chance_by_incidence(fine, solution_in(fine, share), result.residuals.noise(unknowns.count()));
  } else {
    result.chance = 1;  // nobody knows
  }
  if (result.chance > likely) {
    std::vector<char> told = all.used;
    for (std::size_t k = 0; k < all.nodes.size(); ++k)
      for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end && !result.inside[k]; ++i) told[i] = 0;
    learn_noise(all, rest, std::move(told), least_sigma);
    result.residuals = residuals_of(all, rest, result.inside, kernel, threads);
  }
  std::vector<char> front = result.inside, slope(front.size(), 0), facing(front.size(), 1);
  if (!all.cosine.empty())
    for (std::size_t k = 0; k < front.size(); ++k) {
      facing[k] = all.cosine[all.nodes[k].begin] >= full_strength;
      front[k] = result.inside[k] && facing[k], slope[k] = result.inside[k] && !facing[k];
    }
  auto correlation_in = [&](const std::vector<char>& nodes) {
    const Residuals part = residuals_of(all, rest, nodes, kernel, threads);
    return part.count < enough ? result.residuals.correlation : part.correlation;
  };
  const Correlation full = correlation_in(front), partial = correlation_in(slope);
  result.flattened = effect.face;
  for (double& d : result.flattened) d *= full.smoothing / variance;
  for (const char f : facing)
    result.noise.push_back(result.residuals.variance(unknowns.count()) * (f ? full : partial).points_per_independent);
  return result;
}

/// Of views, or where they are unknown of regions or of views as they may have been, whichever leaves more open.
Vector spread_by_groups(const AllPoints& all, const Matrix& rows, const PointSums& whole, const GroupSums& unexplained,
                        const Unknowns& unknowns, const Matrix& extended_inverse, const Solution& fit, double noise) {
  const GroupEffects effects = group_effects(unexplained, extended_inverse, noise, Motions::apart);
  Vector variance = covariance_of(effects, whole.groups, fit.inverse).diagonal();
  if (!all.by_view) {
    GroupSums imagined = sums_of_imagined_views(all, rows, whole, unknowns);
    imagined.pull -= imagined.coupling * fit.unknowns;
    // Shifts can be seen only where oblique faces meet; the turns give an estimate of them.
    const GroupEffects tied = group_effects(imagined, fit.inverse, noise, Motions::tied);
    variance = variance.cwiseMax(covariance_of(tied, imagined, fit.inverse).diagonal());
  }
  return variance.cwiseMax(0).cwiseSqrt();
}

/// Of the unknowns: what the covariance of registered poses does to a fit. Unlike the disagreement of views it knows of
/// errors that views share, and of those that no residual shows because every view sees a side of its own.
Vector spread_by_poses(const AllPoints& all, const PoseCovariance& poses, const GroupSums& groups,
                       const Unknowns& unknowns, const Matrix& h_inverse) {
  Vector none = Vector::Zero(h_inverse.rows());
  if (!all.by_view || poses.matrix.size() == 0) return none;
  const auto m = static_cast<Eigen::Index>(all.views.size());
  // A turn about their centre is one about ours and a shift.
  const Vec3 arm = unknowns.center() - poses.center;
  Eigen::Matrix<double, 6, 6> motion = Eigen::Matrix<double, 6, 6>::Zero();
  for (int k = 0; k < 3; ++k)
    motion.block<3, 1>(0, k) = Vec3::Unit(k).cross(arm), motion(k, 3 + k) = 1, motion(3 + k, k) = unknowns.size();
  Matrix spread = Matrix::Zero(6 * m, 6 * m);
  for (Eigen::Index a = 0; a < m; ++a)
    for (Eigen::Index b = 0; b < m; ++b) {
      const auto &of_a = all.views[static_cast<std::size_t>(a)], &of_b = all.views[static_cast<std::size_t>(b)];
      Eigen::Matrix<double, 6, 6> mean = Eigen::Matrix<double, 6, 6>::Zero();  // of pooled views
      for (const int u : of_a)
        for (const int v : of_b) mean += poses.matrix.block<6, 6>(6 * u, 6 * v) / double(of_a.size() * of_b.size());
      spread.block<6, 6>(6 * a, 6 * b) = motion * mean * motion.transpose();
    }
  const Matrix answers = h_inverse * groups.coupling.transpose();
  return (answers * spread * answers.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
}

}  // namespace

Uncertainty uncertainty_of(const Candidate& candidate, AllPoints& all, const FitInput& input, const Unknowns& unknowns,
                           double least_sigma, const Welsch& kernel, Context& context) {
  Uncertainty result;
  const std::size_t parameters = unknowns.free_parameters().size();
  result.noise.assign(parameters, 0);
  result.views = result.poses = result.facets = result.filter = result.slant = result.noise;

  const std::vector<char> everywhere(all.nodes.size(), 1);
  const Residuals raw = residuals_of(all, all.at.value, everywhere, kernel, context.threads);
  if (!raw.tell(unknowns.count())) return result;
  result.rms = raw.rms;

  const Values values = values_of(candidate);
  const ModelDistance distance(bare_model(candidate), values);
  const bool sampled_facets = on_facets(input);
  SmoothedScan scan{{all.jacobian.rows}, everywhere, raw, {}, 0, {}, {}, {}};
  if (!sampled_facets && raw.correlation.smoothing > 0)
    scan = account_for_smoothing(candidate, all, unknowns, least_sigma, kernel, raw, distance, context.threads);

  const auto own = all.jacobian.rows.cols();
  const double noise = scan.residuals.noise(unknowns.count());
  const SmoothingModel model = scan.rim.empty() || scan.chance == 0
                                   ? SmoothingModel{all.jacobian.rows}
                                   : rim_model(all, scan.rim, scan.one_sided, scan.chance, noise);
  const std::vector<double> share = shares_at_rims(all, scan);
  const PointSums whole = sums_of(all, model.rows, share, unknowns, kernel, raw.slope, context.threads);
  const Solution fit = solved(model, whole, context.threads);
  if (model.further > 0) result.correction = -fit.unknowns.head(own);
  result.points_per_independent = scan.residuals.correlation.points_per_independent;
  result.floor = floor_share * scan.residuals.median_sigma;
  auto fill = [&](std::vector<double>& column, const Vector& spread) {
    for (std::size_t k = 0; k < parameters; ++k) column[k] = spread[static_cast<Eigen::Index>(k)];
  };
  std::vector<double> weight = whole.weight;
  for (std::size_t k = 0; k < weight.size(); ++k) weight[k] *= share[k] * (scan.noise.empty() ? noise : scan.noise[k]);
  const Matrix between = normal_equations(model.rows, weight, whole.pull, context.threads).h;
  fill(result.noise, (fit.inverse * between * fit.inverse).diagonal().cwiseMax(0).cwiseSqrt());
  if (sampled_facets) {  // a drawn mesh was never registered
    Deviation chords =
        mean_of_nodes(all, chord_deviation(candidate, all.points, *input.scan, coarse_inset, context.threads));
    if (all.chords_corrected)
      for (double& d : chords) d *= chords_left;
    fill(result.facets, effect_of(chords, all, whole.weight, kernel, context.threads));
    return result;
  }
  PointSums sums =
      sums_of(all, scan.model.rows, as_shares(scan.inside), unknowns, kernel, scan.residuals.slope, context.threads);
  const Solution solution = solved(scan.model, sums, context.threads);
  sums.groups.pull -= sums.groups.coupling * solution.unknowns;
  fill(result.views, spread_by_groups(all, model.rows, whole, sums.groups, unknowns, solution.inverse, fit, noise));
  if (input.scan)
    fill(result.poses, spread_by_poses(all, input.scan->pose_covariance, whole.groups, unknowns, fit.inverse));
  fill(result.slant, effect_of(slant_deviation(candidate, all, distance, context.threads), all, whole.weight, kernel,
                               context.threads));
  if (scan.chance > 0) {
    const Vector faces = effect_of(scan.flattened, all, whole.weight, kernel, context.threads);
    const Vector rims = fit.inverse.rightCols(model.further).rowwise().squaredNorm() * model.precision * noise;
    fill(result.filter, (rims.head(own) + scan.chance * faces.cwiseAbs2()).cwiseSqrt());
  }
  return result;
}

}  // namespace partscribe::fit
