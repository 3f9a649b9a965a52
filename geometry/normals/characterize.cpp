#include "geometry/normals/characterize.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "core/parallel.h"
#include "geometry/decompose.h"

namespace partscribe::geometry {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr double welsch = 2.5;  // deviations; a robust weight is exp(-u^2 / 2 c^2)

/// The nodes reachable from one by links within a ball, the node itself first.
class Neighbourhoods {
 public:
  Neighbourhoods(const SurfaceGraph& graph, double radius)
      : graph_(graph), sq_radius_(radius * radius), seen_(graph.size(), 0) {}

  const std::vector<std::uint32_t>& of(std::uint32_t node) {
    ++round_;
    found_.assign(1, node);
    seen_[node] = round_;
    for (std::size_t k = 0; k < found_.size(); ++k)
      for (const std::uint32_t j : graph_.around(found_[k])) {
        if (seen_[j] == round_) continue;
        seen_[j] = round_;
        if ((graph_.points[j] - graph_.points[node]).squaredNorm() <= sq_radius_) found_.push_back(j);
      }
    return found_;
  }

 private:
  const SurfaceGraph& graph_;
  double sq_radius_;
  std::uint32_t round_ = 0;
  std::vector<std::uint32_t> seen_, found_;
};

/// z = x0 + x1 u + x2 v + x3 u^2 + x4 uv + x5 v^2 in a frame whose z is `normal`, lengths in radii.
struct Quadric {
  Mat3 frame;  ///< columns u, v, normal
  Vec6 x = Vec6::Zero();
  Mat6 covariance = Mat6::Zero();
  bool good = false;
};

Mat3 frame_of(const Vec3& normal) { return rotation_onto_axis(normal); }

Quadric quadric_of(const SurfaceGraph& graph, const std::vector<std::uint32_t>& nodes, const Vec3& normal,
                   double radius) {
  Quadric q;
  q.frame = frame_of(normal);
  const Vec3& origin = graph.points[nodes.front()];
  std::vector<double> residuals(nodes.size(), 0);
  for (int round = 0; round < 3; ++round) {
    Mat6 a = Mat6::Zero();
    Vec6 b = Vec6::Zero();
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const Vec3 p = q.frame.transpose() * (graph.points[nodes[k]] - origin) / radius;
      const double sigma = std::max(graph.sigma[nodes[k]] / radius, 1e-9);
      const Vec6 row = (Vec6() << 1, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y()).finished();
      if (round > 0) residuals[k] = (p.z() - row.dot(q.x)) / sigma;
      const double w = std::exp(-0.5 * residuals[k] * residuals[k] / (welsch * welsch)) / (sigma * sigma);
      a.selfadjointView<Eigen::Lower>().rankUpdate(row, w);
      b += w * p.z() * row;
    }
    const Eigen::LDLT<Mat6> solver(a);
    const auto pivots = solver.vectorD();
    if (solver.info() != Eigen::Success || !(pivots.minCoeff() > 1e-6 * pivots.maxCoeff())) return q;
    q.x = solver.solve(b);
    if (round == 2) q.covariance = solver.solve(Mat6::Identity());
  }
  q.good = q.x.allFinite();
  return q;
}

int sign_of(double value, double sigma) { return std::abs(value) > 3 * sigma ? (value > 0 ? 1 : -1) : 0; }

CharacterizedPoint point_of(const SurfaceGraph& graph, const std::vector<std::uint32_t>& nodes, double radius) {
  CharacterizedPoint p;
  p.normal = graph.normals[nodes.front()];
  p.neighbours = static_cast<int>(nodes.size());
  Quadric q;
  for (int turn = 0; turn < 2; ++turn) {  // the second time in the tangent frame, where slopes are next to nothing
    q = quadric_of(graph, nodes, p.normal, radius);
    if (!q.good) return p;
    p.normal = q.frame * Vec3(-q.x[1], -q.x[2], 1).normalized();
  }
  // K = m^T Q m of m = (xx, xy, yy): its noise has a quadratic part, which is all there is on a plane.
  const Vec3 m = q.x.tail<3>();
  const Mat3 C = q.covariance.bottomRightCorner<3, 3>();
  Mat3 Q = Mat3::Zero();
  Q(0, 2) = Q(2, 0) = 2, Q(1, 1) = -1;
  const Mat3 QC = Q * C;
  const double bias = QC.trace(), variance = 4 * (Q * m).dot(C * (Q * m)) + 2 * (QC * QC).trace();
  p.gaussian = (m.dot(Q * m) - bias) / (radius * radius);
  p.sigma_gaussian = std::sqrt(std::max(variance, 0.0)) / (radius * radius);
  p.mean = (m[0] + m[2]) / radius;
  p.sigma_mean = std::sqrt(std::max(C(0, 0) + 2 * C(0, 2) + C(2, 2), 0.0)) / radius;
  Eigen::Matrix2d bend;
  bend << 2 * m[0], m[1], m[1], 2 * m[2];
  const auto eigen = eigensystem<2>(bend / radius);
  p.least = eigen.values[0], p.most = eigen.values[1];
  p.along_least = q.frame.leftCols<2>() * eigen.vectors.col(0);
  p.kind = class_of_signs(sign_of(p.mean, p.sigma_mean), sign_of(p.gaussian, p.sigma_gaussian));
  return p;
}

}  // namespace

SurfaceClass class_of_signs(int mean, int gaussian) {
  if (mean < 0)
    return gaussian > 0 ? SurfaceClass::peak : gaussian < 0 ? SurfaceClass::saddle_ridge : SurfaceClass::ridge;
  if (mean > 0)
    return gaussian > 0 ? SurfaceClass::pit : gaussian < 0 ? SurfaceClass::saddle_valley : SurfaceClass::valley;
  return gaussian < 0 ? SurfaceClass::minimal : SurfaceClass::flat;
}

std::vector<CharacterizedPoint> characterize(const SurfaceGraph& graph, const CharacterizeOptions& options,
                                             Context& context) {
  std::vector<CharacterizedPoint> result(graph.size());
  const double radius = options.radius > 0 ? options.radius : 5.5 * graph.spacing;
  if (!(radius > 0)) return result;
  parallel_for(
      graph.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        Neighbourhoods neighbourhoods(graph, radius);
        for (std::size_t i = begin; i < end; ++i) {
          if (!graph.usable[i]) continue;
          const auto& nodes = neighbourhoods.of(static_cast<std::uint32_t>(i));
          result[i].normal = graph.normals[i];
          result[i].neighbours = static_cast<int>(nodes.size());
          if (result[i].neighbours >= options.least_neighbours) result[i] = point_of(graph, nodes, radius);
        }
      },
      16384);
  return result;
}

}  // namespace partscribe::geometry
