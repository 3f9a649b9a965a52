#include "fit/refine/refine.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/statistics.h"
#include "fit/refine/all_points.h"
#include "fit/refine/chords.h"
#include "fit/refine/normal_equations.h"
#include "fit/refine/unknowns.h"
#include "fit/uncertainty/open_ends.h"
#include "fit/uncertainty/uncertainty.h"
#include "geometry/least_squares.h"

namespace partscribe::fit {
namespace {

/// An even selection, by stride.
std::vector<Vec3> selected(const std::vector<Vec3>& points, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (points.size() + most - 1) / std::max<std::size_t>(most, 1));
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < points.size(); i += step) result.push_back(points[i]);
  return result;
}

double median_scale(std::vector<double> d) {
  for (auto& v : d) v = std::abs(v);
  return 1.4826 * median_in_place(d);
}

/// Scale of the residuals for each point: the common one, but in the first rounds that of its face if it is larger.
/// Otherwise the points of a small face that starts in the wrong place would be taken for outliers.
std::vector<double> scales_of(const Distances& d, double scale, bool by_face) {
  constexpr std::size_t least_points = 10;
  std::vector<double> result(d.value.size(), scale);
  if (!by_face) return result;
  std::map<int, std::vector<double>> faces;
  for (std::size_t i = 0; i < d.value.size(); ++i) faces[d.face[i]].push_back(d.value[i]);
  std::map<int, double> of_face;
  for (auto& [face, values] : faces)
    of_face[face] = values.size() < least_points ? scale : std::max(scale, median_scale(std::move(values)));
  for (std::size_t i = 0; i < d.value.size(); ++i) result[i] = of_face[d.face[i]];
  return result;
}

/// Levenberg-Marquardt from wherever the candidate stands.
void descend(Candidate& candidate, const Unknowns& unknowns, const std::vector<Vec3>& points, double noise,
             const RefineOptions& options, RefineReport& report, Context& context) {
  const int rounds_by_face = options.near ? 0 : 5;
  const Welsch kernel{options.welsch};
  const double size = unknowns.size();
  auto cost = [&](const std::vector<double>& d, const std::vector<double>& scales) {
    double sum = 0;
    for (std::size_t i = 0; i < d.size(); ++i) sum += kernel.loss(d[i] / scales[i]) * scales[i] * scales[i];
    return sum;
  };
  Candidate best = candidate;
  Distances d = unknowns.distances(best, points, context.threads);
  double scale = std::max(median_scale(d.value), noise);
  Damping damping;
  damping.value = 1e-6;
  std::vector<double> weight(points.size()), pull(points.size());
  for (; report.iterations < options.iterations && !context.cancelled; ++report.iterations) {
    const bool by_face = report.iterations < rounds_by_face;
    const auto scales = scales_of(d, scale, by_face);
    for (std::size_t i = 0; i < points.size(); ++i)
      weight[i] = kernel.weight(d.value[i] / scales[i]), pull[i] = weight[i] * d.value[i];
    const Jacobian jacobian = unknowns.jacobian(best, points, d, context.threads);
    const NormalEquations normal = normal_equations(jacobian.rows, weight, pull, context.threads);
    const double before = cost(d.value, scales), trace = normal.h.trace() / double(normal.h.rows());
    double largest = 0;
    const auto solve = [](const Matrix& h, const Vector& g) { return Vector(pseudo_inverse(h) * g); };
    const bool improved = damped_step(normal.h, normal.g, 1e-6 * trace, damping, 8, solve, [&](const Vector& step) {
      Candidate next = unknowns.stepped(best, step);
      if (step.tail<3>().norm() > 0.5 * size || !unknowns.sensible(next)) {
        damping.value = std::max(damping.value, 1e-4);  // far too long
        return false;
      }
      Distances next_d = unknowns.distances(next, points, context.threads);
      if (cost(next_d.value, scales) > before * (1 + 1e-12)) return false;
      largest = step.cwiseAbs().maxCoeff();
      best = std::move(next);
      d = std::move(next_d);
      return true;
    });
    const double new_scale = std::max(median_scale(d.value), noise);
    const bool scale_settled = new_scale > 0.97 * scale;
    scale = std::min(scale, new_scale);
    if (!improved || (largest < 1e-7 * size && scale_settled)) {
      report.converged = true;
      if (!by_face) break;
      // The last rounds use the common scale.
      report.iterations = rounds_by_face - 1;
    }
  }
  candidate = std::move(best);

  double sum = 0, weights = 0;
  std::size_t inliers = 0;
  for (const double v : d.value) {
    const double w = kernel.weight(v / scale);
    sum += w * v * v, weights += w;
    inliers += std::abs(v) < 4 * scale;
  }
  // The weighted square underestimates a Gaussian's by 1 + 1/c^2; undo it.
  report.rms = std::sqrt(sum / std::max(weights, 1e-300) * (1 + 1 / (options.welsch * options.welsch)));
  report.inlier_share = double(inliers) / double(d.value.size());
}

