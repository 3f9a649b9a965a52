#include "verify/exchange/nurbs_of.h"

#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>

namespace partscribe::verify {
namespace {

KnotVector knots_of(int degree, const TColStd_Array1OfReal& sequence) {
  return {degree, {sequence.begin(), sequence.end()}};
}

Vec3 place_of(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

}  // namespace

NurbsCurve<3> nurbs_of(const Geom_BSplineCurve& curve) {
  NurbsCurve<3> result{knots_of(curve.Degree(), curve.KnotSequence()), {}, {}};
  for (int i = 1; i <= curve.NbPoles(); ++i) {
    result.points.push_back(place_of(curve.Pole(i)));
    if (curve.IsRational()) result.weights.push_back(curve.Weight(i));
  }
  return result;
}

NurbsSurface nurbs_of(const Geom_BSplineSurface& surface) {
  NurbsSurface result{knots_of(surface.UDegree(), surface.UKnotSequence()),
                      knots_of(surface.VDegree(), surface.VKnotSequence()),
                      {},
                      {}};
  const bool rational = surface.IsURational() || surface.IsVRational();
  for (int i = 1; i <= surface.NbUPoles(); ++i)
    for (int j = 1; j <= surface.NbVPoles(); ++j) {
      result.points.push_back(place_of(surface.Pole(i, j)));
      if (rational) result.weights.push_back(surface.Weight(i, j));
    }
  return result;
}

}  // namespace partscribe::verify
