/// Cuts the polygons of a file into triangles.
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

constexpr std::size_t most_ears =
    1000;  // corners; beyond it ear cutting, quadratic at best, would let a bad file stall us

double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The polygon in the plane of its mean normal, counter-clockwise; relative to its first corner, so that nothing
/// is lost far from the origin.
std::vector<Vec2> flattened(const std::vector<Vec3>& points, const std::uint32_t* corner, std::size_t count) {
  const Vec3 origin = points[corner[0]];
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < count; ++i)
    normal += (points[corner[i]] - origin).cross(points[corner[i + 1]] - origin);
  const double length = normal.norm();
  if (!(length > 0) || !std::isfinite(length)) return {};
  normal /= length;
  int smallest = 0;
  normal.cwiseAbs().minCoeff(&smallest);
  const Vec3 x = normal.cross(Vec3::Unit(smallest)).normalized(), y = normal.cross(x);
  std::vector<Vec2> flat(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p = points[corner[i]] - origin;
    flat[i] = Vec2(x.dot(p), y.dot(p));
  }
  return flat;
}

void cut_fan(const std::uint32_t* corner, std::size_t count, TriangleMesh& mesh) {
  for (std::size_t i = 1; i + 1 < count; ++i) mesh.triangles.push_back({corner[0], corner[i], corner[i + 1]});
}

void cut_polygon(const std::vector<Vec3>& points, const std::uint32_t* corner, std::size_t count, TriangleMesh& mesh) {
  if (count == 3 || count > most_ears) return cut_fan(corner, count, mesh);
  const auto flat = flattened(points, corner, count);
  bool convex = true;
  for (std::size_t i = 0; convex && i < flat.size(); ++i)
    convex = cross(flat[i], flat[(i + 1) % count], flat[(i + 2) % count]) >= 0;
  if (convex) return cut_fan(corner, count, mesh);
  std::vector<std::size_t> left(count);
  for (std::size_t i = 0; i < count; ++i) left[i] = i;
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t ear = n;
    for (std::size_t i = 0; i < n && ear == n; ++i) {
      const Vec2 &a = flat[left[(i + n - 1) % n]], &b = flat[left[i]], &c = flat[left[(i + 1) % n]];
      if (!(cross(a, b, c) > 0)) continue;
      bool empty = true;
      for (std::size_t k = 0; k < n && empty; ++k) {
        if (k == i || k == (i + 1) % n || k == (i + n - 1) % n) continue;
        const Vec2& p = flat[left[k]];
        if (p == a || p == b || p == c) continue;
        empty = !(cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0);
      }
      if (empty) ear = i;
    }
    if (ear == n) break;  // the outline crosses itself: any cut of the rest is as good as another
    mesh.triangles.push_back({corner[left[(ear + n - 1) % n]], corner[left[ear]], corner[left[(ear + 1) % n]]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i)
    mesh.triangles.push_back({corner[left[0]], corner[left[i]], corner[left[i + 1]]});
}

}  // namespace

bool FilePolygons::add_corner(std::int64_t index) {
  if (index < 0 || index >= std::numeric_limits<std::uint32_t>::max()) return false;
  corners.push_back(static_cast<std::uint32_t>(index));
  return true;
}

bool FilePolygons::add_strip(const std::vector<std::int64_t>& strip) {
  for (std::size_t i = 0; i + 2 < strip.size(); ++i) {
    const bool odd = i % 2 == 1;
    const auto a = strip[i], b = strip[i + (odd ? 2 : 1)], c = strip[i + (odd ? 1 : 2)];
    if (a == b || b == c || c == a) continue;  // strips turn corners by repeating a vertex
    if (!add_corner(a) || !add_corner(b) || !add_corner(c)) return false;
    end_face();
  }
  return true;
}

std::optional<Error> cut_faces(const FilePolygons& faces, const std::string& name, RawGeometry& raw) {
  const auto& points = raw.cloud.points;
  raw.mesh.triangles.reserve(faces.ends.size());
  std::size_t begin = 0, thin = 0;
  for (std::size_t f = 0; f < faces.ends.size(); ++f) {
    const std::size_t end = faces.ends[f];
    for (std::size_t i = begin; i < end; ++i)
      if (faces.corners[i] >= points.size())
        return bad_input(name + ", face " + std::to_string(f + 1) + ": expected a vertex index below " +
                         std::to_string(points.size()) + ", found " + std::to_string(faces.corners[i]));
    if (end - begin < 3)
      ++thin;
    else
      cut_polygon(points, faces.corners.data() + begin, end - begin, raw.mesh);
    begin = end;
  }
  if (thin) raw.warnings.push_back(name + ": " + std::to_string(thin) + " faces with fewer than 3 corners left out");
  if (!raw.mesh.triangles.empty()) raw.mesh.vertices = points;
  return {};
}

}  // namespace partscribe::geometry::formats
