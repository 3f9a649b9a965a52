/// Sketches, solids and their combinations, each declared once: the struct, its fields, their meaning.
///
/// `N` is the kind of number: Expr in a Model (`Cylinder = CylinderOf<Expr>`), double once evaluated
/// (`EvaluatedShape`). The static fields() walks are what JSON, checks, evaluation, templates and random test
/// models are made from: a walk calls v(name, field, Domain, meaning) for every number-like field, with one more
/// argument where the field may be left out of a document and then has that value, and v(name, field, meaning) for
/// structured ones. Millimetres and radians.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/number.h"
#include "geometry/vec.h"
#include "model/expr.h"

namespace partscribe::model {

/// What a number measures and which values make sense.
enum class Domain {
  length,          ///< mm, > 0
  length_or_zero,  ///< mm, >= 0
  coordinate,      ///< mm, any
  angle,           ///< rad, any
  turn,            ///< rad, above 0, a full turn at most
  exponent,        ///< 0.1 .. 2
  taper,           ///< -0.95 .. 0.95
  component,       ///< of a unit vector
  count,           ///< a whole number, 1 or more
};

// ---- sketches -------------------------------------------------------------------------------------------------

/// A corner of a loop.
template <class N>
struct SketchPointOf {
  N x{}, y{};
  std::string edge;  ///< role of the straight edge that follows, e.g. "shank"; may be empty
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("x", s.x, Domain::coordinate, "first coordinate");
    v("y", s.y, Domain::coordinate, "second coordinate");
    v("edge", s.edge, "role of the straight edge that follows");
  }
  bool operator==(const SketchPointOf&) const = default;
};

/// A circular arc; counter-clockwise when `to` > `from`. |to - from| <= 2 pi; a full turn is a circle on its own.
template <class N>
struct SketchArcOf {
  N center_x{}, center_y{}, radius{}, from{}, to{};
  std::string name;  ///< role of the arc, e.g. "fillet"
  std::string edge;  ///< role of the straight edge that follows
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("center_x", s.center_x, Domain::coordinate, "first coordinate of the centre");
    v("center_y", s.center_y, Domain::coordinate, "second coordinate of the centre");
    v("radius", s.radius, Domain::length, "radius");
    v("from", s.from, Domain::angle, "angle of the first end, from the first axis towards the second");
    v("to", s.to, Domain::angle, "angle of the last end");
    v("name", s.name, "role of the arc");
    v("edge", s.edge, "role of the straight edge that follows");
  }
  bool operator==(const SketchArcOf&) const = default;
};

/// A clamped NURBS curve from its first to its last control point.
template <class N>
struct SketchNurbsOf {
  int degree = 3;
  std::vector<double> knots;    ///< control.size() + degree + 1 values, repeats written out
  std::vector<double> weights;  ///< empty: all 1
  std::vector<std::array<N, 2>> control;
  std::string name, edge;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("degree", s.degree, "polynomial degree");
    v("knots", s.knots, "knot vector, repeats written out");
    v("weights", s.weights, "weights; empty when all are 1");
    v("control", s.control, "control points");
    v("name", s.name, "role of the curve");
    v("edge", s.edge, "role of the straight edge that follows");
  }
  bool operator==(const SketchNurbsOf&) const = default;
};

template <class N>
using SketchElementOf = std::variant<SketchPointOf<N>, SketchArcOf<N>, SketchNurbsOf<N>>;

/// A closed loop: each element is joined to the next, and the last to the first, by a straight edge, which is
/// left out where the two ends coincide.
template <class N>
struct LoopOf {
  std::string name;  ///< "outline", "bore", ...
  std::vector<SketchElementOf<N>> elements;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("name", s.name, "role of the loop");
    v("elements", s.elements, "points, arcs and curves in order");
  }
  bool operator==(const LoopOf&) const = default;
};

/// What two pieces of a sketch have to do with each other, by their roles ("wall", "left end").
struct SketchRelation {
  /// parallel, perpendicular (straight edges), tangent (pieces that meet), equal (two lengths or two radii), concentric
  /// (arcs), symmetric_x, symmetric_y (each the image of the other behind that axis of the sketch).
  std::string kind;
  std::string first, second;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("kind", s.kind, "parallel, perpendicular, tangent, equal, concentric, symmetric_x or symmetric_y");
    v("first", s.first, "role of an edge, arc or curve");
    v("second", s.second, "role of another");
  }
  bool operator==(const SketchRelation&) const = default;
};

/// The first loop is the outer boundary, counter-clockwise. Loops inside it are holes, clockwise; loops inside holes
/// are islands, counter-clockwise; and so on. Relations say what numbers in common only show: check() tests that they
/// hold.
template <class N>
struct SketchOf {
  std::vector<LoopOf<N>> loops;
  std::vector<SketchRelation> relations{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("loops", s.loops, "outer boundary first, then holes and islands");
    v("relations", s.relations, "what pieces of the sketch have to do with each other");
  }
  bool operator==(const SketchOf&) const = default;
};

