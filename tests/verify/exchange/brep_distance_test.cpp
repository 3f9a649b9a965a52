/// Claims about exact distances to trimmed surfaces.
#include "verify/exchange/brep_distance.h"

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepPrimAPI_MakeWedge.hxx>
#include <BRep_Builder.hxx>
#include <Geom_BezierSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "verify/exchange/trim_region.h"

using namespace partscribe::verify;

namespace {

gp_Ax2 up(double x, double y, double z) { return {gp_Pnt(x, y, z), gp::DZ()}; }

/// The nearest of all faces by OpenCASCADE, each asked alone.
double referee(const TopoDS_Shape& shape, const Vec3& q) {
  double best = 1e300;
  const auto vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(q.x(), q.y(), q.z())).Vertex();
  for (TopExp_Explorer e(shape, TopAbs_FACE); e.More(); e.Next())
    best = std::min(best, BRepExtrema_DistShapeShape(vertex, e.Current()).Value());
  return best;
}

void agree(const TopoDS_Shape& shape, double reach, int count, std::uint64_t seed) {
  const auto exact = BrepDistance::make(shape);
  REQUIRE(exact);
  Random random(seed);
  std::string wrong;
  for (int i = 0; i < count; ++i) {
    Vec3 q(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
    // Every second one is drawn to the surface, where edges and trims decide.
    if (i % 2)
      q = exact->closest(q).point + Vec3(0.05 * random.normal(), 0.05 * random.normal(), 0.05 * random.normal());
    const BrepHit hit = exact->closest(q);
    const double truth = referee(shape, q);
    if (std::abs(std::abs(hit.distance) - truth) > 1e-6)
      wrong += "(" + print_number(q.x()) + ", " + print_number(q.y()) + ", " + print_number(q.z()) +
               "): " + print_number(hit.distance) + " on face " + std::to_string(hit.face) + ", not " +
               print_number(truth) + "\n";
    CHECK(std::abs((hit.point - q).norm() - std::abs(hit.distance)) < 1e-12);
  }
  CHECK(wrong == "");
}

TopoDS_Shape bracket(bool dimple = true) {
  TopoDS_Shape part = BRepPrimAPI_MakeWedge(up(-10, -8, -5), 20, 16, 10, 5, 4, 15, 9).Shape();
  part =
      BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-2, 0, -20), gp_Dir(0.2, 0.1, 1)), 2.5, 50).Shape())
          .Shape();
  part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeCone(up(5, 0, -6), 3, 1, 9).Shape()).Shape();
  if (dimple) part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeSphere(gp_Pnt(-9, -7, 1), 4).Shape()).Shape();
  return BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeTorus(up(3, 3, 5), 4, 1).Shape()).Shape();
}

/// A block under a wavy Bezier sheet with a hole through it: trimmed free form with intersection curves.
TopoDS_Shape wavy_block() {
  TColgp_Array2OfPnt poles(1, 4, 1, 4);
  const double height[4][4] = {{1, 3, -2, 2}, {4, -3, 5, 0}, {-2, 6, -4, 3}, {1, 0, 4, -1}};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) poles.SetValue(i + 1, j + 1, gp_Pnt(-9 + 6 * i, -9 + 6 * j, height[i][j]));
  const TopoDS_Shape sheet = BRepBuilderAPI_MakeFace(new Geom_BezierSurface(poles), 1e-6).Shape();
  const TopoDS_Shape block = BRepPrimAPI_MakePrism(sheet, gp_Vec(0, 0, -9)).Shape();
  return BRepAlgoAPI_Cut(block, BRepPrimAPI_MakeCylinder(up(1, 1, -20), 3, 40).Shape()).Shape();
}

}  // namespace

TEST_CASE("brep distance: whole spheres, tori, cylinders and cones have their closed-form signed distance") {
  Random random(1);
  auto each = [&](const TopoDS_Shape& shape, auto truth) {
    const auto exact = BrepDistance::make(shape);
    REQUIRE(exact);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 q(random.uniform(-12, 12), random.uniform(-12, 12), random.uniform(-12, 12));
      CHECK(std::abs(exact->closest(q).distance - truth(q)) < 1e-9);
    }
  };
  each(BRepPrimAPI_MakeSphere(5).Shape(), [](const Vec3& q) { return q.norm() - 5; });
  each(BRepPrimAPI_MakeTorus(6, 2).Shape(),
       [](const Vec3& q) { return std::hypot(std::hypot(q.x(), q.y()) - 6, q.z()) - 2; });
  each(BRepPrimAPI_MakeCylinder(up(0, 0, -4), 3, 8).Shape(), [](const Vec3& q) {
    const double r = std::hypot(q.x(), q.y()) - 3, z = std::abs(q.z()) - 4;
    return r > 0 && z > 0 ? std::hypot(r, z) : std::max(r, z);
  });
  // Where all directions are equally near: the axes and the centre.
  CHECK(BrepDistance::make(BRepPrimAPI_MakeSphere(5).Shape())->closest({0, 0, 0}).distance == Approx(-5));
  CHECK(BrepDistance::make(BRepPrimAPI_MakeTorus(6, 2).Shape())->closest({0, 0, 0}).distance == Approx(4));
  CHECK(BrepDistance::make(BRepPrimAPI_MakeCylinder(3, 80).Shape())->closest({0, 0, 40}).distance == Approx(-3));
}

