#include "verify/exchange/mesh_shape.h"

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <Geom_Surface.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>

#include "core/disjoint_sets.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_facets.h"

namespace partscribe::verify {
namespace {

Vec3 vec(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

/// Nodes of all faces in one list, united along shared edges and vertices by what the mesher recorded, not by
/// coordinates: so a gap stays a gap and a seam closes.
class NodeUnion {
 public:
  std::uint32_t add(const Vec3& p) {
    points_.push_back(p);
    return sets_.add();
  }
  std::uint32_t root(std::uint32_t i) { return sets_.root(i); }  // the first node's place is the place of all
  void unite(std::uint32_t a, std::uint32_t b) { sets_.unite(a, b); }
  const Vec3& point(std::uint32_t i) const { return points_[i]; }
  std::size_t size() const { return points_.size(); }

 private:
  DisjointSets sets_;
  std::vector<Vec3> points_;
};

using Triangle = std::array<std::uint32_t, 3>;

/// Splits inner edges of one face that are farther than `limit` from the surface: the mesher leaves long strips
/// across narrow spline faces uncontrolled. Border edges stay, so neighbours keep fitting.
void split_inner_edges(const Geom_Surface& surface, const gp_Trsf& world_from_surface, double limit,
                       std::uint32_t first, NodeUnion& nodes, std::vector<gp_XY>& uv,
                       std::vector<Triangle>& triangles) {
  for (int round = 0; round < 6; ++round) {
    const auto uses = edge_uses(triangles);
    constexpr std::uint32_t none = ~0u;
    std::vector<Triangle> middles(triangles.size(), {none, none, none});
    bool any = false;
    for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
      if (uses[i].key != uses[i + 1].key) continue;
      const auto a = uses[i].low(), b = uses[i].high();
      const gp_XY place = (uv[a - first] + uv[b - first]) / 2.0;
      const Vec3 exact = vec(surface.Value(place.X(), place.Y()).Transformed(world_from_surface));
      const Vec3 chord = nodes.point(b) - nodes.point(a);
      if (!((exact - nodes.point(a)).cross(chord).norm() > limit * chord.norm())) continue;
      const auto middle = nodes.add(exact);
      uv.push_back(place);
      for (const auto& use : {uses[i], uses[i + 1]}) middles[use.triangle][use.side] = middle;
      any = true;
      ++i;
    }
    if (!any) return;
    std::vector<Triangle> finer;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      // Cut corners off where both edges at it are split, then fan what is left from a middle.
      std::vector<std::uint32_t> ring;
      for (std::size_t k = 0; k < 3; ++k) {
        ring.push_back(triangles[t][k]);
        if (middles[t][k] != none) ring.push_back(middles[t][k]);
      }
      const Triangle& m = middles[t];
      if (ring.size() == 6) {
        for (std::size_t k = 0; k < 3; ++k) finer.push_back({triangles[t][k], m[k], m[(k + 2) % 3]});
        finer.push_back({m[0], m[1], m[2]});
        continue;
      }
      std::size_t start = 0;  // a fan from the last split edge's middle never makes a flat triangle
      for (std::size_t k = 0; k < ring.size(); ++k)
        if (ring[k] == m[0] || ring[k] == m[1] || ring[k] == m[2]) start = k;
      for (std::size_t k = 1; k + 1 < ring.size(); ++k)
        finer.push_back({ring[start], ring[(start + k) % ring.size()], ring[(start + k + 1) % ring.size()]});
    }
    triangles = std::move(finer);
  }
}

bool has_gaps(const TopoDS_Shape& shape) {
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
    TopLoc_Location location;
    if (BRep_Tool::Triangulation(TopoDS::Face(faces.Current()), location).IsNull()) return true;
  }
  return false;
}

