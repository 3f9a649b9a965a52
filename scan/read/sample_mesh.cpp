/// Spreads samples evenly over the large triangles of a mesh whose vertices do not stand for its surface.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scan/read/read.h"

namespace partscribe::scan {
namespace {

double longest_edge(const TriangleMesh& mesh, std::size_t t) {
  double longest = 0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm());
  return longest;
}

double area_of(const TriangleMesh& mesh, std::size_t t) {
  return 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
}

}  // namespace

SurfaceSamples sample_coarse_mesh(const TriangleMesh& mesh) {
  SurfaceSamples samples;
  const double diagonal = mesh.bounds().diagonal(), spacing = diagonal / 250;
  double coarse = 0, total = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = area_of(mesh, t);
    total += a;
    if (longest_edge(mesh, t) > diagonal / 50) coarse += a;
  }
  if (!(coarse > 0.2 * total)) return samples;
  double due = 0.5;  // carried from triangle to triangle, so that slivers get their share together
  // The R2 sequence (Roberts 2018): its steps come from the plastic number and fill a square evenly.
  constexpr double step_u = 0.7548776662466927, step_v = 0.5698402909980532;
  std::uint64_t index = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!(longest_edge(mesh, t) > 2 * spacing)) continue;
    const Vec3 normal = triangle_normal(mesh, t);
    due += area_of(mesh, t) / (spacing * spacing);
    for (; due >= 1; due -= 1) {
      ++index;
      double u = std::fmod(0.5 + step_u * static_cast<double>(index), 1.0);
      double v = std::fmod(0.5 + step_v * static_cast<double>(index), 1.0);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 a = mesh.corner(t, 0);
      samples.points.push_back(a + u * (mesh.corner(t, 1) - a) + v * (mesh.corner(t, 2) - a));
      samples.normals.push_back(normal);
    }
  }
  return samples;
}

}  // namespace partscribe::scan
