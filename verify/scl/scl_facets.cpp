/// Shells of flat facets: triangulations and convex polyhedra of Alpha_1 procedures.
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRep_Builder.hxx>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Geom_Line.hxx>
#include <Standard_Failure.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Pln.hxx>
#include <map>

#include "verify/scl/scl_shape.h"

namespace partscribe::verify {
namespace {

// A boolean over more plane faces takes minutes.
constexpr std::size_t max_brep_facets = 20000;

gp_Pnt pnt(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// Twice the area times the unit normal (Newell).
Vec3 area_vector(const std::vector<Vec3>& corners, const std::vector<std::uint32_t>& facet) {
  Vec3 sum = Vec3::Zero();
  const Vec3 o = corners[facet[0]];
  for (std::size_t i = 1; i + 1 < facet.size(); ++i) sum += (corners[facet[i]] - o).cross(corners[facet[i + 1]] - o);
  return sum;
}

}  // namespace

TriangleMesh facet_mesh(const SclGeometry& geometry) {
  TriangleMesh mesh;
  mesh.vertices = geometry.corners;
  for (const auto& f : geometry.facets)
    for (std::size_t i = 1; i + 1 < f.size(); ++i) mesh.triangles.push_back({f[0], f[i], f[i + 1]});
  return mesh;
}

SclMade facet_shell(std::vector<Vec3> corners, std::vector<std::vector<std::uint32_t>> facets) {
  if (facets.empty()) return bad_input("expected facets, found none");
  auto shell = std::make_shared<SclGeometry>();
  shell->kind = SclGeometryKind::shell;
  shell->corners = std::move(corners);
  shell->facets = std::move(facets);
  const TriangleMesh mesh = facet_mesh(*shell);
  shell->solid = topology(mesh).closed();
  if (shell->solid && volume(mesh) < 0)
    for (auto& f : shell->facets) std::reverse(f.begin(), f.end());
  return SclGeometryPtr(shell);
}

SclMade scl_facets(const std::vector<std::vector<Vec3>>& facets) {
  std::vector<Vec3> corners;
  std::vector<std::vector<std::uint32_t>> indices;
  std::map<std::array<double, 3>, std::uint32_t> known;
  for (std::size_t number = 0; number < facets.size(); ++number) {
    std::vector<std::uint32_t> facet;
    for (const auto& p : facets[number]) {
      const auto [it, fresh] =
          known.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, static_cast<std::uint32_t>(corners.size()));
      if (fresh) corners.push_back(p);
      if (facet.empty() || facet.back() != it->second) facet.push_back(it->second);
    }
    while (facet.size() > 1 && facet.front() == facet.back()) facet.pop_back();
    if (facet.size() < 3) continue;  // a collapsed facet bounds nothing
    if (facet.size() > 3) {
      const std::string name = "facet " + std::to_string(number + 1);
      Vec3 normal = area_vector(corners, facet);
      double size = 0;
      for (const auto i : facet) size = std::max(size, (corners[i] - corners[facet[0]]).norm());
      if (!(normal.norm() > 1e-14 * size * size)) return bad_input(name + " has no area");
      normal.normalize();
      for (std::size_t i = 0; i < facet.size(); ++i) {
        const Vec3 &a = corners[facet[i]], &b = corners[facet[(i + 1) % facet.size()]],
                   &c = corners[facet[(i + 2) % facet.size()]];
        if (std::abs(normal.dot(a - corners[facet[0]])) > 1e-5 + 1e-7 * size) return bad_input(name + " is not flat");
        if (normal.dot((b - a).cross(c - b)) < -1e-9 * size * size) return bad_input(name + " is not convex");
      }
    }
    indices.push_back(std::move(facet));
  }
  return facet_shell(std::move(corners), std::move(indices));
}

SclMade scl_half_spaces(const std::vector<std::array<double, 4>>& given) {
  if (given.size() < 4 || given.size() > 200)
    return bad_input("expected 4 to 200 half-spaces, found " + std::to_string(given.size()));
  std::vector<Vec3> normals;
  std::vector<double> offsets;
  double size = 1;
  for (const auto& g : given) {
    const Vec3 n(g[0], g[1], g[2]);
    if (!(n.norm() > 1e-9)) return bad_input("expected a normal other than 0 for a half-space");
    normals.push_back(n.normalized());
    offsets.push_back(g[3] / n.norm());
    size = std::max(size, std::abs(offsets.back()));
  }
  // Every corner is the meeting of three planes that no other plane cuts off; corners nearer than `same` are one.
  const double same = 1e-7 * size;
  const std::size_t n = normals.size();
  std::vector<Vec3> corners;
  std::vector<std::vector<std::uint32_t>> on_plane(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        Mat3 m;
        m << normals[i].transpose(), normals[j].transpose(), normals[k].transpose();
        if (std::abs(m.determinant()) < 1e-9) continue;
        const Vec3 p = m.inverse() * Vec3(offsets[i], offsets[j], offsets[k]);
        bool inside = true;
        for (std::size_t l = 0; l < n && inside; ++l) inside = normals[l].dot(p) <= offsets[l] + same;
        if (!inside) continue;
        std::uint32_t corner = 0;
        while (corner < corners.size() && (corners[corner] - p).norm() > 10 * same) ++corner;
        if (corner == corners.size()) corners.push_back(p);
      }
  if (corners.size() < 4) return bad_input("the half-spaces have no bounded body in common");
  for (std::size_t l = 0; l < n; ++l)
    for (std::uint32_t c = 0; c < corners.size(); ++c)
      if (std::abs(normals[l].dot(corners[c]) - offsets[l]) <= 20 * same) on_plane[l].push_back(c);
  std::vector<std::vector<std::uint32_t>> facets;
  for (std::size_t l = 0; l < n; ++l) {
    auto& facet = on_plane[l];
    if (facet.size() < 3) continue;
    if (std::find(on_plane.begin(), on_plane.begin() + static_cast<std::ptrdiff_t>(l), facet) !=
        on_plane.begin() + static_cast<std::ptrdiff_t>(l))
      continue;
    Vec3 middle = Vec3::Zero();
    for (const auto c : facet) middle += corners[c] / static_cast<double>(facet.size());
    const Vec3 x = (corners[facet[0]] - middle).normalized(), y = normals[l].cross(x);
    std::vector<std::pair<double, std::uint32_t>> around;
    for (const auto c : facet)
      around.push_back({std::atan2(y.dot(corners[c] - middle), x.dot(corners[c] - middle)), c});
    std::sort(around.begin(), around.end());
    std::vector<std::uint32_t> ring;
    for (const auto& [angle, c] : around) ring.push_back(c);
    if (area_vector(corners, ring).norm() > same * size) facets.push_back(ring);
  }
  auto shell = facet_shell(std::move(corners), std::move(facets));
  if (shell.ok() && !(*shell)->solid) return bad_input("the half-spaces do not bound a body on all sides");
  return shell;
}

Result<TopoDS_Shape> brep_of(const SclGeometry& geometry) {
  if (geometry.shape) return *geometry.shape;
  if (geometry.facets.size() > max_brep_facets)
    return bad_input("expected at most " + std::to_string(max_brep_facets) + " facets in a shell to combine, found " +
                     std::to_string(geometry.facets.size()));
  try {
    BRep_Builder builder;
    std::vector<TopoDS_Vertex> vertices(geometry.corners.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) builder.MakeVertex(vertices[i], pnt(geometry.corners[i]), 1e-5);
    std::map<std::pair<std::uint32_t, std::uint32_t>, TopoDS_Edge> edges;
    TopoDS_Shell shell;
    builder.MakeShell(shell);
    for (const auto& facet : geometry.facets) {
      const Vec3 normal = area_vector(geometry.corners, facet);
      if (!(normal.norm() > 1e-12)) return bad_input("a facet of the shell has no area");
      TopoDS_Wire wire;
      builder.MakeWire(wire);
      for (std::size_t i = 0; i < facet.size(); ++i) {
        const std::uint32_t a = facet[i], b = facet[(i + 1) % facet.size()];
        const auto key = std::minmax(a, b);
        auto& edge = edges[{key.first, key.second}];
        if (edge.IsNull()) {
          const Vec3 from = geometry.corners[key.first], way = geometry.corners[key.second] - from;
          Handle(Geom_Line) line = new Geom_Line(pnt(from), gp_Dir(way.x(), way.y(), way.z()));
          builder.MakeEdge(edge, line, 1e-7);
          builder.Add(edge, vertices[key.first].Oriented(TopAbs_FORWARD));
          builder.Add(edge, vertices[key.second].Oriented(TopAbs_REVERSED));
          builder.Range(edge, 0, way.norm());
        }
        builder.Add(wire, edge.Oriented(a == key.first ? TopAbs_FORWARD : TopAbs_REVERSED));
      }
      wire.Closed(true);
      BRepBuilderAPI_MakeFace face(gp_Pln(pnt(geometry.corners[facet[0]]), gp_Dir(normal.x(), normal.y(), normal.z())),
                                   wire, false);
      if (!face.IsDone()) return bad_input("a facet of the shell is not a plane face");
      builder.Add(shell, face.Face());
    }
    if (!geometry.solid) return TopoDS_Shape(shell);
    shell.Closed(true);
    TopoDS_Solid solid;
    builder.MakeSolid(solid);
    builder.Add(solid, shell);
    return TopoDS_Shape(solid);
  } catch (const Standard_Failure& f) {
    return bad_input(std::string("the facets make no shell: ") +
                     (f.GetMessageString() ? f.GetMessageString() : "geometry kernel failed"));
  }
}

}  // namespace partscribe::verify
