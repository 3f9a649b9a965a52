#include "fit/refine/all_points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/number.h"
#include "core/parallel.h"
#include "fit/evidence/thin_walls.h"
#include "fit/refine/refine.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

constexpr int most_groups = 24;    // views beyond are pooled
constexpr double edge_sigmas = 3;  // nearer to an edge than this, noise decides which face a point is counted to
constexpr double edge_sigmas_on_rays = 1;  // with a ray the face is known; only pixels that cover an edge are uncertain
constexpr double most_excluded = 0.5;
constexpr double reach_sigmas = 8;  // outliers are not looked for along their rays

struct Entry {
  std::uint64_t cell;
  std::uint32_t index;
};

/// The points to use, sorted by cell and, inside a cell, by coordinates.
std::vector<Entry> entries_of(const PointCloud& cloud, const Box3& bounds, double spacing) {
  std::vector<Entry> entries;
  entries.reserve(cloud.size());
  const auto& p = cloud.points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if ((!cloud.rejected.empty() && cloud.rejected[i]) || !p[i].allFinite()) continue;
    std::uint64_t cell = 0;
    if (spacing > 0)
      for (int k = 0; k < 3; ++k) {
        const double at = std::clamp((p[i][k] - bounds.low[k]) / spacing, 0.0, 2097150.0);
        cell = cell << 21 | static_cast<std::uint64_t>(at);
      }
    entries.push_back({cell, static_cast<std::uint32_t>(i)});
  }
  std::sort(entries.begin(), entries.end(), [&](const Entry& a, const Entry& b) {
    if (a.cell != b.cell) return a.cell < b.cell;
    const Vec3 &u = p[a.index], &v = p[b.index];
    for (int k = 0; k < 3; ++k)
      if (u[k] != v[k]) return u[k] < v[k];
    return a.index < b.index;
  });
  return entries;
}

/// Eight octants about the centre: where no views are known, systematic errors are attributed to regions.
int octant(const Vec3& d) { return (d.x() > 0) + 2 * (d.y() > 0) + 4 * (d.z() > 0); }

void assign_traits(AllPoints& all, const PointCloud& cloud, const std::vector<Entry>& entries, const Vec3& center) {
  const std::size_t n = entries.size();
  std::map<int, int> numbers;
  if (cloud.view.size() == cloud.size())
    for (const auto& e : entries) numbers[cloud.view[e.index]] = 0;
  all.by_view = numbers.size() >= 2;
  int next = 0;
  for (auto& [view, number] : numbers) number = next++ % most_groups;
  if (all.by_view) {
    all.views.resize(std::min(numbers.size(), static_cast<std::size_t>(most_groups)));
    for (const auto& [view, number] : numbers) all.views[static_cast<std::size_t>(number)].push_back(view);
  }
  all.group_count = all.by_view ? std::min<int>(static_cast<int>(numbers.size()), most_groups) : 8;
  all.group.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    all.group[i] = all.by_view ? numbers[cloud.view[entries[i].index]] : octant(all.points[i] - center);
  if (cloud.rays.size() == cloud.size())
    for (const auto& e : entries) all.rays.push_back(cloud.rays[e.index]);
  if (cloud.sigma.size() == cloud.size())
    for (const auto& e : entries) all.relative.push_back(cloud.sigma[e.index]);
}

/// Residuals of all points, along the rays where these are known. The first time settles how far along them.
RayFeet measured(const Candidate& candidate, const Unknowns& unknowns, AllPoints& all, int threads) {
  Distances orthogonal = unknowns.distances(candidate, all.points, threads);
  if (all.rays.empty()) return {std::move(orthogonal), {}, {}};
  if (all.reach == 0) all.reach = reach_sigmas * robust_scale(orthogonal.value);
  return unknowns.along_rays(candidate, all.points, all.rays, std::move(orthogonal), all.reach, threads);
}