// ---- solids ---------------------------------------------------------------------------------------------------

/// A block from the origin to (size_x, size_y, size_z).
template <class N>
struct BoxOf {
  static constexpr std::string_view kind = "box";
  N size_x{}, size_y{}, size_z{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("size_x", s.size_x, Domain::length, "size along x");
    v("size_y", s.size_y, Domain::length, "size along y");
    v("size_z", s.size_z, Domain::length, "size along z");
  }
  bool operator==(const BoxOf&) const = default;
};

/// A block whose face x = size_x is sloped: at y = 0 it is size_x long, at y = size_y it is top_x long (0: a prism).
template <class N>
struct WedgeOf {
  static constexpr std::string_view kind = "wedge";
  N size_x{}, size_y{}, size_z{}, top_x{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("size_x", s.size_x, Domain::length, "size along x at y = 0");
    v("size_y", s.size_y, Domain::length, "size along y");
    v("size_z", s.size_z, Domain::length, "size along z");
    v("top_x", s.top_x, Domain::length_or_zero, "size along x at y = size_y");
  }
  bool operator==(const WedgeOf&) const = default;
};

/// A circular cylinder about z, from z = 0 to z = height.
template <class N>
struct CylinderOf {
  static constexpr std::string_view kind = "cylinder";
  N radius{}, height{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("radius", s.radius, Domain::length, "radius");
    v("height", s.height, Domain::length, "height");
  }
  bool operator==(const CylinderOf&) const = default;
};

/// A cone or frustum about z, from z = 0 to z = height.
template <class N>
struct ConeOf {
  static constexpr std::string_view kind = "cone";
  N bottom_radius{}, top_radius{}, height{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("bottom_radius", s.bottom_radius, Domain::length_or_zero, "radius at z = 0");
    v("top_radius", s.top_radius, Domain::length_or_zero, "radius at z = height");
    v("height", s.height, Domain::length, "height");
  }
  bool operator==(const ConeOf&) const = default;
};

/// A ball about the origin.
template <class N>
struct SphereOf {
  static constexpr std::string_view kind = "sphere";
  N radius{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("radius", s.radius, Domain::length, "radius");
  }
  bool operator==(const SphereOf&) const = default;
};

/// An ellipsoid about the origin with its axes along x, y, z.
template <class N>
struct EllipsoidOf {
  static constexpr std::string_view kind = "ellipsoid";
  N radius_x{}, radius_y{}, radius_z{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("radius_x", s.radius_x, Domain::length, "half axis along x");
    v("radius_y", s.radius_y, Domain::length, "half axis along y");
    v("radius_z", s.radius_z, Domain::length, "half axis along z");
  }
  bool operator==(const EllipsoidOf&) const = default;
};

/// A ring torus about z, its centre circle in z = 0; minor_radius < major_radius.
template <class N>
struct TorusOf {
  static constexpr std::string_view kind = "torus";
  N major_radius{}, minor_radius{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("major_radius", s.major_radius, Domain::length, "radius of the centre circle");
    v("minor_radius", s.minor_radius, Domain::length, "radius of the tube");
  }
  bool operator==(const TorusOf&) const = default;
};

/// Equation (5) of Koivunen, Vezien, Bajcsy 1993: ((x/a1)^(2/e2) + (y/a2)^(2/e2))^(e2/e1) + (z/a3)^(2/e1) = 1,
/// then tapered: x (taper_x z / a3 + 1), y (taper_y z / a3 + 1); then bent towards +x in the x-z plane (Solina and
/// Bajcsy 1990) with the curvature k = bend / a3, so that the z axis becomes an arc about (1/k, 0) that turns by `bend`
/// over a3: (x, z) goes to (1/k - (1/k - x) cos(k z), (1/k - x) sin(k z)).
template <class N>
struct SuperellipsoidOf {
  static constexpr std::string_view kind = "superellipsoid";
  N a1{}, a2{}, a3{}, e1 = 1, e2 = 1, taper_x = 0, taper_y = 0, bend = 0;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("a1", s.a1, Domain::length, "half size along x");
    v("a2", s.a2, Domain::length, "half size along y");
    v("a3", s.a3, Domain::length, "half size along z");
    v("e1", s.e1, Domain::exponent, "squareness in latitude");
    v("e2", s.e2, Domain::exponent, "squareness in longitude");
    v("taper_x", s.taper_x, Domain::taper, "growth of x along z");
    v("taper_y", s.taper_y, Domain::taper, "growth of y along z");
    v("bend", s.bend, Domain::angle, "angle by which the z axis is bent towards +x over a3", 0.0);
  }
  bool operator==(const SuperellipsoidOf&) const = default;
};

