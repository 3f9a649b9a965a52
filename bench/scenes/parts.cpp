// The parts as OpenCASCADE builds them.
#include "parts.h"

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepFilletAPI_MakeChamfer.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRep_Tool.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Vertex.hxx>
#include <functional>

#include "core/ensure.h"
#include "core/number.h"

namespace bench {
namespace {

TopoDS_Shape without(const TopoDS_Shape& a, const TopoDS_Shape& b) { return BRepAlgoAPI_Cut(a, b).Shape(); }

/// Faces that are pieces of one surface are one.
TopoDS_Shape with(const TopoDS_Shape& a, const TopoDS_Shape& b) {
  ShapeUpgrade_UnifySameDomain united(BRepAlgoAPI_Fuse(a, b).Shape());
  united.Build();
  return united.Shape();
}

TopoDS_Shape cylinder(const gp_Pnt& from, const gp_Dir& along, double radius, double height) {
  return BRepPrimAPI_MakeCylinder(gp_Ax2(from, along), radius, height).Shape();
}

TopoDS_Shape cone(const gp_Pnt& from, const gp_Dir& along, double first, double last, double height) {
  return BRepPrimAPI_MakeCone(gp_Ax2(from, along), first, last, height).Shape();
}

/// The edges whose ends both lie where `wanted` says, rounded.
TopoDS_Shape rounded(const TopoDS_Shape& shape, double radius, const std::function<bool(const gp_Pnt&)>& wanted) {
  BRepFilletAPI_MakeFillet round(shape);
  int count = 0;
  for (TopExp_Explorer edges(shape, TopAbs_EDGE); edges.More(); edges.Next()) {
    const TopoDS_Edge edge = TopoDS::Edge(edges.Current());
    if (edge.Orientation() != TopAbs_FORWARD) continue;  // each edge stands on two faces
    if (!wanted(BRep_Tool::Pnt(TopExp::FirstVertex(edge))) || !wanted(BRep_Tool::Pnt(TopExp::LastVertex(edge))))
      continue;
    round.Add(radius, edge), ++count;
  }
  ensure(count > 0, "an edge to be rounded");
  return round.Shape();
}

bool near(double a, double b) { return std::abs(a - b) < 1e-6; }

/// 14: bottom, top, rim, hub, round at its foot, end of the hub, bore, countersink of the bore, six holes.
TopoDS_Shape flange() {
  const gp_Dir up(0, 0, 1);
  TopoDS_Shape shape = with(cylinder({0, 0, 0}, up, 40, 10), cylinder({0, 0, 0}, up, 18, 32));
  shape = rounded(shape, 4, [](const gp_Pnt& p) { return near(p.Z(), 10) && near(std::hypot(p.X(), p.Y()), 18); });
  shape = without(shape, cylinder({0, 0, -1}, up, 10, 40));
  shape = without(shape, cone({0, 0, 28}, up, 10, 16, 6));
  for (int k = 0; k < 6; ++k) {
    const double angle = k * pi / 3;
    shape = without(shape, cylinder({31 * std::cos(angle), 31 * std::sin(angle), -1}, up, 4, 12));
  }
  return shape;
}

/// 15: eight planes, the round in the corner, two holes with countersinks, two holes without.
TopoDS_Shape bracket() {
  const gp_Dir up(0, 0, 1), back(0, 1, 0);
  TopoDS_Shape shape = with(BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), gp_Pnt(80, 50, 10)).Shape(),
                            BRepPrimAPI_MakeBox(gp_Pnt(0, 38, 0), gp_Pnt(80, 50, 60)).Shape());
  shape = rounded(shape, 6, [](const gp_Pnt& p) { return near(p.Y(), 38) && near(p.Z(), 10); });
  for (const double x : {18.0, 62.0}) {
    shape = without(shape, cylinder({x, 16, -1}, up, 5, 12));
    shape = without(shape, cone({x, 16, 6}, up, 5, 10, 5));
    shape = without(shape, cylinder({x, 37, 40}, back, 7, 14));
  }
  return shape;
}

/// 15: six planes of a block, one round at an edge, dome, bore, counterbore and its floor, a conical hollow, a boss,
/// the torus around its end, its end.
TopoDS_Shape housing() {
  const gp_Dir up(0, 0, 1), right(1, 0, 0), back(0, 1, 0);
  TopoDS_Shape shape = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), gp_Pnt(70, 50, 40)).Shape();
  shape = rounded(shape, 9, [](const gp_Pnt& p) { return near(p.X(), 0) && near(p.Y(), 0); });
  shape = with(shape, BRepPrimAPI_MakeSphere(gp_Pnt(35, 25, 36), 15).Shape());
  TopoDS_Shape boss = cylinder({60, 25, 16}, right, 12, 30);
  boss = rounded(boss, 4, [](const gp_Pnt& p) { return near(p.X(), 90); });
  shape = with(shape, boss);
  shape = without(shape, cylinder({20, -1, 18}, back, 6, 52));
  shape = without(shape, cylinder({20, -1, 18}, back, 11, 9));
  return without(shape, cone({46, 25, -1}, up, 14.5, 0, 14.5));
}

}  // namespace

std::vector<Part> parts() {
  std::vector<Part> all;
  for (const auto& [name, make] : std::vector<std::pair<std::string, TopoDS_Shape (*)()>>{
           {"flange", flange}, {"bracket", bracket}, {"housing", housing}})
    all.push_back({name, truth_of(make(), 0.002)});
  return all;
}

}  // namespace bench
