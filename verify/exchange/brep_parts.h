/// What an exact B-rep query works on: surfaces, their trims, edges, and the mesh that leads to them.
///
/// For the sources of the B-rep distance only; each includes OpenCASCADE's geometry (Geom_Curve, Geom_Surface and the
/// gp_ kinds used below) before this header, which so stays as light as all others.
#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "geometry/mesh/triangle_tree.h"
#include "geometry/surfaces/nurbs.h"
#include "verify/exchange/brep_distance.h"
#include "verify/exchange/trim_region.h"

namespace partscribe::verify {

/// A parameter's range; `period` 0: it does not close.
struct ParameterRange {
  double low = 0, high = 0, period = 0;
};

/// A face's surface; the last alternative stands for all kinds without a closed form or spline of their own.
struct BrepFace {
  std::variant<gp_Pln, gp_Cylinder, gp_Cone, gp_Sphere, gp_Torus, NurbsSurface, Handle(Geom_Surface)> surface;
  ParameterRange u, v;
  TrimRegion trim;
  bool reversed = false;

  bool closed_form() const { return surface.index() < 5; }
};

struct BrepEdge {
  std::variant<gp_Lin, gp_Circ, NurbsCurve<3>, Handle(Geom_Curve)> curve;
  double first = 0, last = 0;
  std::uint32_t face = 0;                                       ///< one of its faces
  std::uint32_t first_segment = 0, segments = 0;                ///< in the order of the parameter
  Vec3 start_normal = Vec3::Zero(), end_normal = Vec3::Zero();  ///< angle-weighted, of its end vertices

  bool closed_form() const { return curve.index() < 2; }
};

/// A chord of an edge.
struct BrepSegment {
  std::uint32_t edge = 0;
  double t0 = 0, t1 = 0;
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  Vec3 normal_a = Vec3::Zero(), normal_b = Vec3::Zero();  ///< sums of the normals of the faces that meet there
  double slack = 0;                                       ///< the edge stays so close to it
};

constexpr std::uint32_t no_segment = ~0u;

struct BrepTriangle {
  std::uint32_t face = 0;
  std::array<Vec2, 3> uv;
  std::array<std::uint32_t, 3> segment{no_segment, no_segment, no_segment};  ///< of side k, from corner k
  double slack = 0;  ///< the part of the face that it stands for stays so close to it
};

struct BrepDistance::Parts {
  std::vector<BrepFace> faces;
  std::vector<BrepEdge> edges;
  std::vector<BrepSegment> segments;
  TriangleMesh mesh;
  std::vector<BrepTriangle> triangles;  ///< beside mesh.triangles
  TriangleTree tree;
  double most_slack = 0;
};

/// The place of parameters, with derivatives; parameters of closed surfaces may lie whole turns away.
SurfacePoint surface_point(const BrepFace& face, double u, double v);
struct CurvePoint {
  Vec3 p, d1, d2;  ///< place and derivatives
};
CurvePoint curve_point(const BrepEdge& edge, double t);

/// Throws OpenCASCADE's exceptions; null as BrepDistance::make.
std::unique_ptr<BrepDistance::Parts> collect_brep_parts(const TopoDS_Shape& shape);

/// The nearest place of a flat triangle, as weights of its corners.
struct TriangleFoot {
  double sq_distance;
  Vec3 weights;
};
TriangleFoot nearest_in_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p);

/// The nearest place that follows from one surface or one edge alone.
struct SurfaceFoot {
  Vec3 point, normal;  ///< normal outward, not of unit length
};
/// Where the surface is nearest, if that is inside the face's trim; `start`: parameters close to it.
std::optional<SurfaceFoot> foot_on_face(const BrepFace& face, const Vec3& query, const Vec2& start);

struct CurveFoot {
  Vec3 point;
  double t;
  int end;  ///< -1: at the edge's start, 1: at its end, 0: between
};
CurveFoot foot_on_edge(const BrepEdge& edge, const Vec3& query, double start);

}  // namespace partscribe::verify
