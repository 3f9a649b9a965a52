#include "cli/paper/lit_pictures.h"

#include <algorithm>
#include <array>
#include <set>
#include <vector>

namespace partscribe::cli {
namespace {

constexpr int finer = 2;  // pictures are drawn so many times as large and reduced

std::vector<Vec3> corners_of(const Box3& box) {
  std::vector<Vec3> result;
  for (int k = 0; k < 8; ++k)
    result.push_back(
        {k & 1 ? box.high.x() : box.low.x(), k & 2 ? box.high.y() : box.low.y(), k & 4 ? box.high.z() : box.low.z()});
  return result;
}

}  // namespace

Raster lit_surface(const scan::Surface& surface, const Vec3& to_eye, const Vec3& up, int side) {
  Raster raster(finer * side, finer * side, {255, 255, 255});
  const Camera camera = camera_for(corners_of(surface.bounds), to_eye, up, raster.width, raster.height);
  const Vec3 right = camera.view_from_world.row(0), above = camera.view_from_world.row(1),
             towards = camera.view_from_world.row(2);
  const double back = surface.bounds.size().norm();
  for (int row = 0; row < raster.height; ++row)
    for (int column = 0; column < raster.width; ++column) {
      const double x = (column + 0.5 - 0.5 * raster.width) / camera.pixels_per_mm;
      const double y = (0.5 * raster.height - row - 0.5) / camera.pixels_per_mm;
      const auto hit = surface.first_hit(camera.center + x * right + y * above + back * towards, -towards);
      if (!hit) continue;
      raster.pixels[std::size_t(row) * std::size_t(raster.width) + std::size_t(column)] =
          shaded({176, 190, 210}, camera, hit->normal);
    }
  return reduced(raster, finer);
}

Raster lit_mesh(const TriangleMesh& mesh, const Vec3& to_eye, const Vec3& up, int side, bool edges, Color color) {
  Raster raster(finer * side, finer * side, {255, 255, 255});
  const Camera camera = camera_for(mesh.vertices, to_eye, up, raster.width, raster.height);
  draw_triangles(raster, camera, mesh.vertices, mesh.triangles, [&](std::uint32_t t, const Vec3&, int, int) {
    return shaded(color, camera, triangle_normal(mesh, t));
  });
  if (edges) {
    std::set<std::array<std::uint32_t, 2>> lines;
    for (const auto& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) lines.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    draw_lines(raster, camera, mesh.vertices, {lines.begin(), lines.end()}, 1.3, {40, 52, 74});
  }
  return reduced(raster, finer);
}

}  // namespace partscribe::cli