/// How much the numbers depend on the weight of points that may be outliers: half the range, in their own units, of
/// three fits. In one nearly all distant points lose their weight, in another hardly any, and in the third the points
/// that were set aside as outliers are used as well. Noise alone moves the numbers by less than its own sigma.
std::vector<double> sway_of_outliers(const Candidate& candidate, const Unknowns& unknowns,
                                     const std::vector<Vec3>& points, const std::vector<Vec3>& set_aside, double noise,
                                     Context& context) {
  constexpr double little = 1.5, much = 4;
  std::vector<Candidate> ends;
  const auto answer = [&](double welsch, const std::vector<Vec3>& from) {
    RefineOptions options;
    options.iterations = 12;
    options.welsch = welsch;
    RefineReport unused;
    ends.push_back(candidate);
    descend(ends.back(), unknowns, from, noise, options, unused, context);
  };
  answer(little, points);
  answer(much, points);
  if (!set_aside.empty()) {
    std::vector<Vec3> all = points;
    all.insert(all.end(), set_aside.begin(), set_aside.end());
    answer(much, all);
  }
  std::vector<double> result;
  for (const std::size_t k : unknowns.free_parameters()) {
    const auto [least, most] = std::ranges::minmax(ends, {}, [&](const Candidate& c) { return c.parameters[k].value; });
    result.push_back(0.5 * (most.parameters[k].value - least.parameters[k].value));
  }
  return result;
}

/// How many points each parameter depends on.
void count_points(Candidate& candidate, const AllPoints& all, const Unknowns& unknowns, double points_per_independent) {
  const auto& free = unknowns.free_parameters();
  for (std::size_t k = 0; k < free.size(); ++k) {
    auto& p = candidate.parameters[free[k]];
    for (std::size_t n = 0; n < all.nodes.size(); ++n) {
      if (!(std::abs(all.jacobian.rows(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(k))) > 0.1)) continue;
      for (std::size_t i = all.nodes[n].begin; i < all.nodes[n].end; ++i)
        p.points += all.used[i] && std::abs(all.at.value[i]) < 4 * all.sigma[i];
    }
    p.effective_points = static_cast<std::size_t>(std::round(double(p.points) / points_per_independent));
  }
}

}  // namespace

Model bare_model(const Candidate& candidate) {
  Model model;
  model.parameters = candidate.parameters;
  model.objects = candidate.steps;
  model.objects.push_back({candidate.object_name, candidate.shape, {}, {}, {}});
  model.as_scanned = false;
  return model;
}

Values values_of(const Candidate& candidate) {
  Values values;
  for (const auto& p : candidate.parameters) values[p.name] = p.formula ? evaluate(*p.formula, values) : p.value;
  return values;
}

