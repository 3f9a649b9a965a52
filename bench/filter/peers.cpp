#include "bench/filter/peers.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/kd_tree.h"

namespace partscribe::filter_bench {
namespace {

/// Replaces each depth by combine(own depth, depths and offsets of the 5x5 window).
template <class Combine>
Filtered windowed(const RangeImage& image, const Combine& combine) {
  Filtered in = raw(image), out = in;
  struct Sample {
    double depth;
    int sq_offset;
  };
  std::vector<Sample> samples;
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c) {
      const auto i = static_cast<std::size_t>(r * image.width + c);
      if (!in.kept[i]) continue;
      samples.clear();
      for (int y = std::max(r - 2, 0); y <= std::min(r + 2, image.height - 1); ++y)
        for (int x = std::max(c - 2, 0); x <= std::min(c + 2, image.width - 1); ++x)
          if (const auto k = static_cast<std::size_t>(y * image.width + x); in.kept[k])
            samples.push_back({in.points[k].z(), (y - r) * (y - r) + (x - c) * (x - c)});
      const double depth = combine(in.points[i].z(), samples);
      if (image.projection == Projection::pinhole)
        out.points[i] *= depth / in.points[i].z();
      else
        out.points[i].z() = depth;
    }
  return out;
}

}  // namespace

Filtered raw(const RangeImage& image) {
  Filtered out;
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c) {
      const auto p = view_point(image, r, c);
      out.points.push_back(p.value_or(Vec3::Zero()));
      out.kept.push_back(p.has_value());
    }
  return out;
}

Filtered median_filter(const RangeImage& image) {
  std::vector<double> depths;
  return windowed(image, [&](double, const auto& samples) {
    depths.clear();
    for (const auto& s : samples) depths.push_back(s.depth);
    std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
    return depths[depths.size() / 2];
  });
}

Filtered bilateral_filter(const RangeImage& image, double sigma) {
  return windowed(image, [&](double own, const auto& samples) {
    double sum = 0, weight = 0;
    for (const auto& s : samples) {
      const double off = (s.depth - own) / (3 * sigma);
      const double w = std::exp(-s.sq_offset / 8.0 - 0.5 * off * off);
      sum += w * s.depth, weight += w;
    }
    return sum / weight;
  });
}

Filtered statistical_removal(const RangeImage& image) {
  Filtered out = raw(image);
  std::vector<Vec3> points;
  std::vector<std::size_t> source;
  for (std::size_t i = 0; i < out.points.size(); ++i)
    if (out.kept[i]) points.push_back(out.points[i]), source.push_back(i);
  if (points.size() < 21) return out;
  const KdTree tree(points);
  std::vector<double> means;
  std::vector<Neighbour> near;
  double sum = 0, squares = 0;
  for (const Vec3& p : points) {
    tree.nearest(p, 21, near);
    double mean = 0;
    for (const Neighbour& n : near) mean += std::sqrt(n.sq_distance) / 20;
    means.push_back(mean);
    sum += mean, squares += mean * mean;
  }
  const double n = static_cast<double>(means.size()), mean = sum / n;
  const double limit = mean + 0.2 * std::sqrt(std::max(squares / n - mean * mean, 0.0));
  for (std::size_t k = 0; k < means.size(); ++k) out.kept[source[k]] = means[k] <= limit;
  return out;
}

Filtered removal_and_mls(const RangeImage& image) {
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  constexpr double radius = 1.6;
  Filtered out = statistical_removal(image);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < out.points.size(); ++i)
    if (out.kept[i]) points.push_back(out.points[i]);
  if (points.empty()) return out;
  const KdTree tree(points);
  std::vector<Neighbour> near;
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    if (!out.kept[i]) continue;
    const Vec3 p = out.points[i];
    tree.nearest(p, 64, near);
    std::erase_if(near, [&](const Neighbour& n) { return n.sq_distance > radius * radius; });
    if (near.size() < 6) continue;
    Vec3 mean = Vec3::Zero();
    for (const Neighbour& n : near) mean += points[n.index] / static_cast<double>(near.size());
    Mat3 cov = Mat3::Zero();
    for (const Neighbour& n : near) cov += (points[n.index] - mean) * (points[n.index] - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cov);
    const Vec3 normal = eigen.eigenvectors().col(0), u = eigen.eigenvectors().col(1), v = eigen.eigenvectors().col(2);
    const Vec3 foot = p - normal.dot(p - mean) * normal;
    Mat6 a = Mat6::Zero();
    Vec6 b = Vec6::Zero();
    for (const Neighbour& n : near) {
      const Vec3 d = points[n.index] - foot;
      const double x = u.dot(d), y = v.dot(d), w = std::exp(-n.sq_distance / (radius * radius));
      const Vec6 row = (Vec6() << 1, x, y, x * x, x * y, y * y).finished();
      a += w * row * row.transpose();
      b += w * normal.dot(d) * row;
    }
    const Vec6 x = a.ldlt().solve(b);
    if (x.allFinite()) out.points[i] = foot + x[0] * normal;
  }
  return out;
}

}  // namespace partscribe::filter_bench