/// Cuts every cell into one run per face.
void make_nodes(AllPoints& all, const std::vector<Entry>& entries, bool single) {
  const std::size_t n = entries.size();
  const auto place = [&](std::size_t i) -> const Vec3& { return all.foot.empty() ? all.points[i] : all.foot[i]; };
  auto mean_place = [&](std::size_t begin, std::size_t end) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = begin; i < end; ++i) sum += place(i);
    return Vec3(sum / double(end - begin));
  };
  if (single) {
    for (std::size_t i = 0; i < n; ++i) all.nodes.push_back({i, i + 1, place(i)});
    return;
  }
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i;
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    while (end < n && entries[end].cell == entries[begin].cell) ++end;
    std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(begin),
                     order.begin() + static_cast<std::ptrdiff_t>(end),
                     [&](std::size_t a, std::size_t b) { return all.at.face[a] < all.at.face[b]; });
  }
  auto permute = [&](auto& column) {
    if (column.size() != n) return;
    auto copy = column;
    for (std::size_t i = 0; i < n; ++i) column[i] = copy[order[i]];
  };
  permute(all.points), permute(all.rays), permute(all.foot), permute(all.group), permute(all.cosine),
      permute(all.relative);
  permute(all.at.value), permute(all.at.face);
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    while (end < n && entries[end].cell == entries[begin].cell && all.at.face[end] == all.at.face[begin]) ++end;
    all.nodes.push_back({begin, end, mean_place(begin, end)});
  }
}

/// A place that stands for points of one face must have that face nearest itself.
void settle_places(AllPoints& all, const ModelDistance& distance, const Pose& part_from_scan, Distances& at,
                   int threads) {
  parallel_for(all.nodes.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      auto& node = all.nodes[k];
      ModelHit hit = distance(part_from_scan * node.place);
      if (hit.face != all.at.face[node.begin]) {
        const auto& candidates = all.foot.empty() ? all.points : all.foot;
        std::size_t best = node.begin;
        for (std::size_t i = node.begin; i < node.end; ++i)
          if ((candidates[i] - node.place).squaredNorm() < (candidates[best] - node.place).squaredNorm()) best = i;
        node.place = candidates[best];
        hit = {distance(part_from_scan * node.place).distance, all.at.face[best]};
      }
      at.value[k] = hit.distance, at.face[k] = hit.face;
    }
  });
}

/// Leaves out points so near an edge that their noise could have changed the face they are nearest to. They would bias
/// both faces, because noise that pushes a point over the edge also makes it look closer. They are chosen by their
/// place on the surface, not by their residuals, so that nothing is selected by its error.
/// Returns the points that could only have come from the far side of a thin wall, if `pairs` and no ray tells its sides
/// apart.
std::vector<std::size_t> exclude_edges(AllPoints& all, const ModelDistance& distance, const Pose& part_from_scan,
                                       double cell, bool pairs, int threads) {
  all.used.assign(all.points.size(), 1);
  std::vector<char> thin(all.points.size(), 0);
  parallel_for(
      all.nodes.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const auto& node = all.nodes[k];
          const double length = all.jacobian.gradients[k].norm();
          if (!(length > 0.5)) continue;
          const Vec3 normal = all.jacobian.gradients[k] / length;
          const int face = all.at.face[node.begin];
          const auto on_ray = [&](std::size_t i) { return !all.foot.empty() && all.foot[i] != all.points[i]; };
          const auto strip = [&](std::size_t i) {
            return (on_ray(i) ? edge_sigmas_on_rays : edge_sigmas) * all.sigma[i];
          };
          double widest = 0;
          for (std::size_t i = node.begin; i < node.end; ++i) widest = std::max(widest, strip(i));
          if (node.end - node.begin > 1) {
            // The whole cell at once where it lies well inside its face.
            const Vec3 foot = node.place - distance(part_from_scan * node.place).distance * normal;
            if (beside(distance, part_from_scan, foot, normal, widest + cell, face) == Beside::nothing) continue;
          }
          for (std::size_t i = node.begin; i < node.end; ++i) {
            const Vec3 foot = on_ray(i) ? all.foot[i] : Vec3(all.points[i] - all.at.value[i] * normal);
            const Beside other = beside(distance, part_from_scan, foot, normal, strip(i), face);
            thin[i] = other == Beside::wall && !on_ray(i) && pairs;
            all.used[i] = other == Beside::nothing || (other == Beside::wall && (on_ray(i) || pairs));
          }
        }
      },
      64);
  std::vector<std::size_t> walls;
  for (std::size_t i = 0; i < all.points.size(); ++i)
    if (thin[i]) walls.push_back(i);
  // A narrow face, all of whose points are near an edge, would be lost: it keeps its points.
  std::map<int, std::pair<std::size_t, std::size_t>> faces;
  for (std::size_t i = 0; i < all.points.size(); ++i)
    ++faces[all.at.face[i]].first, faces[all.at.face[i]].second += !all.used[i];
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    const auto& [total, lost] = faces[all.at.face[i]];
    if (double(lost) > most_excluded * double(total)) all.used[i] = 1;
  }
  return walls;
}

