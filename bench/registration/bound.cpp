#include "bound.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace partscribe::testing {
namespace {

constexpr double same_normal = 0.966;  // 15 degrees
constexpr std::size_t places = 4000;   // of each view

/// One view's part in a place.
struct Share {
  std::size_t view;
  Vec3 normal;    // in the world
  double weight;  // points per mm^2 over the variance of one, 1/mm^4
};

/// mm^2 of surface for every point.
double area_of(const ViewSurface& surface, std::size_t point) {
  const SightRaster& raster = surface.raster;
  const double z = raster.pinhole ? raster.project(surface.points[point]).z() : 1;
  return z * z / std::abs(raster.fx * raster.fy) / std::max(surface.cosine[point], 0.1);
}

/// Adds `factor` times the information of one place, with normals as given.
void add(const std::vector<Share>& shares, const std::vector<Vec3>& normals, const Vec3& arm, double size,
         double factor, Eigen::MatrixXd& h) {
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  std::vector<Vec6> rows(shares.size());
  double all = 0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    rows[k] << arm.cross(normals[k]) / size, normals[k];
    all += shares[k].weight;
  }
  for (std::size_t k = 0; k < shares.size(); ++k)
    for (std::size_t l = 0; l < shares.size(); ++l) {
      const double weight = (k == l ? shares[k].weight : 0) - shares[k].weight * shares[l].weight / all;
      h.block<6, 6>(6 * Eigen::Index(shares[k].view), 6 * Eigen::Index(shares[l].view)) +=
          factor * weight * rows[k] * rows[l].transpose();
    }
}

}  // namespace

Eigen::MatrixXd pose_bound(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& world_from_view,
                           const Vec3& center, double size, const Eigen::MatrixXd& free) {
  const auto unknowns = 6 * Eigen::Index(surfaces.size());
  std::vector<Pose> view_from_world;
  for (const Pose& pose : world_from_view) view_from_world.push_back(pose.inverse());
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (std::size_t v = 0; v < surfaces.size(); ++v) {
    const ViewSurface& own = surfaces[v];
    const std::size_t stride = std::max<std::size_t>(1, own.points.size() / places);
    for (std::size_t i = stride / 2; i < own.points.size(); i += stride) {
      const Vec3 p = world_from_view[v] * own.points[i], n = world_from_view[v].rotation * own.normals[i];
      std::vector<Share> shares;
      Vec3 mean = Vec3::Zero();
      for (std::size_t u = 0; u < surfaces.size(); ++u) {
        if (!surfaces[u].usable()) continue;
        const Neighbour near = surfaces[u].nearest(view_from_world[u] * p);
        const Vec3 normal = world_from_view[u].rotation * surfaces[u].normals[near.index];
        if (near.sq_distance > surfaces[u].spacing * surfaces[u].spacing || normal.dot(n) < same_normal) continue;
        shares.push_back({u, normal, 1 / area_of(surfaces[u], near.index) / std::pow(surfaces[u].sigma, 2)});
        mean += normal;
      }
      const double views = double(shares.size());
      if (shares.size() < 2) continue;
      // Each place comes from every view that sees it. What noise of the mean normal pretends is taken off again.
      const double area = area_of(own, i) * double(stride) / views;
      add(shares, std::vector<Vec3>(shares.size(), mean.normalized()), p - center, size, area, h);
      const Vec3 noise = 0.5 * (shares[0].normal - shares[1].normal);
      add(shares, std::vector<Vec3>(shares.size(), noise), p - center, size, -area * 2 / views, h);
    }
  }
  // What is not to be known: no error, and no information, along it.
  Eigen::MatrixXd not_known(unknowns, 6 + free.cols());
  for (std::size_t v = 0; v < surfaces.size(); ++v) not_known.block<6, 6>(6 * Eigen::Index(v), 0).setIdentity();
  not_known.rightCols(free.cols()) = free;
  const Eigen::MatrixXd known = Eigen::MatrixXd::Identity(unknowns, unknowns) -
                                not_known * not_known.completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(known * h * known);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (Eigen::Index k = 0; k < unknowns; ++k)
    if (eigen.eigenvalues()[k] > 1e-9 * eigen.eigenvalues()[unknowns - 1])
      covariance += eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).transpose() / eigen.eigenvalues()[k];
  return covariance;
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / double(std::max<std::size_t>(values.size(), 1)));
}

}  // namespace partscribe::testing