TEST_CASE("brep distance: a solid cut by tilted cylinders, cones, spheres and tori agrees with the referee") {
  agree(bracket(), 14, 250, 2);
}

TEST_CASE("brep distance: the same as NURBS, and moved, turned and mirrored") {
  agree(BRepBuilderAPI_NurbsConvert(bracket(false), Standard_True).Shape(), 14, 60, 3);
  gp_Trsf motion, mirror;
  motion.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 2)), 1);
  mirror.SetMirror(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 0)));
  const TopoDS_Shape moved = BRepBuilderAPI_Transform(bracket(), mirror * motion, Standard_True).Shape();
  agree(moved, 14, 100, 4);
  // Placed by its location instead of by its geometry.
  agree(bracket().Moved(TopLoc_Location(motion)), 14, 60, 5);
  const auto exact = BrepDistance::make(moved), plain = BrepDistance::make(bracket());
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const Vec3 q(random.uniform(-12, 12), random.uniform(-12, 12), random.uniform(-12, 12));
    const gp_Pnt p = gp_Pnt(q.x(), q.y(), q.z()).Transformed(mirror * motion);
    CHECK(std::abs(exact->closest({p.X(), p.Y(), p.Z()}).distance - plain->closest(q).distance) < 1e-9);
  }
}

TEST_CASE("brep distance: trimmed free-form surfaces agree with the referee") { agree(wavy_block(), 13, 120, 7); }

TEST_CASE("brep distance: inside is negative beside edges and corners too") {
  const auto exact = BrepDistance::make(BRepPrimAPI_MakeBox(2, 3, 4).Shape());
  REQUIRE(exact);
  CHECK(exact->faces() == 6);
  CHECK(exact->closest({3, 4, 5}).distance == Approx(std::sqrt(3.0)));
  CHECK(exact->closest({3, 4, 1}).distance == Approx(std::sqrt(2.0)));
  Random random(8);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 q(random.uniform(-1, 3), random.uniform(-1, 4), random.uniform(-1, 5));
    const bool inside = q.x() > 0 && q.x() < 2 && q.y() > 0 && q.y() < 3 && q.z() > 0 && q.z() < 4;
    CHECK((exact->closest(q).distance < 0) == inside);
  }
}

TEST_CASE("brep distance: many queries on any number of threads get the answers of one by one, to the bit") {
  const auto exact = BrepDistance::make(wavy_block());
  REQUIRE(exact);
  Random random(9);
  std::vector<Vec3> queries;
  for (int i = 0; i < 3000; ++i)
    queries.push_back({random.uniform(-12, 12), random.uniform(-12, 12), random.uniform(-12, 6)});
  const auto two = exact->closest(queries, 2), one = exact->closest(queries, 1);
  std::size_t different = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const BrepHit alone = exact->closest(queries[i]);
    different += one[i].distance != alone.distance || two[i].distance != alone.distance || one[i].face != alone.face ||
                 two[i].point != alone.point;
  }
  CHECK(different == 0);
}

TEST_CASE("brep distance: a shape without faces is refused") {
  TopoDS_Compound empty;
  BRep_Builder().MakeCompound(empty);
  CHECK_FALSE(BrepDistance::make(empty));
}

TEST_CASE("brep distance: a straight boundary with a knot just short of its end still runs to its end") {
  const double last = 1.4142135623730951, turn = 6.283185307179586;
  auto straight = [](const Vec2& from, const Vec2& to, double end, std::vector<double> kinks) {
    TrimCurve curve;
    curve.at = [from, to, end](double t) { return Vec2(from + t / end * (to - from)); };
    curve.last = end, curve.straight = true, curve.kinks = std::move(kinks);
    return curve;
  };
  auto seam = straight({turn, 0}, {turn, -last}, last, {last - 1e-13});
  std::swap(seam.first, seam.last);  // run from its end to its start
  auto top = straight({0, 0}, {turn, 0}, 1, {});
  std::swap(top.first, top.last);
  const TrimRegion region(
      {{straight({0, -last}, {turn, -last}, 1, {}), seam, top, straight({0, 0}, {0, -last}, last, {last - 1e-13})}});
  CHECK(region.contains({0.04, -1.2}));
  CHECK(region.contains({6.2, -0.1}));
  CHECK_FALSE(region.contains({6.3, -0.1}));
}
