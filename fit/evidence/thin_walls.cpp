#include "fit/evidence/thin_walls.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.h"
#include "fit/refine/refine.h"

namespace partscribe::fit {
namespace {

constexpr double looks_away = -0.5;      // cosine between the normals of the two sides of a wall
constexpr double beyond_doubt = 0.8;     // probability
constexpr double least_outliers = 1e-3;  // their density over that of the surface; keeps the logarithm finite

Vec3 gradient(const ModelDistance& distance, const Vec3& q, double at, double h) {
  Vec3 g;
  for (int k = 0; k < 3; ++k) g[k] = (distance(q + h * Vec3::Unit(k)).distance - at) / h;
  return g;
}

double outliers_of(const AllPoints& all) { return std::max({all.kernel.before, all.kernel.behind, least_outliers}); }

/// How likely a residual is, as a share of the most likely.
double bell(double u) { return std::exp(-0.5 * u * u); }

}  // namespace

Beside beside(const ModelDistance& distance, const Pose& part_from_scan, const Vec3& foot, const Vec3& normal,
              double reach, int face) {
  if (distance(part_from_scan * (foot + reach * normal)).face != face) return Beside::edge;
  const Vec3 q = part_from_scan * (foot - reach * normal);
  const ModelHit hit = distance(q);
  if (hit.face == face) return Beside::nothing;
  const Vec3 g = gradient(distance, q, hit.distance, 1e-3 * reach);
  return (part_from_scan.rotation * normal).dot(g) < looks_away * g.norm() ? Beside::wall : Beside::edge;
}

void add_far_sides(AllPoints& all, const std::vector<std::size_t>& points, double reach_sigmas,
                   const Candidate& candidate, const Unknowns& unknowns, const ModelDistance& distance, int threads) {
  if (points.empty()) return;
  const std::size_t n = all.points.size();
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  std::vector<std::size_t> node_of(n);
  for (std::size_t k = 0; k < all.nodes.size(); ++k)
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) node_of[i] = k;
  std::vector<Vec3> places;
  Distances at;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::size_t i = points[p];
    const Vec3 normal = all.jacobian.gradients[node_of[i]].normalized();
    const Vec3 foot = all.points[i] - all.at.value[i] * normal;
    const double reach = reach_sigmas * all.sigma[i];
    const Vec3 behind = foot - reach * normal;
    const ModelHit hit = distance(part_from_scan * behind);
    places.push_back(behind), at.value.push_back(hit.distance), at.face.push_back(hit.face);
    all.pairs.push_back({i, n + p, foot + reach * normal, behind});
  }
  const Jacobian far = unknowns.jacobian(candidate, places, at, threads);
  const Eigen::Index rows = all.jacobian.rows.rows();
  all.jacobian.rows.conservativeResize(rows + far.rows.rows(), Eigen::NoChange);
  all.jacobian.rows.bottomRows(far.rows.rows()) = far.rows;
  const auto copy = [&](auto& column) {
    if (column.size() != n) return;
    for (const std::size_t i : points) column.push_back(column[i]);
  };
  copy(all.points), copy(all.group), copy(all.cosine), copy(all.relative), copy(all.sigma), copy(all.used),
      copy(all.at.value);
  for (std::size_t p = 0; p < points.size(); ++p) {
    all.at.face.push_back(at.face[p]);
    all.nodes.push_back({n + p, n + p + 1, places[p]});
    all.jacobian.gradients.push_back(far.gradients[p]);
  }
  all.say.assign(all.points.size(), 1);
  measure_pairs(all, candidate, all.at.value, threads);
}

void measure_pairs(const AllPoints& all, const Candidate& candidate, std::vector<double>& value, int threads) {
  if (all.pairs.empty()) return;
  const Values values = values_of(candidate);
  const ModelDistance distance(bare_model(candidate), values);
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  parallel_for(all.pairs.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const auto& pair = all.pairs[p];
      const auto from = [&](const Vec3& probe) {
        const Vec3 q = part_from_scan * probe;
        const double d = distance(q).distance;
        const Vec3 g = gradient(distance, q, d, 1e-3 * all.sigma[pair.near]).normalized();
        return d + (part_from_scan * all.points[pair.near] - q).dot(g);
      };
      value[pair.near] = from(pair.before), value[pair.far] = from(pair.behind);
    }
  });
}

void share_out_pairs(AllPoints& all) {
  constexpr int rounds = 30;
  std::map<std::pair<int, int>, std::vector<std::size_t>> walls;
  for (std::size_t p = 0; p < all.pairs.size(); ++p)
    walls[std::minmax(all.at.face[all.pairs[p].near], all.at.face[all.pairs[p].far])].push_back(p);
  const double outliers = outliers_of(all);
  for (const auto& [faces, members] : walls) {
    const int first = faces.first;
    double share = 0.5;  // of the first face
    for (int round = 0; round < rounds; ++round) {
      double mine = 0, both = 0;
      for (const std::size_t p : members) {
        auto& pair = all.pairs[p];
        const bool near_is_first = all.at.face[pair.near] == first;
        pair.share = near_is_first ? share : 1 - share;
        const double a = pair.share * bell(all.at.value[pair.near] / all.sigma[pair.near]);
        const double b = (1 - pair.share) * bell(all.at.value[pair.far] / all.sigma[pair.far]);
        const double sum = a + b + outliers;
        all.say[pair.near] = a / sum, all.say[pair.far] = b / sum;
        mine += (near_is_first ? a : b) / sum, both += (a + b) / sum;
      }
      if (both > 0) share = std::clamp(mine / both, 1e-3, 1 - 1e-3);
    }
  }
}

double pair_loss(const AllPoints& all, std::size_t pair, const std::vector<double>& value) {
  const auto& p = all.pairs[pair];
  return -std::log(p.share * bell(value[p.near] / all.sigma[p.near]) +
                   (1 - p.share) * bell(value[p.far] / all.sigma[p.far]) + outliers_of(all));
}

void drop_pairs(AllPoints& all) {
  if (all.pairs.empty()) return;
  const std::size_t n = all.points.size() - all.pairs.size(), nodes = all.nodes.size() - all.pairs.size();
  // Points that almost certainly belong to their nearest side stay there; so do all points of a face that would lose
  // most of its points.
  std::map<int, std::pair<std::size_t, std::size_t>> faces;
  for (std::size_t i = 0; i < n; ++i) faces[all.at.face[i]].first += all.used[i];
  for (const auto& p : all.pairs) faces[all.at.face[p.near]].second += all.say[p.near] < beyond_doubt;
  for (const auto& p : all.pairs) {
    const auto& [total, lost] = faces[all.at.face[p.near]];
    all.used[p.near] = all.say[p.near] >= beyond_doubt || 2 * lost > total;
  }
  const auto cut = [&](auto& column) {
    if (column.size() > n) column.resize(n);
  };
  cut(all.points), cut(all.group), cut(all.cosine), cut(all.relative), cut(all.sigma), cut(all.used), cut(all.at.value),
      cut(all.at.face);
  all.nodes.resize(nodes), all.jacobian.gradients.resize(nodes);
  all.jacobian.rows.conservativeResize(static_cast<Eigen::Index>(nodes), Eigen::NoChange);
  all.pairs.clear(), all.say.clear();
}

}  // namespace partscribe::fit
