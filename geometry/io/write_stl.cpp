/// Writes a mesh as binary STL.
#include <cstring>

#include "core/ensure.h"
#include "geometry/io/read_geometry.h"

namespace partscribe::geometry {

std::string write_stl(const TriangleMesh& mesh) {
  ensure(mesh.triangles.size() < 0xFFFFFFFFu, "a binary STL file holds fewer than 2^32 triangles");
  std::string out(80, ' ');
  const std::string_view title = "binary STL, millimetres";  // must not begin with "solid"
  out.replace(0, title.size(), title);
  const auto put = [&](const void* from, std::size_t size) { out.append(static_cast<const char*>(from), size); };
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  out.reserve(84 + 50 * mesh.triangles.size());
  put(&count, 4);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n = triangle_normal(mesh, t);
    float values[12];
    for (int k = 0; k < 3; ++k) {
      values[k] = static_cast<float>(n[k]);
      for (int c = 0; c < 3; ++c) values[3 + 3 * c + k] = static_cast<float>(mesh.corner(t, c)[k]);
    }
    put(values, sizeof values);
    const std::uint16_t attribute = 0;
    put(&attribute, 2);
  }
  return out;
}

}  // namespace partscribe::geometry