ShapeMesh collect(const TopoDS_Shape& shape, double limit) {
  ShapeMesh result;
  TopTools_IndexedMapOfShape edges, vertices;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  TopExp::MapShapes(shape, TopAbs_VERTEX, vertices);
  std::vector<std::vector<std::uint32_t>> edge_nodes(static_cast<std::size_t>(edges.Extent()) + 1);
  std::vector<std::int64_t> vertex_node(static_cast<std::size_t>(vertices.Extent()) + 1, -1);
  NodeUnion nodes;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> face_of;
  std::uint32_t face_index = 0;
  std::vector<Vec3> on_surface;  // exact places over the middles of facets and of their edges

  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next(), ++face_index) {
    const TopoDS_Face face = TopoDS::Face(faces.Current());
    TopLoc_Location location;
    const auto triangulation = BRep_Tool::Triangulation(face, location);
    if (triangulation.IsNull()) continue;
    const gp_Trsf world_from_face = location.Transformation();
    const auto first = static_cast<std::uint32_t>(nodes.size());
    for (int i = 1; i <= triangulation->NbNodes(); ++i)
      nodes.add(vec(triangulation->Node(i).Transformed(world_from_face)));

    for (TopExp_Explorer edge_explorer(face.Oriented(TopAbs_FORWARD), TopAbs_EDGE); edge_explorer.More();
         edge_explorer.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(edge_explorer.Current());
      const auto polygon = BRep_Tool::PolygonOnTriangulation(edge, triangulation, location);
      if (polygon.IsNull()) continue;
      std::vector<std::uint32_t> own;
      for (int i = 1; i <= polygon->NbNodes(); ++i)
        own.push_back(first + static_cast<std::uint32_t>(polygon->Nodes().Value(i)) - 1);
      if (BRep_Tool::Degenerated(edge)) {
        for (const auto n : own) nodes.unite(own.front(), n);
      } else {
        auto& shared = edge_nodes[static_cast<std::size_t>(edges.FindIndex(edge))];
        if (shared.empty()) shared = own;
        if (shared.size() == own.size())
          for (std::size_t i = 0; i < own.size(); ++i) nodes.unite(shared[i], own[i]);
      }
      // Nodes run along the edge's own direction, whatever way the face uses it.
      TopoDS_Vertex from, to;
      TopExp::Vertices(TopoDS::Edge(edge.Oriented(TopAbs_FORWARD)), from, to);
      for (const auto& [vertex, node] : {std::pair{from, own.front()}, std::pair{to, own.back()}}) {
        if (vertex.IsNull()) continue;
        auto& known = vertex_node[static_cast<std::size_t>(vertices.FindIndex(vertex))];
        if (known < 0) known = node;
        nodes.unite(static_cast<std::uint32_t>(known), node);
      }
    }

    // The triangulation follows the surface; a reversed face, or a mirroring placement, turns it over.
    const bool turned = (face.Orientation() == TopAbs_REVERSED) != (world_from_face.VectorialPart().Determinant() < 0);
    TopLoc_Location surface_location;
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(face, surface_location);
    const gp_Trsf world_from_surface = surface_location.Transformation();
    std::vector<Triangle> own_triangles;
    for (int i = 1; i <= triangulation->NbTriangles(); ++i) {
      int n[3];
      triangulation->Triangle(i).Get(n[0], n[1], n[2]);
      if (turned) std::swap(n[1], n[2]);
      own_triangles.push_back(
          {first + std::uint32_t(n[0]) - 1, first + std::uint32_t(n[1]) - 1, first + std::uint32_t(n[2]) - 1});
    }
    if (!surface.IsNull() && triangulation->HasUVNodes()) {
      std::vector<gp_XY> uv;
      for (int i = 1; i <= triangulation->NbNodes(); ++i) uv.push_back(triangulation->UVNode(i).XY());
      split_inner_edges(*surface, world_from_surface, limit, first, nodes, uv, own_triangles);
      auto measure = [&](const gp_XY& place) {
        on_surface.push_back(vec(surface->Value(place.X(), place.Y()).Transformed(world_from_surface)));
      };
      for (const auto& t : own_triangles) {
        const gp_XY corner[3] = {uv[t[0] - first], uv[t[1] - first], uv[t[2] - first]};
        measure((corner[0] + corner[1] + corner[2]) / 3.0);
        for (int k = 0; k < 3; ++k) measure((corner[k] + corner[(k + 1) % 3]) / 2.0);
      }
    }
    triangles.insert(triangles.end(), own_triangles.begin(), own_triangles.end());
    face_of.resize(triangles.size(), face_index);
  }

  std::vector<std::uint32_t> index(nodes.size(), ~0u);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    std::array<std::uint32_t, 3> w;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto r = nodes.root(triangles[i][k]);
      if (index[r] == ~0u) {
        index[r] = static_cast<std::uint32_t>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(nodes.point(r));
      }
      w[k] = index[r];
    }
    if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue;
    result.mesh.triangles.push_back(w);
    result.face_of.push_back(face_of[i]);
  }
  // To the whole mesh, not to the facet it came from: beside a pole the mean of parameters lies over a neighbour.
  if (!result.mesh.empty()) {
    const MeshDistance distance(result.mesh);
    for (const auto& p : on_surface) result.error = std::max(result.error, distance.closest(p).distance);
  }
  return result;
}

}  // namespace

ShapeMesh mesh_shape(const TopoDS_Shape& shape, double tolerance) {
  constexpr double angle = 0.35;  // rad; keeps small fillets round where the deflection would allow a chamfer
  // Watson's algorithm: Delabella's is faster but crashes on faces that the other merely leaves out.
  auto mesh = [&](double deflection, double turn) {
    BRepMesh_IncrementalMesh(shape, deflection, Standard_False, turn, Standard_False);
  };
  mesh(tolerance / 10, angle);
  // A face whose border crosses itself once it is made of chords is left out; another step width mends it.
  for (const double factor : {0.5, 2.0, 5.0}) {
    if (!has_gaps(shape)) break;
    BRepTools::Clean(shape);
    mesh(factor * tolerance / 10, angle);
  }
  ShapeMesh result = collect(shape, tolerance / 10);
  if (result.error > tolerance / 5) {
    BRepTools::Clean(shape);
    mesh(std::max(0.1, tolerance / 10 / result.error) * tolerance / 10, angle / 2);
    ShapeMesh finer = collect(shape, tolerance / 20);
    if (!has_gaps(shape) && finer.error < result.error) result = std::move(finer);
  }
  return result;
}

}  // namespace partscribe::verify
