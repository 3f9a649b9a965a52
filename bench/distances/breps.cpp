// Exact distances from points to trimmed surfaces: ours beside OpenCASCADE's ways, by processor time.
#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepClass3d_SolidClassifier.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepExtrema_ExtPF.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <Extrema_ExtPS.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/random.h"
#include "core/statistics.h"
#include "measure.h"
#include "verify/exchange/brep_distance.h"

using namespace partscribe::verify;

namespace bench {
namespace {

/// A filleted plate with holes, bosses on fillets, a countersink, a rounded pocket, a dimple and a blind hole.
TopoDS_Shape solid() {
  auto up = [](double x, double y, double z) { return gp_Ax2(gp_Pnt(x, y, z), gp::DZ()); };
  auto fillet_vertical = [](const TopoDS_Shape& shape, double radius) {
    BRepFilletAPI_MakeFillet maker(shape);
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(shape, TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); ++i) {
      const TopoDS_Edge edge = TopoDS::Edge(edges(i));
      const gp_Pnt a = BRep_Tool::Pnt(TopExp::FirstVertex(edge)), b = BRep_Tool::Pnt(TopExp::LastVertex(edge));
      if (std::abs(a.X() - b.X()) < 1e-9 && std::abs(a.Y() - b.Y()) < 1e-9) maker.Add(radius, edge);
    }
    return maker.Shape();
  };
  TopoDS_Shape part = fillet_vertical(BRepPrimAPI_MakeBox(80, 60, 20).Shape(), 6);
  for (const double x : {9.0, 71.0})
    for (const double y : {9.0, 51.0})
      part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeCylinder(up(x, y, -1), 2.5, 30).Shape()).Shape();
  for (const double y : {18.0, 42.0})
    part = BRepAlgoAPI_Fuse(part, BRepPrimAPI_MakeCylinder(up(20, y, 10), 6, 18).Shape()).Shape();
  {
    BRepFilletAPI_MakeFillet maker(part);
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(part, TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); ++i) {
      const TopoDS_Edge edge = TopoDS::Edge(edges(i));
      double first, last;
      const auto curve = BRep_Tool::Curve(edge, first, last);
      if (curve.IsNull()) continue;
      const gp_Pnt p = curve->Value(0.5 * (first + last)), a = curve->Value(first);
      auto on_boss = [](const gp_Pnt& q) {
        return std::abs(q.Z() - 20) < 1e-6 && (std::abs(std::hypot(q.X() - 20, q.Y() - 18) - 6) < 1e-6 ||
                                               std::abs(std::hypot(q.X() - 20, q.Y() - 42) - 6) < 1e-6);
      };
      if (on_boss(p) && on_boss(a)) maker.Add(1.5, edge);
    }
    part = maker.Shape();
  }
  part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeCylinder(up(40, 30, -1), 3, 30).Shape()).Shape();
  part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeCone(up(40, 30, 16), 3, 7, 4).Shape()).Shape();
  const TopoDS_Shape pocket = fillet_vertical(BRepPrimAPI_MakeBox(gp_Pnt(52, 16, 12), 14, 28, 20).Shape(), 3);
  part = BRepAlgoAPI_Cut(part, pocket).Shape();
  part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeSphere(gp_Pnt(40, 50, 22), 5).Shape()).Shape();
  return BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeCylinder(up(40, 10, 8), 3, 20).Shape()).Shape();
}

std::vector<TopoDS_Face> faces_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Face> faces;
  for (TopExp_Explorer e(shape, TopAbs_FACE); e.More(); e.Next()) faces.push_back(TopoDS::Face(e.Current()));
  return faces;
}

/// Half of them beside the surface, a quarter close to edges and corners, a quarter anywhere around.
std::vector<Vec3> queries_for(const TopoDS_Shape& shape, std::size_t count) {
  BRepMesh_IncrementalMesh(shape, 0.2);
  std::vector<std::array<Vec3, 3>> triangles;
  std::vector<Vec3> nodes;
  for (const auto& face : faces_of(shape)) {
    TopLoc_Location location;
    const auto mesh = BRep_Tool::Triangulation(face, location);
    auto node = [&](int i) {
      const gp_Pnt p = mesh->Node(i);
      return Vec3(p.X(), p.Y(), p.Z());
    };
    for (int i = 1; i <= mesh->NbNodes(); ++i) nodes.push_back(node(i));
    for (int i = 1; i <= mesh->NbTriangles(); ++i) {
      int a, b, c;
      mesh->Triangle(i).Get(a, b, c);
      triangles.push_back({node(a), node(b), node(c)});
    }
  }
  std::vector<double> sum;
  double total = 0;
  for (const auto& t : triangles) sum.push_back(total += (t[1] - t[0]).cross(t[2] - t[0]).norm());
  Random random(3);
  auto noise = [&](double s) { return Vec3(s * random.normal(), s * random.normal(), s * random.normal()); };
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 4 < 2) {
      const auto at = std::size_t(std::lower_bound(sum.begin(), sum.end(), random.uniform(0, total)) - sum.begin());
      const auto& t = triangles[std::min(at, triangles.size() - 1)];
      double u = random.uniform(), v = random.uniform();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      points.push_back(t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]) + noise(0.1));
    } else if (i % 4 == 2) {
      points.push_back(nodes[random.below(nodes.size())] + noise(0.3));
    } else {
      points.push_back({random.uniform(-30, 110), random.uniform(-30, 90), random.uniform(-20, 50)});
    }
  }
  return points;
}

