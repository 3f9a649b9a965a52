/// B-spline curves and surfaces in other control points: knots removed, degrees raised, parts, pieces, other ends.
///
/// But for the removal of knots all of these are exact: what comes out has the same place at every parameter as what
/// went in, to rounding. Surfaces are worked on along one of their parameters, u if `along_u`, else v.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// A curve or a surface with fewer knots.
template <class Spline>
struct KnotsRemoved {
  Spline spline;
  int removed = 0;       ///< so many knots fewer, each counted as often as it was there
  double deviation = 0;  ///< mm; no place at an equal parameter moved farther
};

/// With up to `times` knots fewer at t, inside of the domain, as long as nothing moves farther than `tolerance` mm. The
/// control points are those that move least when the knot is put back (Eck and Hadenfeld, Knot removal for B-spline
/// curves, 1995; The NURBS Book, A5.8, leaves the whole deviation to one of them).
template <int D>
KnotsRemoved<NurbsCurve<D>> without_knot(const NurbsCurve<D>& curve, double t, int times, double tolerance);
KnotsRemoved<NurbsSurface> without_knot(const NurbsSurface& surface, bool along_u, double t, int times,
                                        double tolerance);
/// With as few knots as `tolerance` allows when the least needed is removed again and again; surfaces along u, then v.
template <int D>
KnotsRemoved<NurbsCurve<D>> without_spare_knots(const NurbsCurve<D>& curve, double tolerance);
KnotsRemoved<NurbsSurface> without_spare_knots(const NurbsSurface& surface, double tolerance);

/// Of a degree that is higher by `times`, clamped at both ends; every knot is there as often again.
template <int D>
NurbsCurve<D> with_higher_degree(const NurbsCurve<D>& curve, int times = 1);
NurbsSurface with_higher_degree(const NurbsSurface& surface, bool along_u, int times = 1);

/// The part over [from, to], inside of the domain, over the same parameters; clamped at both ends.
template <int D>
NurbsCurve<D> part_between(const NurbsCurve<D>& curve, double from, double to);
NurbsSurface part_between(const NurbsSurface& surface, bool along_u, double from, double to);

/// What is before t and what is after it.
template <int D>
std::pair<NurbsCurve<D>, NurbsCurve<D>> split_at(const NurbsCurve<D>& curve, double t);
std::pair<NurbsSurface, NurbsSurface> split_at(const NurbsSurface& surface, bool along_u, double t);

/// One piece without inner knots for every span, in order, each over its own parameters; of surfaces v runs fastest.
template <int D>
std::vector<NurbsCurve<D>> bezier_pieces(const NurbsCurve<D>& curve);
std::vector<NurbsSurface> bezier_pieces(const NurbsSurface& surface);

/// The same, run from its end to its beginning over the same domain.
template <int D>
NurbsCurve<D> reversed(const NurbsCurve<D>& curve);
NurbsSurface reversed(const NurbsSurface& surface, bool along_u);

/// The curve on a surface that runs along u where v = at; along v where u = at.
NurbsCurve<3> iso_curve(const NurbsSurface& surface, bool along_u, double at);

/// The plane z = 0 around a plane curve, and a curve as a surface that is constant along v, over 0 .. 1 of degree 0:
/// for code that treats them alike.
NurbsCurve<3> in_space(const NurbsCurve<2>& curve);
NurbsSurface as_surface(const NurbsCurve<3>& curve);

/// With ends that interpolate: the knots at both ends of the domain count degree + 1 times, and there are none beyond.
template <int D>
NurbsCurve<D> with_clamped_ends(const NurbsCurve<D>& curve);
NurbsSurface with_clamped_ends(const NurbsSurface& surface, bool along_u);

/// A closed one over knots that go on beyond the domain's ends with its period: the seam becomes a knot like others, of
/// the least multiplicity m that holds `tolerance` (mm), and the last degree + 1 - m control points are the first ones.
/// Nothing where the ends do not meet.
template <int D>
std::optional<NurbsCurve<D>> with_wrapped_knots(const NurbsCurve<D>& curve, double tolerance);
std::optional<NurbsSurface> with_wrapped_knots(const NurbsSurface& surface, bool along_u, double tolerance);

}  // namespace partscribe::geometry
