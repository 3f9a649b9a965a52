/// Conics, quadrics and swept surfaces as rational B-splines: exact, not approximations.
///
/// Plane curves lie in z = 0; solids of revolution turn about z, and a profile is a curve (r, z) in its half plane.
/// Angles are in radians, counter-clockwise from x; the parameter of arcs and of turning is the angle at the ends of
/// its pieces, none of which is above a quarter turn, and close to it between them. Of closed solids' surfaces du x dv
/// points outwards. (Piegl and Tiller, The NURBS Book, chapters 7 and 8.)
#pragma once

#include "geometry/surfaces/curve2.h"
#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// center + cos(t) a + sin(t) b for from <= t <= to, with any two half axes that are conjugate; at most a full turn.
NurbsCurve<2> exact_ellipse(const Vec2& center, const Vec2& a, const Vec2& b, double from, double to);
/// An arc either way round, over its length in radians from 0.
NurbsCurve<2> exact_arc(const Arc2& arc);
/// center + cosh(t) a + sinh(t) b for from <= t <= to: one branch of a hyperbola.
NurbsCurve<2> exact_hyperbola(const Vec2& center, const Vec2& a, const Vec2& b, double from, double to);
/// vertex + t a + t^2 b for from <= t <= to: a parabola, polynomial.
NurbsCurve<2> exact_parabola(const Vec2& vertex, const Vec2& a, const Vec2& b, double from, double to);

/// The profile turned from one angle to the other, at most a full turn; u is the angle, v the profile's parameter.
/// Radii of its control points must not be negative; where its end is at 0, an edge of the surface is a point.
NurbsSurface exact_revolution(const NurbsCurve<2>& profile, double from, double to);

/// Around z from z = 0 upwards; around z with the radii at z = 0 and at z = height; around the origin.
NurbsSurface exact_cylinder(double radius, double height);
NurbsSurface exact_cone(double bottom_radius, double top_radius, double height);
NurbsSurface exact_sphere(double radius);
NurbsSurface exact_torus(double ring_radius, double tube_radius);

/// Straight lines between places of equal shares of two curves' domains; u runs along the curves, from 0 to 1, v from
/// the first to the second. Both get the higher degree and the knots of both.
NurbsSurface exact_ruled(const NurbsCurve<3>& first, const NurbsCurve<3>& second);
/// The curve swept along `offset`: u runs along it, v from 0 to 1.
NurbsSurface exact_extrusion(const NurbsCurve<3>& curve, const Vec3& offset);

NurbsCurve<3> posed(const NurbsCurve<3>& curve, const Pose& to_from);
NurbsSurface posed(const NurbsSurface& surface, const Pose& to_from);

}  // namespace partscribe::geometry