/// A torus with superelliptic ring and tube (Barr 1981 with a1 = a2 = minor_radius, a3 = half_height and
/// a4 = major_radius / minor_radius): |(r - major_radius) / minor_radius|^(2/e1) + |z / half_height|^(2/e1) = 1 with
/// r = (|x|^(2/e2) + |y|^(2/e2))^(e2/2); minor_radius < major_radius.
template <class N>
struct SupertoroidOf {
  static constexpr std::string_view kind = "supertoroid";
  N major_radius{}, minor_radius{}, half_height{}, e1 = 1, e2 = 1;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("major_radius", s.major_radius, Domain::length, "radius of the ring's centre line along x and y");
    v("minor_radius", s.minor_radius, Domain::length, "half width of the tube along x and y");
    v("half_height", s.half_height, Domain::length, "half height of the tube");
    v("e1", s.e1, Domain::exponent, "squareness of the tube");
    v("e2", s.e2, Domain::exponent, "squareness of the ring");
  }
  bool operator==(const SupertoroidOf&) const = default;
};

/// What fills the inner corner between two faces at a right angle: legs along x (width) and y (height) from the origin,
/// a concave quarter of an ellipse about (width, height) between their ends, z from 0 to length.
template <class N>
struct FilletOf {
  static constexpr std::string_view kind = "fillet";
  N width{}, height{}, length{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("width", s.width, Domain::length, "leg along x");
    v("height", s.height, Domain::length, "leg along y");
    v("length", s.length, Domain::length, "length along z");
  }
  bool operator==(const FilletOf&) const = default;
};

/// The points p with normal . p <= offset.
template <class N>
struct HalfSpaceOf {
  N normal_x{}, normal_y{}, normal_z{}, offset{};
  std::string name;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("normal_x", s.normal_x, Domain::component, "outward unit normal");
    v("normal_y", s.normal_y, Domain::component, "outward unit normal");
    v("normal_z", s.normal_z, Domain::component, "outward unit normal");
    v("offset", s.offset, Domain::coordinate, "distance of the plane from the origin along its normal");
    v("name", s.name, "role of the face");
  }
  bool operator==(const HalfSpaceOf&) const = default;
};

/// A convex polyhedron: the bounded, non-empty intersection of half-spaces.
template <class N>
struct HalfSpacesOf {
  static constexpr std::string_view kind = "half_spaces";
  std::vector<HalfSpaceOf<N>> planes;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("planes", s.planes, "the faces");
  }
  bool operator==(const HalfSpacesOf&) const = default;
};

/// The sketch (x, y) moved along z from -below to height. With a draft its walls lean inwards as they rise: at height z
/// the outline is the sketch moved into the material by z tan(draft), its corners mitred (model/draft.h).
template <class N>
struct ExtrudeOf {
  static constexpr std::string_view kind = "extrude";
  SketchOf<N> sketch;
  N height{}, below = 0, draft = 0;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("sketch", s.sketch, "outline in the x-y plane");
    v("height", s.height, Domain::length, "length along z");
    v("below", s.below, Domain::length_or_zero, "length against z, below the plane of the sketch", 0.0);
    v("draft", s.draft, Domain::angle, "angle by which the walls lean inwards as z rises", 0.0);
  }
  bool operator==(const ExtrudeOf&) const = default;
};

/// The sketch (radius, z) turned about the z axis from x towards y, by a full turn or less; all radii >= 0.
template <class N>
struct RevolveOf {
  static constexpr std::string_view kind = "revolve";
  SketchOf<N> sketch;
  N angle = 2 * pi;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("sketch", s.sketch, "profile: first coordinate the radius, second along the axis");
    v("angle", s.angle, Domain::turn, "how far it is turned", 2 * pi);
  }
  bool operator==(const RevolveOf&) const = default;
};

/// A face of a triangulated body that lies on one surface.
struct TriFace {
  std::string name;             ///< "bore"; unique in its body
  std::string surface;          ///< "plane", "cylinder", "cone", "sphere", "torus"; empty: free form, its triangles
  int triangles = 0;            ///< how many of the list, after those of the faces before, belong to it
  bool hollow = false;          ///< of round surfaces: the material is outside, as around a hole
  std::vector<double> point{};  ///< mm: on the plane, on the axis (of a cone where the radius is taken), the centre
  std::vector<double> axis{};   ///< unit: outward normal, axis, of a cone towards its wide end; none of a sphere
  std::vector<double> sizes{};  ///< mm and rad: radius; of a cone radius, half angle; of a torus ring, tube
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("name", s.name, "role of the face");
    v("surface", s.surface, "plane, cylinder, cone, sphere or torus; left out: free form");
    v("triangles", s.triangles, "how many triangles of the list belong to it, after those of the faces before");
    v("hollow", s.hollow, "true: the material is outside of the round surface");
    v("point", s.point, "on the plane or axis, or the centre");
    v("axis", s.axis, "normal or axis");
    v("sizes", s.sizes, "radius; of a cone radius and half angle, of a torus the radii of ring and tube");
  }
  bool operator==(const TriFace&) const = default;
};

