#include "geometry/images/region_growing.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/ensure.h"
#include "geometry/decompose.h"

namespace partscribe::geometry {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr int most_rounds = 14;

Vec6 terms(const Vec3& local, int order) {
  const double u = local.x(), v = local.y();
  if (order == 1) return (Vec6() << 1, u, v, 0, 0, 0).finished();
  return (Vec6() << 1, u, v, u * u, u * v, v * v).finished();
}

/// One patch while it grows.
class Growth {
 public:
  Growth(const SurfaceGraph& graph, const std::vector<CharacterizedPoint>& points, const std::vector<int>& label,
         const PatchOptions& options, std::uint32_t seed)
      : graph_(graph), points_(points), label_(label), options_(options), seed_(seed) {
    patch_.origin = graph.points[seed];
    patch_.axes = rotation_onto_axis(points[seed].normal);
    nodes_ = first_ring();
  }

  /// Refits and floods in turn until nothing changes.
  void grow(int order) {
    patch_.order = order;
    for (int round = 0; round < most_rounds; ++round) {
      if (!fit()) return nodes_.clear();
      const std::size_t before = nodes_.size();
      flood();
      const auto change = before > nodes_.size() ? before - nodes_.size() : nodes_.size() - before;
      if (round > 1 && change * 100 <= nodes_.size()) break;
    }
    finish();
  }

  const std::vector<std::uint32_t>& nodes() const { return nodes_; }
  const SurfacePatch& patch() const { return patch_; }

 private:
  bool free(std::uint32_t i) const { return graph_.usable[i] && label_[i] < 0; }

  /// The 40 nearest by links, enough for a first fit.
  std::vector<std::uint32_t> first_ring() const {
    std::vector<std::uint32_t> found = {seed_};
    std::vector<std::uint32_t> sorted = found;
    for (std::size_t k = 0; k < found.size() && found.size() < 40; ++k)
      for (const std::uint32_t j : graph_.around(found[k])) {
        const auto at = std::lower_bound(sorted.begin(), sorted.end(), j);
        if (!free(j) || (at != sorted.end() && *at == j)) continue;
        sorted.insert(at, j), found.push_back(j);
      }
    return found;
  }

  bool fit() {
    const auto count = static_cast<std::size_t>(patch_.order == 1 ? 3 : 6);
    if (nodes_.size() < 2 * count) return false;
    double scale = 0;
    for (const std::uint32_t i : nodes_) scale = std::max(scale, (graph_.points[i] - patch_.origin).norm());
    if (!(scale > 0)) return false;
    Mat6 a = Mat6::Zero();
    Vec6 b = Vec6::Zero();
    for (const std::uint32_t i : nodes_) {
      const Vec3 p = patch_.axes.transpose() * (graph_.points[i] - patch_.origin) / scale;
      const double sigma = std::max(graph_.sigma[i] / scale, 1e-9);
      const Vec6 row = terms(p, patch_.order);
      a += row * row.transpose() / (sigma * sigma);
      b += row * p.z() / (sigma * sigma);
    }
    const double weight = a(0, 0);
    if (patch_.order == 1) a.bottomRightCorner<3, 3>() = weight * Mat3::Identity();
    const Vec6 x = solve_ldlt(Mat6(a + 1e-12 * weight * Mat6::Identity()), b);
    if (!x.allFinite()) return false;
    const double powers[6] = {scale, 1, 1, 1 / scale, 1 / scale, 1 / scale};
    for (int k = 0; k < 6; ++k) patch_.coefficients[k] = x[k] * powers[k];
    return true;
  }

  bool fits(std::uint32_t i) const {
    const Vec3 normal = patch_.normal(graph_.points[i]);
    const double across = normal.dot(patch_.axes.col(2));  // a height counts along the normal
    if (std::abs(patch_.height(graph_.points[i]) * across) > options_.max_deviations * graph_.sigma[i]) return false;
    const double noise = graph_.spacing > 0 ? 1.5 * graph_.sigma[i] / graph_.spacing : 0;
    const double turn = std::min(options_.max_angle + noise, 1.2);
    return normal.dot(graph_.normals[i]) > std::cos(turn);
  }

  void flood() {
    std::vector<std::uint8_t> seen(graph_.size(), 0);
    std::vector<std::uint32_t> found = {seed_};
    seen[seed_] = 1;
    for (std::size_t k = 0; k < found.size(); ++k)
      for (const std::uint32_t j : graph_.around(found[k])) {
        if (seen[j] || !free(j)) continue;
        seen[j] = 1;
        if (fits(j)) found.push_back(j);
      }
    nodes_ = std::move(found);
  }

