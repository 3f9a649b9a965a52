/// Writes clouds and meshes as binary little-endian PLY with double coordinates.
#include <cstring>

#include "core/ensure.h"
#include "geometry/io/read_geometry.h"

namespace partscribe::geometry {
namespace {

template <class T>
void put(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

void put(std::string& out, const Vec3& p) {
  for (int k = 0; k < 3; ++k) put<double>(out, p[k]);
}

}  // namespace

std::string write_cloud_ply(const PointCloud& cloud) {
  const auto has = [&](const auto& column, const char* what) {
    ensure(column.empty() || column.size() == cloud.size(), what);
    return !column.empty();
  };
  const bool normals = has(cloud.normals, "one normal per point"), rays = has(cloud.rays, "one ray per point");
  const bool sigma = has(cloud.sigma, "one sigma per point"), view = has(cloud.view, "one view per point");
  const bool pixel = has(cloud.pixel, "one pixel per point"), rejected = has(cloud.rejected, "one flag per point");
  std::string out = "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex " +
                    std::to_string(cloud.size()) + "\n";
  const auto property = [&](const char* type, std::initializer_list<const char*> names) {
    for (const auto* name : names) out += std::string("property ") + type + " " + name + "\n";
  };
  property("double", {"x", "y", "z"});
  if (normals) property("double", {"nx", "ny", "nz"});
  if (rays) property("double", {"ray_x", "ray_y", "ray_z"});
  if (sigma) property("float", {"sigma"});
  if (view) property("int", {"view"});
  if (pixel) property("int", {"pixel"});
  if (rejected) property("uchar", {"rejected"});
  out += "end_header\n";
  out.reserve(out.size() +
              cloud.size() * (24u + 24u * normals + 24u * rays + 4u * sigma + 4u * view + 4u * pixel + rejected));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    put(out, cloud.points[i]);
    if (normals) put(out, cloud.normals[i]);
    if (rays) put(out, cloud.rays[i]);
    if (sigma) put(out, cloud.sigma[i]);
    if (view) put(out, cloud.view[i]);
    if (pixel) put(out, cloud.pixel[i]);
    if (rejected) put(out, cloud.rejected[i]);
  }
  return out;
}

std::string write_mesh_ply(const TriangleMesh& mesh) {
  std::string out = "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex " +
                    std::to_string(mesh.vertices.size()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                    std::to_string(mesh.triangles.size()) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  out.reserve(out.size() + mesh.vertices.size() * 24 + mesh.triangles.size() * 13);
  for (const auto& v : mesh.vertices) put(out, v);
  for (const auto& t : mesh.triangles) {
    put<std::uint8_t>(out, 3);
    for (const auto corner : t) put(out, corner);
  }
  return out;
}

}  // namespace partscribe::geometry