/// The requested kernel; if the options allow it, with the density of outliers on either side, estimated from the
/// points beyond the noise.
void estimate_outliers(AllPoints& all, const AllPointsOptions& options) {
  all.kernel = options.kernel;
  if (!options.outliers_near || !all.pairs.empty()) return;
  constexpr double from = 4, to = 8, most = 0.05;  // sigmas
  double on = 0, before = 0.5, behind = 0.5;
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    if (!all.used[i]) continue;
    const double u = all.at.value[i] / all.sigma[i];
    on += std::abs(u) < 3;
    if (std::abs(u) > from && std::abs(u) < to) (u > 0 ? before : behind) += 1;
  }
  const double unit = std::sqrt(2 * pi) / (to - from) / std::max(on, 1.0);
  all.kernel.before = std::min(most, before * unit), all.kernel.behind = std::min(most, behind * unit);
}

}  // namespace

void learn_noise(AllPoints& all, const std::vector<double>& residuals, std::vector<char> told, double least_sigma) {
  // Noise does not differ between octants.
  NoiseTraits traits;
  if (all.by_view) traits.group = all.group, traits.group_count = all.group_count;
  traits.face = all.at.face, traits.cosine = all.cosine, traits.relative = all.relative, traits.told = std::move(told);
  all.sigma = noise_of_points(residuals, traits, least_sigma);
}

AllPoints all_points(const Candidate& candidate, const FitInput& input, const Unknowns& unknowns, double least_sigma,
                     const AllPointsOptions& options, Context& context) {
  const bool whole = input.scan && input.scan->mesh.empty() && input.scan->cloud.size() > input.cloud.size() &&
                     input.scan->cloud.size() <= options.points;
  const PointCloud& cloud = whole ? input.scan->cloud : input.cloud;
  const bool single = cloud.size() <= options.nodes;
  // Points on a surface: their number goes with the square of the spacing.
  const double spacing =
      single ? 0 : input.thin_spacing * std::sqrt(double(input.cloud.size()) / double(options.nodes));
  const auto entries = entries_of(cloud, input.bounds, spacing);
  AllPoints all;
  for (const auto& e : entries) all.points.push_back(cloud.points[e.index]);
  assign_traits(all, cloud, entries, unknowns.center());
  RayFeet feet = measured(candidate, unknowns, all, context.threads);
  all.at = std::move(feet.at), all.foot = std::move(feet.foot), all.cosine = std::move(feet.cosine);
  // By the place on the surface: the region of a measured point would depend on its error.
  for (std::size_t i = 0; i < all.foot.size() && !all.by_view; ++i)
    all.group[i] = octant(all.foot[i] - unknowns.center());
  make_nodes(all, entries, single);
  learn_noise(all, all.at.value, {}, least_sigma);

  const Values values = values_of(candidate);
  const ModelDistance distance(bare_model(candidate), values);
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  Distances at;
  at.value.resize(all.nodes.size()), at.face.resize(all.nodes.size());
  settle_places(all, distance, part_from_scan, at, context.threads);
  std::vector<Vec3> places;
  for (const auto& node : all.nodes) places.push_back(node.place);
  all.jacobian = unknowns.jacobian(candidate, places, at, context.threads);
  // Runs that share a row of the Jacobian know one side only.
  const bool pairs = single && all.rays.empty();
  const auto walls = exclude_edges(all, distance, part_from_scan, spacing, pairs, context.threads);
  estimate_outliers(all, options);
  add_far_sides(all, walls, edge_sigmas, candidate, unknowns, distance, context.threads);
  return all;
}

