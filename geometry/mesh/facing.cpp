#include "geometry/mesh/facing.h"

#include <Eigen/Geometry>
#include <vector>

namespace partscribe::geometry {

Facing facing(const TriangleMesh& mesh, double least_cosine) {
  std::vector<Vec3> normals;
  std::vector<double> areas;
  Vec3 mean = Vec3::Zero();
  double all = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 twice = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    normals.push_back(triangle_normal(mesh, t));
    areas.push_back(twice.norm());
    mean += twice, all += areas.back();
  }
  if (!(mean.norm() > 0)) return {};
  mean.normalize();
  Vec3 center = mean;
  for (int step = 1; step <= 300; ++step) {
    std::size_t worst = 0;
    for (std::size_t t = 1; t < normals.size(); ++t)
      if (normals[t].dot(center) < normals[worst].dot(center)) worst = t;
    center += (normals[worst] - center) / (step + 1);
  }
  // On sheets that turn away somewhere the mean may serve better than the middle of the extremes.
  const auto share = [&](const Vec3& direction) {
    double away = 0;
    for (std::size_t t = 0; t < normals.size(); ++t)
      if (normals[t].dot(direction) < least_cosine) away += areas[t];
    return away / all;
  };
  Facing result{mean, share(mean)};
  if (!(center.norm() > 0)) return result;
  center.normalize();
  if (const double away = share(center); away <= result.turned_away) result = {center, away};
  return result;
}

}  // namespace partscribe::geometry
