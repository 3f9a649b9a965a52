/// How the geometry of a procedure is held; for the .cpp files behind scl_geometry.h only.
#pragma once

#include <cstdint>

#include "geometry/surfaces/trimmed_surface.h"
#include "verify/scl/scl_geometry.h"

class TopoDS_Shape;

namespace partscribe::verify {

/// Ends nearer than this (mm) meet.
inline constexpr double scl_join = 1e-6;

/// Curves are edges, profiles wires, surfaces faces or trimmed surfaces; a shell is a shape, flat facets or trimmed
/// surfaces.
struct SclGeometry {
  SclGeometryKind kind = SclGeometryKind::shell;
  std::shared_ptr<const TopoDS_Shape> shape;
  std::vector<Vec3> corners;                       ///< of the facets
  std::vector<std::vector<std::uint32_t>> facets;  ///< flat, convex; instead of `shape`
  std::vector<TrimmedSurface> trimmed;             ///< likewise
  std::vector<SclGeometryPtr> members;             ///< of a group
  std::size_t leaves = 1;                          ///< objects in a group, through all levels
  bool solid = false;
  bool natural = false;  ///< `shape` is one B-spline surface in its whole domain
};

/// The same geometry as a boundary representation: facets become plane faces.
Result<TopoDS_Shape> brep_of(const SclGeometry& geometry);
/// Triangles of the one B-spline surface of a `natural` geometry.
SclMesh surface_mesh(const SclGeometry& geometry, double deviation);
/// Fan triangles of the facets.
TriangleMesh facet_mesh(const SclGeometry& geometry);
/// A shell of surfaces within borders; borders that run against each other are one edge.
SclMade trimmed_shell(const std::vector<SclGeometryPtr>& surfaces);
/// A shell of facets given by corner indices; outward if it closes.
SclMade facet_shell(std::vector<Vec3> corners, std::vector<std::vector<std::uint32_t>> facets);

}  // namespace partscribe::verify
