#include "fit/evidence/evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "fit/refine/refine.h"
#include "geometry/points/kd_tree.h"
#include "model/check.h"
#include "model/distance/distance.h"
#include "model/sketch.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t local_points = 25;
constexpr double facet_margin = 1.25;  // the depth of a facet is known from its bends to some 20 %

/// True for a cloud of points rather than a surface: half of the points nearest to a place are farther from their
/// common plane than noise explains.
bool is_dust(const std::vector<Neighbour>& near, const std::vector<Vec3>& points, double sigma) {
  Vec3 mean = Vec3::Zero();
  for (const auto& k : near) mean += points[k.index] / double(near.size());
  Mat3 scatter = Mat3::Zero();
  for (const auto& k : near) scatter += (points[k.index] - mean) * (points[k.index] - mean).transpose();
  const Vec3 normal = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(0);
  std::vector<double> off;
  for (const auto& k : near) off.push_back(std::abs(normal.dot(points[k.index] - mean)));
  return median(std::move(off)) > 1.5 * sigma;
}

}  // namespace

std::string millimetres(double deviation, double tolerance) {
  return print_number(snapped(deviation, power_of_ten_below(std::max(tolerance / 20, 1e-9)))) + " mm";
}

bool drawable(const Candidate& c) {
  Values values;
  for (const auto& p : c.parameters) {
    if (!std::isfinite(p.value)) return false;
    values[p.name] = p.value;
  }
  const EvaluatedShape shape = evaluate(c.shape, values);
  const EvaluatedSketch* sketch = nullptr;
  if (const auto* s = std::get_if<ExtrudeOf<double>>(&shape)) sketch = &s->sketch;
  if (const auto* s = std::get_if<RevolveOf<double>>(&shape)) sketch = &s->sketch;
  if (!sketch) return true;
  for (const auto& loop : sketch->loops) {
    for (const auto& element : loop.elements)
      if (const auto* n = std::get_if<SketchNurbsOf<double>>(&element)) {
        if (n->control.size() < 2) return false;
        for (const double k : n->knots)
          if (!std::isfinite(k)) return false;
        for (const auto& p : n->control)
          if (!std::isfinite(p[0]) || !std::isfinite(p[1])) return false;
      }
    if (loop.elements.empty() || outline_of({{loop}}).curves.empty()) return false;
  }
  return true;
}

bool makes_sense(const Candidate& candidate) {
  return drawable(candidate) && !std::holds_alternative<Complaints>(check(bare_model(candidate)));
}

double description_length(const Candidate& candidate, std::size_t points) {
  std::size_t pieces = 0, numbers = candidate.parameters.size();
  const auto count_sketch = [&](const Sketch& sketch) {
    for (const auto& loop : sketch.loops)
      for (const auto& e : loop.elements) {
        ++pieces;
        if (const auto* n = std::get_if<SketchNurbs>(&e)) numbers += 2 * n->control.size() + n->knots.size();
      }
  };
  const auto count = [&](const Shape& shape) {
    ++pieces;
    if (const auto* s = std::get_if<Revolve>(&shape)) count_sketch(s->sketch);
    if (const auto* s = std::get_if<Extrude>(&shape)) count_sketch(s->sketch);
    if (const auto* s = std::get_if<HalfSpaces>(&shape)) pieces += s->planes.size(), numbers += 2 * s->planes.size();
    if (const auto* s = std::get_if<TriSurface>(&shape))
      pieces += s->triangles.size(), numbers += 3 * s->vertices.size();
  };
  for (const Object& step : candidate.steps) count(step.shape);
  count(candidate.shape);
  numbers += static_cast<std::size_t>(candidate.extra_numbers);
  const double per_number = 0.5 * std::log(double(std::max<std::size_t>(points, 3)));
  return 4.0 * double(pieces) + per_number * double(numbers);
}