  void finish() {
    double sum = 0;
    for (const std::uint32_t i : nodes_) {
      const double across = patch_.normal(graph_.points[i]).dot(patch_.axes.col(2));
      const double u = patch_.height(graph_.points[i]) * across / std::max(graph_.sigma[i], 1e-12);
      sum += u * u;
    }
    patch_.points = nodes_.size();
    patch_.rms = nodes_.empty() ? 0 : std::sqrt(sum / static_cast<double>(nodes_.size()));
  }

  const SurfaceGraph& graph_;
  const std::vector<CharacterizedPoint>& points_;
  const std::vector<int>& label_;
  const PatchOptions& options_;
  std::uint32_t seed_;
  SurfacePatch patch_;
  std::vector<std::uint32_t> nodes_;
};

/// Best first: whole neighbourhoods, then little curvature; ties by index.
std::vector<std::uint32_t> seeds(const SurfaceGraph& graph, const std::vector<CharacterizedPoint>& points) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    if (graph.usable[i] && points[i].kind != SurfaceClass::unknown) order.push_back(i);
  const auto bend = [&](std::uint32_t i) { return std::max(std::abs(points[i].least), std::abs(points[i].most)); };
  int most = 0;
  for (const std::uint32_t i : order) most = std::max(most, points[i].neighbours);
  const auto whole = [&](std::uint32_t i) { return points[i].neighbours * 5 >= most * 3; };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (whole(a) != whole(b)) return whole(a);
    return bend(a) != bend(b) ? bend(a) < bend(b) : a < b;
  });
  return order;
}

}  // namespace

double SurfacePatch::height(const Vec3& point) const {
  const Vec3 p = axes.transpose() * (point - origin);
  const Vec6 row = terms(p, order);
  double z = p.z();
  for (int k = 0; k < 6; ++k) z -= coefficients[k] * row[k];
  return z;
}

Vec3 SurfacePatch::normal(const Vec3& point) const {
  const Vec3 p = axes.transpose() * (point - origin);
  const double* x = coefficients;
  const double du = x[1] + (order == 1 ? 0 : 2 * x[3] * p.x() + x[4] * p.y());
  const double dv = x[2] + (order == 1 ? 0 : x[4] * p.x() + 2 * x[5] * p.y());
  return axes * Vec3(-du, -dv, 1).normalized();
}

Patches grow_patches(const SurfaceGraph& graph, const std::vector<CharacterizedPoint>& points,
                     const PatchOptions& options, Context& context) {
  ensure(points.size() == graph.size(), "every node has been characterized");
  Patches result;
  result.label.assign(graph.size(), -1);
  std::vector<std::uint8_t> tried(graph.size(), 0);
  for (const std::uint32_t seed : seeds(graph, points)) {
    if (context.cancelled) break;
    if (tried[seed] || result.label[seed] >= 0) continue;
    Growth best(graph, points, result.label, options, seed);
    best.grow(1);
    Growth bent(graph, points, result.label, options, seed);
    bent.grow(2);
    // Three more terms have to pay: a plane that a quadric hardly outgrows stays a plane.
    const bool pays = bent.nodes().size() > best.nodes().size() + best.nodes().size() / 8 + 10;
    const Growth& winner = pays ? bent : best;
    for (const std::uint32_t i : winner.nodes()) tried[i] = 1;
    tried[seed] = 1;
    if (winner.nodes().size() < options.least_points) continue;
    for (const std::uint32_t i : winner.nodes()) result.label[i] = static_cast<int>(result.patches.size());
    result.patches.push_back(winner.patch());
  }
  return result;
}

PatchCounts most_patches(const std::vector<int>& label, int width, int height, int least_run) {
  ensure(label.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height), "one label per pixel");
  const auto stretches = [&](std::size_t start, std::size_t step, int count) {
    int found = 0, run = 0, current = -1, last = -1;
    for (int k = 0; k < count; ++k) {
      const int here = label[start + static_cast<std::size_t>(k) * step];
      if (here < 0) continue;  // unlabelled pixels between two stretches of one patch do not part them
      run = here == current ? run + 1 : 1;
      current = here;
      if (run >= least_run && current != last) ++found, last = current;
    }
    return found;
  };
  PatchCounts most;
  const auto w = static_cast<std::size_t>(width);
  for (int r = 0; r < height; ++r)
    most.along_row = std::max(most.along_row, stretches(static_cast<std::size_t>(r) * w, 1, width));
  for (int c = 0; c < width; ++c)
    most.along_column = std::max(most.along_column, stretches(static_cast<std::size_t>(c), w, height));
  return most;
}

}  // namespace partscribe::geometry
