#include "scan/register/as_published/reference_points.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/mesh/plane_delaunay.h"

namespace partscribe::scan {
namespace {

/// Center and normal of a patch from its members; the normal points to the side of theirs.
void fit_patch_plane(const ViewSurface& surface, Patch& patch) {
  Vec3 facing = Vec3::Zero();
  for (const auto i : patch.members)
    patch.center += surface.points[i] / static_cast<double>(patch.members.size()), facing += surface.normals[i];
  Mat3 spread = Mat3::Zero();
  for (const auto i : patch.members) {
    const Vec3 d = surface.points[i] - patch.center;
    spread += d * d.transpose();
  }
  patch.normal = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(0);
  if (patch.normal.dot(facing) < 0) patch.normal = -patch.normal;
}

}  // namespace

std::vector<Patch> planar_patches(const ViewSurface& surface, const PaperOptions& options) {
  const double most_radius = options.patch_radius * surface.radius, bend = std::cos(options.patch_angle);
  const double reach = 2.3 * surface.spacing;  // to the next return of a slanted face
  std::vector<std::uint8_t> taken(surface.points.size(), 0);
  const auto least = static_cast<std::size_t>(
      std::max(12.0, 0.1 * 3 * most_radius * most_radius / (surface.spacing * surface.spacing)));
  std::vector<Patch> patches;
  std::vector<Neighbour> near;
  std::vector<std::uint32_t> pending;
  for (std::uint32_t seed = 0; seed < surface.points.size(); ++seed) {
    if (taken[seed] || !surface.smooth[seed]) continue;
    Patch patch;
    pending.assign(1, seed);
    taken[seed] = 1;
    while (!pending.empty()) {
      const auto i = pending.back();
      pending.pop_back();
      patch.members.push_back(i);
      surface.tree->within(surface.points[i], reach, near);
      for (const Neighbour& n : near) {
        if (taken[n.index] || !surface.smooth[n.index]) continue;
        if (surface.normals[n.index].dot(surface.normals[seed]) < bend) continue;
        if ((surface.points[n.index] - surface.points[seed]).norm() > most_radius) continue;
        taken[n.index] = 1;
        pending.push_back(n.index);
      }
    }
    std::sort(patch.members.begin(), patch.members.end());
    if (patch.members.size() < least) continue;
    fit_patch_plane(surface, patch);
    patches.push_back(std::move(patch));
  }
  std::stable_sort(patches.begin(), patches.end(),
                   [](const Patch& a, const Patch& b) { return a.members.size() > b.members.size(); });
  return patches;
}

TriangleMesh triangulated_view(const ViewSurface& surface, double cell) {
  constexpr double most_bend = 0.8;  // cosine between a triangle and its corners: creases and steps are steeper
  struct NearestToMiddle {
    double sq_distance;
    std::uint32_t point;
  };
  std::map<std::pair<long, long>, NearestToMiddle> cells;  // of the image, each with the point nearest to its middle
  std::vector<Vec2> picture(surface.points.size());
  for (std::uint32_t i = 0; i < surface.points.size(); ++i) {
    if (!surface.smooth[i]) continue;
    picture[i] = surface.raster.project(surface.points[i]).head<2>();
    const Vec2 scaled = picture[i] / cell;
    const long column = static_cast<long>(std::floor(scaled.x())), row = static_cast<long>(std::floor(scaled.y()));
    const NearestToMiddle here{(scaled - Vec2(double(column) + 0.5, double(row) + 0.5)).squaredNorm(), i};
    const auto [at, is_new] = cells.try_emplace({row, column}, here);
    if (!is_new && here.sq_distance < at->second.sq_distance) at->second = here;
  }
  TriangleMesh mesh;
  std::vector<Vec2> chosen;
  std::vector<Vec3> normals;
  for (const auto& [where, nearest] : cells) {
    chosen.push_back(picture[nearest.point]);
    mesh.vertices.push_back(surface.points[nearest.point]);
    normals.push_back(surface.normals[nearest.point]);
  }
  const double longest = 2.5 * cell;  // in pixels; across what was not seen there is no surface
  for (auto t : delaunay_triangles(chosen)) {
    Vec3 normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    if (normal.norm() == 0) continue;
    normal.normalize();
    if (normal.dot(normals[t[0]]) < 0) std::swap(t[1], t[2]), normal = -normal;
    bool whole = true;
    for (int k = 0; k < 3; ++k)
      whole =
          whole && normal.dot(normals[t[k]]) > most_bend && (chosen[t[k]] - chosen[t[(k + 1) % 3]]).norm() < longest;
    if (whole) mesh.triangles.push_back(t);
  }
  return mesh;
}

TriangleMesh coarse_surface(const ViewSurface& surface, std::size_t most) {
  const auto smooth = static_cast<double>(std::count(surface.smooth.begin(), surface.smooth.end(), 1));
  // About two triangles for every cell; inner cells that creases cross have none.
  for (double cell = std::sqrt(1.5 * smooth / static_cast<double>(most + 1)) + 1;; cell *= 1.05) {
    TriangleMesh mesh = triangulated_view(surface, cell);
    if (mesh.triangles.size() <= most) return mesh;
  }
}

std::vector<ReferencePoint> reference_points(const ViewSurface& surface, const PaperOptions& options) {
  std::vector<ReferencePoint> points;
  if (options.primitives == PaperPrimitives::planar_patches) {
    for (const Patch& patch : planar_patches(surface, options)) points.push_back({patch.center, patch.normal});
    return points;
  }
  const TriangleMesh coarse = coarse_surface(surface, options.most_triangles);
  for (std::size_t t = 0; t < coarse.triangles.size(); ++t) {
    // Where the surface bends the centre of a coarse triangle lies inside it, of all of them alike: it goes back along
    // the normal.
    const Vec3 center = (coarse.corner(t, 0) + coarse.corner(t, 1) + coarse.corner(t, 2)) / 3;
    const std::uint32_t near = surface.nearest(center).index;
    const Vec3& normal = surface.normals[near];
    points.push_back({center + normal.dot(surface.points[near] - center) * normal, normal});
  }
  return points;
}

}  // namespace partscribe::scan
