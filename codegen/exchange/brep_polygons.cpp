// Planar polygons on shared corners as OpenCASCADE shells and solids.
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRep_Builder.hxx>
#include <Eigen/Geometry>
#include <Geom_Plane.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <map>

#include "codegen/exchange/brep_shapes.h"
#include "core/disjoint_sets.h"

namespace partscribe::codegen {
namespace {

using Polygon = std::vector<std::uint32_t>;

/// Newell's normal: twice the area, turned as the polygon runs.
Vec3 area_vector(const std::vector<Vec3>& vertices, const Polygon& polygon) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    sum += (vertices[polygon[i]] - vertices[polygon[0]])
               .cross(vertices[polygon[(i + 1) % polygon.size()]] - vertices[polygon[0]]);
  }
  return sum;
}

/// A connected set of polygons.
struct Piece {
  TopoDS_Shell shell;
  Box3 bounds;
  double volume = 0;
};

/// For each polygon the number of its connected piece, counted in order of first appearance.
std::vector<std::uint32_t> pieces_of(const std::vector<Polygon>& polygons) {
  DisjointSets pieces(polygons.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> first;
  for (std::uint32_t i = 0; i < polygons.size(); ++i) {
    for (std::size_t k = 0; k < polygons[i].size(); ++k) {
      const auto [a, b] = std::minmax(polygons[i][k], polygons[i][(k + 1) % polygons[i].size()]);
      const auto [known, fresh] = first.insert({{a, b}, i});
      if (!fresh) pieces.unite(i, known->second);
    }
  }
  return pieces.numbers();
}

}  // namespace

TopoDS_Shape brep_of_polygons(const std::vector<Vec3>& vertices, const std::vector<Polygon>& polygons, bool closed) {
  BRep_Builder builder;
  std::vector<TopoDS_Vertex> corners(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    builder.MakeVertex(corners[i], gp_Pnt(vertices[i].x(), vertices[i].y(), vertices[i].z()), 1e-7);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, TopoDS_Edge> edges;
  const std::vector<std::uint32_t> piece_of = pieces_of(polygons);
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    const Polygon& polygon = polygons[i];
    const Vec3 area = area_vector(vertices, polygon);
    if (area.norm() < 1e-14) return {};
    const Vec3 normal = area.normalized();
    TopoDS_Wire wire;
    builder.MakeWire(wire);
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const std::uint32_t a = polygon[k], b = polygon[(k + 1) % polygon.size()];
      TopoDS_Edge& edge = edges[std::minmax(a, b)];
      if (edge.IsNull()) {
        BRepBuilderAPI_MakeEdge made(corners[std::min(a, b)], corners[std::max(a, b)]);
        if (!made.IsDone()) return {};
        edge = made.Edge();
      }
      builder.Add(wire, a < b ? edge : TopoDS::Edge(edge.Reversed()));
    }
    wire.Closed(true);
    TopoDS_Face face;
    const Vec3& p = vertices[polygon[0]];
    builder.MakeFace(face, new Geom_Plane(gp_Pnt(p.x(), p.y(), p.z()), gp_Dir(normal.x(), normal.y(), normal.z())),
                     1e-7);
    builder.Add(face, wire);
    const std::size_t number = piece_of[i];
    if (number == pieces.size()) {
      pieces.emplace_back();
      builder.MakeShell(pieces.back().shell);
    }
    Piece& piece = pieces[number];
    builder.Add(piece.shell, face);
    piece.volume += p.dot(area) / 6;
    for (const auto v : polygon) piece.bounds.add(vertices[v]);
  }
  if (pieces.empty()) return {};

  if (!closed) {
    TopoDS_Compound all;
    builder.MakeCompound(all);
    for (const Piece& piece : pieces) builder.Add(all, piece.shell);
    return pieces.size() == 1 ? TopoDS_Shape(pieces[0].shell) : TopoDS_Shape(all);
  }
  std::vector<ClosedShell> shells;
  for (Piece& piece : pieces) {
    piece.shell.Closed(true);
    shells.push_back({&piece.shell, piece.volume, piece.bounds});
  }
  return solids_of(shells);
}

TopoDS_Shape solids_of(const std::vector<ClosedShell>& shells) {
  BRep_Builder builder;
  TopoDS_Compound all;
  builder.MakeCompound(all);
  std::vector<TopoDS_Solid> solids(shells.size());
  for (std::size_t i = 0; i < shells.size(); ++i) {
    if (shells[i].volume <= 0) continue;
    builder.MakeSolid(solids[i]);
    builder.Add(solids[i], *shells[i].shell);
  }
  // A piece that faces inward is a cavity of the smallest body around it.
  for (const ClosedShell& cavity : shells) {
    if (cavity.volume > 0) continue;
    std::size_t host = shells.size();
    for (std::size_t i = 0; i < shells.size(); ++i) {
      const bool around = shells[i].volume > 0 && (shells[i].bounds.low.array() <= cavity.bounds.low.array()).all() &&
                          (shells[i].bounds.high.array() >= cavity.bounds.high.array()).all();
      if (around && (host == shells.size() || shells[i].volume < shells[host].volume)) host = i;
    }
    if (host == shells.size()) return {};
    builder.Add(solids[host], *cavity.shell);
  }
  TopoDS_Shape last;
  int count = 0;
  for (const auto& solid : solids) {
    if (solid.IsNull()) continue;
    builder.Add(all, solid);
    last = solid;
    ++count;
  }
  return count == 1 ? last : TopoDS_Shape(all);
}

}  // namespace partscribe::codegen
