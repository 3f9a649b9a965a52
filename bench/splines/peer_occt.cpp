// OpenCASCADE: approximated grids, and plates through points that are made B-splines.
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <GeomPlate_BuildPlateSurface.hxx>
#include <GeomPlate_MakeApprox.hxx>
#include <GeomPlate_PointConstraint.hxx>
#include <GeomPlate_Surface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Plane.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <cmath>

#include "peers.h"

namespace bench {
namespace {

std::optional<NurbsSurface> converted(const Handle(Geom_BSplineSurface) & surface) {
  if (surface.IsNull() || surface->IsURational() || surface->IsVRational()) return std::nullopt;
  NurbsSurface result;
  result.u.degree = surface->UDegree(), result.v.degree = surface->VDegree();
  for (int i = 1; i <= surface->NbUKnots(); ++i)
    result.u.knots.insert(result.u.knots.end(), std::size_t(surface->UMultiplicity(i)), surface->UKnot(i));
  for (int i = 1; i <= surface->NbVKnots(); ++i)
    result.v.knots.insert(result.v.knots.end(), std::size_t(surface->VMultiplicity(i)), surface->VKnot(i));
  for (int i = 1; i <= surface->NbUPoles(); ++i)
    for (int j = 1; j <= surface->NbVPoles(); ++j) {
      const gp_Pnt p = surface->Pole(i, j);
      result.points.emplace_back(p.X(), p.Y(), p.Z());
    }
  return result;
}

std::optional<NurbsSurface> approximated_grid(const Question& question, double allowed, int degree,
                                              GeomAbs_Shape continuity) {
  try {
    TColStd_Array2OfReal heights(1, question.columns, 1, question.rows);
    for (int i = 0; i < question.columns; ++i)
      for (int j = 0; j < question.rows; ++j)
        heights(i + 1, j + 1) = question.points[std::size_t(i * question.rows + j)].z();
    const Vec3 &first = question.points.front(), &last = question.points.back();
    GeomAPI_PointsToBSplineSurface fit;
    fit.Init(heights, first.x(), (last.x() - first.x()) / (question.columns - 1), first.y(),
             (last.y() - first.y()) / (question.rows - 1), 3, degree, continuity, allowed);
    return fit.IsDone() ? converted(fit.Surface()) : std::nullopt;
  } catch (const Standard_Failure&) {
    return std::nullopt;
  }
}

/// The point nearest to each node of a net over the field: a plate solves a full system with one equation for each.
std::vector<Vec3> thinned_to(const std::vector<Vec3>& points, int nodes) {
  std::vector<double> nearest(std::size_t(nodes * nodes), 1e300);
  std::vector<Vec3> result(nearest.size());
  const Vec2 step = field_size / (nodes - 1);
  for (const Vec3& p : points) {
    const double i = std::round(p.x() / step.x()), j = std::round(p.y() / step.y());
    const auto node = std::size_t(i * nodes + j);
    const double d = (p.head<2>() - Vec2(i * step.x(), j * step.y())).squaredNorm();
    if (d < nearest[node]) nearest[node] = d, result[node] = p;
  }
  return result;
}

std::optional<NurbsSurface> approximated_plate(const Question& question, double allowed, int nodes) {
  try {
    GeomPlate_BuildPlateSurface builder(3, 10, 1);
    builder.LoadInitSurface(new Geom_Plane(gp_Pnt(0, 0, question.points.front().z()), gp_Dir(0, 0, 1)));
    for (const Vec3& p : thinned_to(question.points, nodes))
      builder.Add(new GeomPlate_PointConstraint(gp_Pnt(p.x(), p.y(), p.z()), 0));
    builder.Perform();
    if (!builder.IsDone()) return std::nullopt;
    GeomPlate_MakeApprox approx(builder.Surface(), allowed, 1000, 3, allowed, -1, GeomAbs_C1, 1.02);
    return converted(approx.Surface());
  } catch (const Standard_Failure&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<Contestant> occt(double seconds) {
  std::vector<Contestant> result;
  for (const int degree : {3, 5, 8})
    result.push_back({"OCCT grid", "degree " + std::to_string(degree), true, false, 9,
                      [=](const Question& question, double allowed) {
                        return asked_apart([&] { return approximated_grid(question, allowed, degree, GeomAbs_C2); },
                                           seconds);
                      }});
  // Of degree 8 and C2 the plates take tens of thousands of control points.
  for (const int nodes : {15, 30})
    result.push_back({"OCCT plate", std::to_string(nodes * nodes) + " points", false, true, 9,
                      [=](const Question& question, double allowed) {
                        return asked_apart([&] { return approximated_plate(question, allowed, nodes); }, seconds);
                      }});
  return result;
}

}  // namespace bench