double polish(Candidate& candidate, AllPoints& all, const Unknowns& unknowns, double least_sigma,
              const AllPointsOptions& options, Context& context) {
  constexpr int halvings = 3;
  constexpr double settled = 1e-3;
  constexpr double worse = 0.02;  // share of the cost that may be given up for the equations to hold
  const int steps = !all.pairs.empty() ? 12
                    : all.rays.empty() ? 2
                                       : 4;  // rays call for another place than the search did
  std::vector<char> in_pair(all.pairs.empty() ? 0 : all.points.size(), 0);
  for (const auto& p : all.pairs) in_pair[p.near] = in_pair[p.far] = 1;
  const auto paired = [&](std::size_t i) { return !in_pair.empty() && in_pair[i]; };
  const auto cost = [&](const std::vector<double>& d) {
    double sum = 0;
    for (std::size_t i = 0; i < d.size(); ++i)
      if (all.used[i] && !paired(i)) sum += all.kernel.loss(d[i] / all.sigma[i]);
    for (std::size_t p = 0; p < all.pairs.size(); ++p) sum += pair_loss(all, p, d);
    return sum;
  };
  const auto equations = [&](const std::vector<double>& d) {
    std::vector<double> weight(all.nodes.size(), 0), pull(all.nodes.size(), 0);
    parallel_for(all.nodes.size(), context.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
          if (!all.used[i]) continue;
          const double u = d[i] / all.sigma[i], unit = 1 / all.sigma[i];
          if (paired(i)) {
            weight[k] += all.say[i] * unit * unit, pull[k] += all.say[i] * u * unit;
            continue;
          }
          weight[k] += all.kernel.slope(u) * unit * unit;
          pull[k] += all.kernel.psi(u) * unit;
        }
    });
    return normal_equations(all.jacobian.rows, weight, pull, context.threads);
  };
  double improvement = 0;
  for (int step = 0; step < steps; ++step) {
    share_out_pairs(all);
    const NormalEquations normal = equations(all.at.value);
    const Matrix inverse = pseudo_inverse(normal.h);
    const double unrest = normal.g.dot(inverse * normal.g), before = cost(all.at.value);
    Vector way = -inverse * normal.g;
    bool better = false;
    for (int k = 0; k <= halvings && !better; ++k, way *= 0.5) {
      const Candidate next = unknowns.stepped(candidate, way);
      if (!unknowns.sensible(next)) continue;
      RayFeet moved = measured(next, unknowns, all, context.threads);
      measure_pairs(all, next, moved.at.value, context.threads);
      // Along rays the sum of squares is not what the equations make least: it has the cosines in it, which the surface
      // moves. There the equations themselves say whether a step was good (the natural monotonicity test, Deuflhard
      // 1974).
      if (all.rays.empty()) {
        if (cost(moved.at.value) > before * (1 + 1e-9)) continue;
      } else {
        const Vector g = equations(moved.at.value).g;
        if (g.dot(inverse * g) > unrest || cost(moved.at.value) > before * (1 + worse)) continue;
      }
      better = true;
      candidate = next;
      all.at.value = std::move(moved.at.value);  // the nodes are made of the first faces
      all.foot = std::move(moved.foot), all.cosine = std::move(moved.cosine);
    }
    if (!better) break;
    improvement += 0.5 * unrest;
    if (!all.pairs.empty() && unrest < settled) break;
    // The sides of thin walls are told apart by the noise as it was learned first.
    if (step == 0 && all.pairs.empty()) learn_noise(all, all.at.value, {}, least_sigma);
    if (step == 0) estimate_outliers(all, options);
  }
  drop_pairs(all);
  return improvement;
}

}  // namespace partscribe::fit