std::shared_ptr<const Surroundings> surroundings_of(const FitInput& input, Context& context) {
  const auto& cloud = input.cloud;
  const std::size_t n = cloud.size();
  const KdTree tree(cloud.points);
  const bool normals = cloud.normals.size() == n;
  // The two sides of a thin wall are two places, where normals know their side.
  const auto along = [&](std::size_t a, std::size_t b) {
    const double cosine = cloud.normals[a].dot(cloud.normals[b]);
    return input.oriented ? cosine : std::abs(cosine);
  };
  // Farther points belong to another place; a point without neighbours of similar normal is not on a surface.
  const double sq_reach = std::pow(6 * input.thin_spacing, 2);
  std::vector<std::uint32_t> slots(n * local_points);
  std::vector<std::uint8_t> count(n, 0);
  parallel_for(n, context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(cloud.points[i], 2 * local_points, near);
      for (const auto& k : near) {
        if (k.sq_distance > sq_reach || count[i] == local_points) break;
        if (normals && along(i, k.index) < 0.7) continue;
        slots[i * local_points + count[i]++] = static_cast<std::uint32_t>(k.index);
      }
    }
  });
  Surroundings result;
  result.first.push_back(0);
  for (std::size_t i = 0; i < n; ++i) {
    const auto from = slots.begin() + static_cast<std::ptrdiff_t>(i * local_points);
    result.index.insert(result.index.end(), from, from + count[i]);
    result.first.push_back(result.index.size());
  }
  return std::make_shared<const Surroundings>(std::move(result));
}

CandidateEvidence evidence_of(const Candidate& candidate, const FitInput& input, Context& context) {
  CandidateEvidence result;
  const auto& cloud = input.cloud;
  const ModelDistance distance(bare_model(candidate));
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  const std::size_t n = cloud.size();
  std::vector<double> d(n);
  parallel_for(n, context.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) d[i] = distance(part_from_scan * cloud.points[i]).distance;
  });
  std::vector<double> local(n, 0.0);
  const bool known = input.surroundings && input.surroundings->first.size() == n + 1;
  const auto near_points = known ? input.surroundings : surroundings_of(input, context);
  parallel_for(n, context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> values;
    for (std::size_t i = begin; i < end; ++i) {
      values.clear();
      for (std::size_t k = near_points->first[i]; k < near_points->first[i + 1]; ++k)
        values.push_back(d[near_points->index[k]]);
      if (values.size() >= 9) local[i] = robust_mean(values).mean;
    }
  });
  // Deviations well inside the tolerance are not worth a longer description.
  const double sigma = std::max(input.sampling.sigma, 0.2 * input.tolerance);
  constexpr double of_noise = 0.0552;  // the mean of nats_of a standard normal variable
  const double each = weight_of_samples(n);
  const auto weigh = [&](double off, double u) {  // u: in sigmas
    const double nats = each * nats_of(u);
    result.misfit += nats;
    if (std::abs(u) >= 4 && std::abs(off) > input.tolerance) result.far_out += nats;
  };
  double sum = 0, count = 0;
  const bool facets = input.facet_depth.size() == n;
  for (std::size_t i = 0; i < n; ++i) {
    // Facets lie below the surface they stand for, and the fit between: no evidence for a body with as many faces.
    const double u =
        (facets ? std::max(0.0, std::abs(d[i]) - facet_margin * double(input.facet_depth[i])) : d[i]) / sigma;
    weigh(d[i], u);
    if (std::abs(u) < 4) sum += d[i] * d[i], count += 1;
  }
  result.roughness = result.misfit / (of_noise * each * double(std::max<std::size_t>(n, 1)));
  // Where outliers were set aside, some remain: points that lie on no plane with their neighbours are not used to judge
  // a candidate, nor are the worst points, a tenth of the share of the recognised outliers.
  const bool outliers = input.surface_share.size() == n;
  std::vector<std::pair<double, std::size_t>> judging;
  std::optional<KdTree> tree;
  std::vector<Neighbour> near;
  for (std::size_t i = 0; i < n; ++i) {
    if (outliers && input.surface_share[i] < 0.8f) continue;
    if (outliers && std::abs(local[i]) > input.tolerance) {
      if (!tree) tree.emplace(cloud.points);
      tree->nearest(cloud.points[i], local_points, near);
      if (is_dust(near, cloud.points, input.sampling.sigma)) continue;
    }
    judging.emplace_back(-std::abs(local[i]), i);
  }
  const std::size_t skipped =
      outliers ? static_cast<std::size_t>(std::min(0.02, 0.1 * input.outlier_share) * double(n)) : 0;
  if (judging.size() > skipped) {
    const auto at = judging.begin() + static_cast<std::ptrdiff_t>(skipped);
    std::nth_element(judging.begin(), at, judging.end());
    result.local_max = -at->first, result.worst = cloud.points[at->second];
  }
  result.rms = count > 0 ? std::sqrt(sum / count) : 0;
  result.description = description_length(candidate, std::min(n, deciding_samples));
  return result;
}

}  // namespace partscribe::fit
