/// Shaded pictures of surfaces and meshes for the figures.
#pragma once

#include "cli/pictures/raster.h"
#include "geometry/mesh/triangle_mesh.h"
#include "scan/simulate/simulate.h"

namespace partscribe::cli {

/// The surface as seen by parallel rays from `to_eye`, filling a square picture of `side` pixels.
Raster lit_surface(const scan::Surface& surface, const Vec3& to_eye, const Vec3& up, int side);

/// A mesh, its edges drawn if `edges`; `color` before any light.
Raster lit_mesh(const TriangleMesh& mesh, const Vec3& to_eye, const Vec3& up, int side, bool edges,
                Color color = {176, 190, 210});

}  // namespace partscribe::cli
