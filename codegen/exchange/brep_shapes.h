/// Single evaluated shapes as OpenCASCADE solids, each in its own frame.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "model/shapes.h"

class TopoDS_Shape;

namespace partscribe::codegen {

/// The shape, or a null shape where OpenCASCADE gives up. Booleans have no shape of their own.
TopoDS_Shape brep_of(const BoxOf<double>& shape);
TopoDS_Shape brep_of(const WedgeOf<double>& shape);
TopoDS_Shape brep_of(const CylinderOf<double>& shape);
TopoDS_Shape brep_of(const ConeOf<double>& shape);
TopoDS_Shape brep_of(const SphereOf<double>& shape);
TopoDS_Shape brep_of(const EllipsoidOf<double>& shape);
TopoDS_Shape brep_of(const TorusOf<double>& shape);
TopoDS_Shape brep_of(const HalfSpacesOf<double>& shape);
TopoDS_Shape brep_of(const ExtrudeOf<double>& shape);
TopoDS_Shape brep_of(const RevolveOf<double>& shape);
TopoDS_Shape brep_of(const TriSurfaceOf<double>& shape);

/// B-spline faces on common edges; curves in space lie within `tolerance` of those in the parameter planes.
TopoDS_Shape brep_of(const SurfaceSetOf<double>& shape, double tolerance);

/// A product of two piecewise cubic curves within `tolerance` of the superellipsoid; `error` is what was measured.
TopoDS_Shape brep_of(const SuperellipsoidOf<double>& shape, double tolerance, double& error);

/// Likewise: the tube's curve times the ring's.
TopoDS_Shape brep_of(const SupertoroidOf<double>& shape, double tolerance, double& error);

/// A closed surface of a body, or of a cavity in one.
struct ClosedShell {
  const TopoDS_Shape* shell = nullptr;  ///< kept by the caller
  double volume = 0;                    ///< mm^3, signed: negative for a cavity, whose faces look inward
  Box3 bounds;
};

/// A solid for each body, cavities cut out of the smallest one around them; a compound of several. A null shape if a
/// cavity has no body around it.
TopoDS_Shape solids_of(const std::vector<ClosedShell>& shells);

/// mm^2, of all faces.
double area_of(const TopoDS_Shape& shape);

/// Planar faces on shared corners and edges: one shell per connected piece. `closed`: solids, cavities cut out.
TopoDS_Shape brep_of_polygons(const std::vector<Vec3>& vertices,
                              const std::vector<std::vector<std::uint32_t>>& polygons, bool closed);

}  // namespace partscribe::codegen