/// A triangulation: a solid if `closed`, a sheet otherwise.
template <class N>
struct TriSurfaceOf {
  static constexpr std::string_view kind = "tri_surface";
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
  bool closed = true;
  N thickness{};  ///< a sheet becomes a solid of this thickness, behind it, where a program knows only solids
  /// Of a closed one: the surfaces that its triangles stand for; corners between faces lie on theirs. May be empty.
  std::vector<TriFace> faces{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("vertices", s.vertices, "corners");
    v("triangles", s.triangles, "three vertex indices each, counter-clockwise seen from outside");
    v("closed", s.closed, "true: bounds a solid");
    v("thickness", s.thickness, Domain::length_or_zero, "of the solid made from an open sheet");
    v("faces", s.faces, "surfaces that the triangles stand for");
  }
  bool operator==(const TriSurfaceOf&) const = default;
};

/// One piece of the border of a patch: a B-spline in its parameter plane.
struct PatchTrim {
  int loop = 0;  ///< pieces of one loop follow each other; loop 0 is the outline, the others are holes in it
  /// Two pieces with one number are one curve in space, and run against each other; one alone is a rim.
  int edge = 0;
  int degree = 1;
  std::vector<double> knots;                   ///< written out, ends repeated degree + 1 times
  std::vector<std::array<double, 2>> control;  ///< (u, v)
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("loop", s.loop, "0: the outline, counter-clockwise; 1 and more: holes, clockwise");
    v("edge", s.edge, "pieces with one number are one curve in space");
    v("degree", s.degree, "degree of the curve");
    v("knots", s.knots, "knots, repeated by their multiplicity");
    v("control", s.control, "control points (u, v)");
  }
  bool operator==(const PatchTrim&) const = default;
};

/// A B-spline surface, as far as its trims reach.
struct TrimmedPatch {
  std::string name;  ///< "face"; unique in its set
  int degree_u = 3, degree_v = 3;
  std::vector<double> knots_u, knots_v;        ///< written out, ends repeated degree + 1 times
  std::vector<std::array<double, 3>> control;  ///< mm; v runs fastest
  std::vector<double> weights{};               ///< as many; left out: all 1
  std::vector<PatchTrim> trims;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("name", s.name, "role of the patch");
    v("degree_u", s.degree_u, "degree along u");
    v("degree_v", s.degree_v, "degree along v");
    v("knots_u", s.knots_u, "knots along u, repeated by their multiplicity");
    v("knots_v", s.knots_v, "knots along v, repeated by their multiplicity");
    v("control", s.control, "control points, those of one u after those of the one before");
    v("weights", s.weights, "of the control points; left out: all 1");
    v("trims", s.trims, "pieces of the border");
  }
  bool operator==(const TrimmedPatch&) const = default;
};

/// B-spline surfaces joined along common edges: a solid if `closed`, a sheet otherwise. Fronts, where the derivatives
/// along u and v and the normal form a right-handed system, are outside.
template <class N>
struct SurfaceSetOf {
  static constexpr std::string_view kind = "surface_set";
  std::vector<TrimmedPatch> patches;
  bool closed = false;
  N thickness{};  ///< a sheet becomes a solid of this thickness, behind it, where a program knows only solids
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("patches", s.patches, "the surfaces");
    v("closed", s.closed, "true: bounds a solid");
    v("thickness", s.thickness, Domain::length_or_zero, "of the solid made from an open sheet");
  }
  bool operator==(const SurfaceSetOf&) const = default;
};

/// Earlier objects, all together.
template <class N>
struct UnionOf {
  static constexpr std::string_view kind = "union";
  std::vector<std::string> objects;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("objects", s.objects, "names of earlier objects");
  }
  bool operator==(const UnionOf&) const = default;
};

/// The first of several earlier objects without the others.
template <class N>
struct DifferenceOf {
  static constexpr std::string_view kind = "difference";
  std::vector<std::string> objects;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("objects", s.objects, "names of earlier objects; the first is cut by the others");
  }
  bool operator==(const DifferenceOf&) const = default;
};

/// What earlier objects have in common.
template <class N>
struct IntersectionOf {
  static constexpr std::string_view kind = "intersection";
  std::vector<std::string> objects;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("objects", s.objects, "names of earlier objects");
  }
  bool operator==(const IntersectionOf&) const = default;
};

}  // namespace partscribe::model
