#include "fit/refine/chords.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "fit/refine/refine.h"
#include "geometry/mesh/mesh_distance.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

/// mm, of what is not zero.
double root_mean_square(const AllPoints& all, const std::vector<double>& values) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (all.used[i]) sum += values[i] * values[i], count += values[i] != 0;
  return count > 0 ? std::sqrt(sum / count) : 0;
}

std::vector<double> without(const std::vector<double>& values, const std::vector<double>& deviation) {
  std::vector<double> result = values;
  for (std::size_t i = 0; i < result.size(); ++i) result[i] -= deviation[i];
  return result;
}

}  // namespace

bool on_facets(const FitInput& input) {
  return input.scan && !input.scan->mesh.empty() && input.scan->cloud.size() > input.scan->mesh.vertices.size();
}

std::vector<double> chord_deviation(const Candidate& candidate, const std::vector<Vec3>& points, const Scan& scan,
                                    double inset, int threads) {
  const double whole = (2.0 / 3) / (inset * inset - 1.0 / 3);
  const TriangleMesh& mesh = scan.mesh;
  const ModelDistance distance(bare_model(candidate), values_of(candidate));
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  std::vector<std::array<double, 3>> corner(mesh.triangles.size());
  parallel_for(corner.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
      for (int k = 0; k < 3; ++k)
        corner[t][k] = distance(part_from_scan * (middle + inset * (mesh.corner(t, k) - middle))).distance;
    }
  });
  const MeshDistance nearest(mesh);
  std::vector<double> result(points.size(), 0);
  parallel_for(points.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const MeshHit hit = nearest.closest(points[i]);
      const auto& t = mesh.triangles[hit.triangle];
      const Vec3 a = mesh.vertices[t[0]], ab = mesh.vertices[t[1]] - a, ac = mesh.vertices[t[2]] - a;
      const Vec3 normal = ab.cross(ac), p = points[i] - a;
      const double square = normal.squaredNorm();
      if (!(square > 0)) continue;
      const auto inner = [&](double share) { return 1.0 / 3 + (share - 1.0 / 3) / inset; };
      const double v = inner(p.cross(ac).dot(normal) / square), u = inner(ab.cross(p).dot(normal) / square);
      const auto& c = corner[hit.triangle];
      result[i] = whole * (distance(part_from_scan * points[i]).distance - ((1 - u - v) * c[0] + v * c[1] + u * c[2]));
    }
  });
  return result;
}

std::vector<double> mean_of_nodes(const AllPoints& all, const std::vector<double>& of_points) {
  std::vector<double> result(all.nodes.size(), 0);
  for (std::size_t k = 0; k < all.nodes.size(); ++k) {
    double sum = 0, weights = 0;
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
      if (!all.used[i]) continue;
      const double w = 1 / (all.sigma[i] * all.sigma[i]);
      sum += w * of_points[i], weights += w;
    }
    if (weights > 0) result[k] = sum / weights;
  }
  return result;
}

void correct_for_chords(Candidate& candidate, AllPoints& all, const FitInput& input, const Unknowns& unknowns,
                        double least_sigma, Context& context) {
  constexpr double far_closer = 0.1;
  Candidate next = candidate;
  std::vector<double> value = all.at.value, rest;
  for (const double inset : {coarse_inset, 0.99, fine_inset, fine_inset}) {
    const std::vector<double> depth = chord_deviation(next, all.points, *input.scan, inset, context.threads);
    rest = without(value, depth);
    if (!(root_mean_square(all, depth) > least_sigma)) return;  // flat faces only: nothing to correct
    std::vector<double> weight(all.nodes.size(), 0), pull(all.nodes.size(), 0);
    for (std::size_t k = 0; k < all.nodes.size(); ++k)
      for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
        if (!all.used[i]) continue;
        weight[k] += 1, pull[k] += rest[i];
      }
    const NormalEquations normal = normal_equations(all.jacobian.rows, weight, pull, context.threads);
    Candidate stepped = unknowns.stepped(next, -pseudo_inverse(normal.h) * normal.g);
    if (!unknowns.sensible(stepped)) return;
    next = std::move(stepped);
    value = unknowns.distances(next, all.points, context.threads).value;
  }
  const std::vector<double> depth = chord_deviation(next, all.points, *input.scan, fine_inset, context.threads);
  rest = without(value, depth);
  if (root_mean_square(all, rest) > far_closer * root_mean_square(all, depth)) return;
  candidate = std::move(next);
  all.at.value = std::move(rest);
  all.chords_corrected = true;
  learn_noise(all, all.at.value, {}, least_sigma);
}

}  // namespace partscribe::fit