RefineReport refine(Candidate& candidate, const FitInput& input, const RefineOptions& options, Context& context) {
  RefineReport report;
  std::vector<std::string> fixed = options.fixed;
  for (const auto& h : candidate.held) fixed.push_back(h.name);
  // Among outliers each plane of a polyhedron was fitted alone; a turn of all would follow outliers near faces that
  // nobody saw.
  const bool moves = !(std::holds_alternative<HalfSpaces>(candidate.shape) && among_outliers(input));
  const Unknowns unknowns(candidate, fixed, input.bounds.center(), std::max(0.5 * input.bounds.diagonal(), 1e-9),
                          moves);
  const double noise = std::max(input.sampling.sigma, 1e-7 * unknowns.size());
  // The last steps take every point; before them a sample finds the way as well.
  constexpr std::size_t enough_to_start = 8000;
  const std::vector<Vec3> points =
      selected(input.cloud.points, options.uncertainty ? std::min(options.points, enough_to_start) : options.points);
  if (points.size() < unknowns.count()) return report;
  descend(candidate, unknowns, points, noise, options, report, context);
  for (auto& p : candidate.parameters)
    p.fitted = p.value, p.sigma = p.sigma_noise = p.sigma_systematic = 0, p.points = p.effective_points = 0;
  if (!options.uncertainty || context.cancelled) return report;

  constexpr int rounds_on_rays = 4;
  constexpr double settled = 0.5;  // of the log likelihood: less than a sigma
  AllPointsOptions everything;
  everything.kernel.c = options.welsch < RefineOptions{}.welsch ? options.welsch : std::max(options.welsch, 3.0);
  everything.outliers_near = input.outlier_share > 0 && !among_outliers(input);
  // A distance found by Newton's method in three unknowns costs as much as a hundred others.
  if (std::holds_alternative<Superellipsoid>(candidate.shape)) everything.nodes = 4000, everything.points = 40000;
  const double least = std::max(0.3 * input.sampling.sigma, 1e-7 * unknowns.size());
  AllPoints all = all_points(candidate, input, unknowns, least, everything, context);
  double improvement = polish(candidate, all, unknowns, least, everything, context);
  // Residuals along rays can lead far along what the data hardly fix: the derivatives there are others.
  for (int round = 1; round < rounds_on_rays && !all.rays.empty() && improvement > settled; ++round) {
    all = all_points(candidate, input, unknowns, least, everything, context);
    improvement = polish(candidate, all, unknowns, least, everything, context);
  }
  if (on_facets(input)) correct_for_chords(candidate, all, input, unknowns, least, context);
  const Uncertainty u = uncertainty_of(candidate, all, input, unknowns, least, all.kernel, context);
  if (u.correction.size() > 0)
    if (Candidate next = unknowns.stepped(candidate, u.correction); unknowns.sensible(next))
      candidate = std::move(next);
  const std::vector<OpenEnd> ends = settle_open_ends(candidate, all, unknowns, points, input, noise, context);
  report.rms = u.rms;
  report.points_per_independent = u.points_per_independent;
  const auto& free = unknowns.free_parameters();
  std::vector<double> outliers =
      input.outlier_share > 0 ? sway_of_outliers(candidate, unknowns, points, input.set_aside.points, noise, context)
                              : std::vector<double>(free.size(), 0);
  for (std::size_t k = 0; k < free.size(); ++k)  // nothing holds an open end there
    for (const OpenEnd& end : ends)
      if (end.parameter == free[k] && end.unlimited) outliers[k] = std::min(outliers[k], end.reach);
  for (std::size_t k = 0; k < free.size(); ++k) {
    auto& p = candidate.parameters[free[k]];
    p.fitted = p.value;
    p.sigma_noise = u.noise[k];
    const double least_known = std::max(u.floor, input.precision);
    const double floor = p.quantity == Quantity::length ? least_known : least_known / unknowns.size();
    p.sigma_systematic = std::hypot(std::hypot(u.views[k], u.poses[k], u.facets[k]),
                                    std::hypot(u.filter[k], u.slant[k]), std::hypot(outliers[k], floor));
    p.sigma = std::hypot(p.sigma_noise, p.sigma_systematic);
  }
  for (const auto& h : candidate.held)
    for (auto& p : candidate.parameters)
      if (p.name == h.name) p.sigma = p.sigma_systematic = std::max({h.sigma, u.floor, input.precision});
  count_points(candidate, all, unknowns, u.points_per_independent);
  for (const OpenEnd& end : ends) {
    auto& p = candidate.parameters[end.parameter];
    if (end.unlimited)
      report.unlimited.push_back(p.name);
    else if (p.points >= hardly_any_points)
      continue;  // a Gaussian, which has its own sigma
    p.sigma_systematic = std::max(p.sigma_systematic, end.sigma);
    p.sigma = std::hypot(p.sigma_noise, p.sigma_systematic);
  }
  return report;
}

}  // namespace partscribe::fit