void compare(const char* name, const TopoDS_Shape& shape, std::size_t count, std::size_t refereed) {
  const auto faces = faces_of(shape);
  const auto queries = queries_for(shape, count);
  std::shared_ptr<const BrepDistance> exact;
  const auto setup = seconds_of([&] { exact = BrepDistance::make(shape); });
  std::printf("\n%s: %zu faces; set-up %.2f s; us per query of processor time\n", name, faces.size(), setup.cpu);
  if (!exact) {
    std::printf("  the shape was refused\n");
    return;
  }
  std::vector<BrepHit> hits;
  std::vector<double> times;
  for (int i = 0; i < 5; ++i) times.push_back(seconds_of([&] { hits = exact->closest(queries, 1); }).cpu);
  const double ours = median(times) / static_cast<double>(count) * 1e6;
  std::printf("  ours, batch                        %9.2f\n", ours);
  const auto two = seconds_of([&] { hits = exact->closest(queries, 2); });
  std::printf("  ours, batch, 2 threads             %9.2f (wall %.2f)\n", two.cpu / static_cast<double>(count) * 1e6,
              two.wall / static_cast<double>(count) * 1e6);
  const auto single = seconds_of([&] {
    for (const auto& q : queries) hits[0] = exact->closest(q);
  });
  std::printf("  ours, one by one                   %9.2f\n", single.cpu / static_cast<double>(count) * 1e6);
  hits = exact->closest(queries, 1);

  auto peer = [&](const char* what, std::size_t n, auto&& work) {
    const double us = seconds_of([&] {
                        for (std::size_t i = 0; i < n; ++i)
                          work(gp_Pnt(queries[i].x(), queries[i].y(), queries[i].z()));
                      }).cpu /
                      static_cast<double>(n) * 1e6;
    std::printf("  %-34s %9.2f   ours is %.0f x faster\n", what, us, us / ours);
  };
  double sink = 0;
  {
    // All untrimmed surfaces, reused; the trim is not even looked at.
    std::vector<std::unique_ptr<BRepAdaptor_Surface>> adaptors;
    std::vector<std::unique_ptr<Extrema_ExtPS>> searches;
    for (const auto& face : faces) {
      adaptors.push_back(std::make_unique<BRepAdaptor_Surface>(face));
      const auto& s = *adaptors.back();
      searches.push_back(std::make_unique<Extrema_ExtPS>());
      searches.back()->Initialize(s, s.FirstUParameter(), s.LastUParameter(), s.FirstVParameter(), s.LastVParameter(),
                                  1e-9, 1e-9);
    }
    peer("OpenCASCADE Extrema_ExtPS, reused", 300, [&](const gp_Pnt& p) {
      double best = 1e300;
      for (auto& search : searches) {
        search->Perform(p);
        for (int i = 1; search->IsDone() && i <= search->NbExt(); ++i) best = std::min(best, search->SquareDistance(i));
      }
      sink += best;
    });
    peer("OpenCASCADE ProjectPointOnSurf", 200, [&](const gp_Pnt& p) {
      double best = 1e300;
      for (const auto& face : faces) {
        GeomAPI_ProjectPointOnSurf project(p, BRep_Tool::Surface(face));
        if (project.NbPoints() > 0) best = std::min(best, project.LowerDistance());
      }
      sink += best;
    });
  }
  std::size_t wrong = 0;
  double worst = 0;
  std::size_t done = 0, undecided = 0, wrong_sign = 0;
  peer("OpenCASCADE DistShapeShape", std::min(refereed, count), [&](const gp_Pnt& p) {
    BRepExtrema_DistShapeShape search(BRepBuilderAPI_MakeVertex(p).Vertex(), shape);
    // For a solid the answer inside is zero; its faces are asked then.
    double d = search.Value();
    if (search.InnerSolution() || d == 0) {
      d = 1e300;
      for (const auto& face : faces) {
        BRepExtrema_DistShapeShape one(BRepBuilderAPI_MakeVertex(p).Vertex(), face);
        d = std::min(d, one.Value());
      }
    }
    const double off = std::abs(std::abs(hits[done].distance) - d);
    if (off > worst) worst = off;
    if (off > 1e-6) {
      ++wrong;
      if (wrong <= 8)
        std::printf("    (%.9g %.9g %.9g): ours %.9f on face %u, OpenCASCADE %.9f\n", p.X(), p.Y(), p.Z(),
                    hits[done].distance, hits[done].face, d);
    }
    ++done;
  });
  std::printf("    %zu answers refereed, %zu differ by more than 1e-6 mm, worst %.2g mm\n", done, wrong, worst);
  BRepClass3d_SolidClassifier classifier(shape);
  for (std::size_t i = 0; i < std::min<std::size_t>(count, 3000); ++i) {
    classifier.Perform(gp_Pnt(queries[i].x(), queries[i].y(), queries[i].z()), 1e-7);
    if (classifier.State() == TopAbs_ON)
      ++undecided;
    else if ((classifier.State() == TopAbs_IN) != (hits[i].distance < 0)) {
      ++wrong_sign;
      std::printf("    (%.9g %.9g %.9g): ours %.9f on face %u at (%.9g %.9g %.9g)\n", queries[i].x(), queries[i].y(),
                  queries[i].z(), hits[i].distance, hits[i].face, hits[i].point.x(), hits[i].point.y(),
                  hits[i].point.z());
    }
  }
  std::printf("    signs: %zu of 3000 differ from OpenCASCADE's classifier, %zu on the surface\n", wrong_sign,
              undecided);
  if (sink == 1e99) std::printf(" ");
  std::fflush(stdout);
}

}  // namespace

void breps(std::size_t count, std::size_t refereed) {
  const TopoDS_Shape part = solid();
  compare("plate, analytic surfaces", part, count, refereed);
  compare("plate, all NURBS", BRepBuilderAPI_NurbsConvert(part, Standard_True).Shape(), count, refereed);
}

}  // namespace bench
