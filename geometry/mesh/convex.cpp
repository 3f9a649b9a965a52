#include "geometry/mesh/convex.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace partscribe::geometry {

std::optional<ConvexPolyhedron> convex_polyhedron(const std::vector<Plane3>& planes) {
  // Cut a huge cube by every plane in turn; the part is unbounded if a face of the cube survives.
  double extent = 1;
  for (const auto& p : planes) extent = std::max(extent, std::abs(p.offset));
  // Far enough that only unbounded bodies reach it, near enough that no digits are lost.
  const double far = 1e4 * extent;
  const double same = 1e-9 * extent;
  struct Face {
    int plane;
    std::vector<Vec3> loop;
  };
  std::vector<Face> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = -1; side <= 1; side += 2) {
      const Vec3 n = Vec3::Unit(axis) * side;
      const Vec3 u = Vec3::Unit((axis + 1) % 3), v = n.cross(u);
      Face f{-1, {}};
      for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        f.loop.push_back(far * (n + a * u + b * v));
      faces.push_back(f);
    }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto& plane = planes[i];
    std::vector<Face> kept;
    std::vector<Vec3> rim;
    for (const auto& f : faces) {
      Face cut{f.plane, {}};
      const std::size_t n = f.loop.size();
      for (std::size_t k = 0; k < n; ++k) {
        const Vec3 &a = f.loop[k], &b = f.loop[(k + 1) % n];
        const double da = plane.normal.dot(a) - plane.offset, db = plane.normal.dot(b) - plane.offset;
        if (da <= same) cut.loop.push_back(a);
        if (std::abs(da) <= same) rim.push_back(a);
        if ((da > same && db < -same) || (da < -same && db > same)) {
          const Vec3 q = a + (b - a) * (da / (da - db));
          cut.loop.push_back(q);
          rim.push_back(q);
        }
      }
      if (cut.loop.size() >= 3) kept.push_back(std::move(cut));
    }
    // The new face: its rim in order of angle.
    if (rim.size() >= 3) {
      Vec3 center = Vec3::Zero();
      for (const auto& q : rim) center += q / double(rim.size());
      const Vec3 u = rotation_onto_axis(plane.normal).col(0), v = plane.normal.cross(u);
      std::vector<std::pair<double, Vec3>> order;
      for (const auto& q : rim) order.emplace_back(std::atan2((q - center).dot(v), (q - center).dot(u)), q);
      std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
      Face f{static_cast<int>(i), {}};
      const double merge = std::max(same * 10, 1e-12 * far);
      for (const auto& [angle, q] : order)
        if (f.loop.empty() || (q - f.loop.back()).norm() > merge) f.loop.push_back(q);
      while (f.loop.size() > 1 && (f.loop.front() - f.loop.back()).norm() <= merge) f.loop.pop_back();
      if (f.loop.size() >= 3) kept.push_back(std::move(f));
    }
    faces = std::move(kept);
    if (faces.size() < 4) return {};
  }
  // Where more than three planes meet in one point, the cuts leave equal corners: exact vertices come from the planes.
  ConvexPolyhedron result;
  result.faces.resize(planes.size());
  const double merge = 1e-7 * extent;
  for (const auto& f : faces) {
    if (f.plane < 0) return {};
    if (!result.faces[f.plane].empty()) continue;
    std::vector<std::uint32_t> loop;
    for (const auto& q : f.loop) {
      std::uint32_t index = 0;
      while (index < result.vertices.size() && (result.vertices[index] - q).norm() > merge) ++index;
      if (index == result.vertices.size()) result.vertices.push_back(q);
      if (loop.empty() || loop.back() != index) loop.push_back(index);
    }
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() >= 3) result.faces[f.plane] = std::move(loop);
  }
  for (std::uint32_t v = 0; v < result.vertices.size(); ++v) {
    std::vector<int> through;
    for (std::size_t i = 0; i < planes.size(); ++i)
      if (std::find(result.faces[i].begin(), result.faces[i].end(), v) != result.faces[i].end())
        through.push_back(static_cast<int>(i));
    if (through.size() != 3) continue;
    Mat3 m;
    Vec3 o;
    for (int k = 0; k < 3; ++k) m.row(k) = planes[through[k]].normal, o[k] = planes[through[k]].offset;
    if (std::abs(m.determinant()) > 1e-9) result.vertices[v] = m.inverse() * o;
  }
  if (std::count_if(result.faces.begin(), result.faces.end(), [](const auto& f) { return !f.empty(); }) < 4) return {};
  if (volume(triangulated(result)) <= 0) return {};
  return result;
}

double face_area(const ConvexPolyhedron& polyhedron, std::size_t face) {
  const auto& f = polyhedron.faces[face];
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < f.size(); ++i)
    sum += (polyhedron.vertices[f[i]] - polyhedron.vertices[f[0]])
               .cross(polyhedron.vertices[f[i + 1]] - polyhedron.vertices[f[0]]);
  return 0.5 * sum.norm();
}

TriangleMesh triangulated(const ConvexPolyhedron& polyhedron, std::vector<int>* face_of) {
  TriangleMesh mesh;
  mesh.vertices = polyhedron.vertices;
  for (std::size_t f = 0; f < polyhedron.faces.size(); ++f) {
    const auto& loop = polyhedron.faces[f];
    for (std::size_t k = 2; k < loop.size(); ++k) {
      mesh.triangles.push_back({loop[0], loop[k - 1], loop[k]});
      if (face_of) face_of->push_back(static_cast<int>(f));
    }
  }
  return mesh;
}

}  // namespace partscribe::geometry
