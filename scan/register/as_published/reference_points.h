/// The points P of a view that are matched in 1993: centres of planar areas, or of the triangles of a coarse surface.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"
#include "scan/register/as_published/paper_options.h"
#include "scan/register/register_surface.h"

namespace partscribe::scan {

/// p_i and its normal n_p, in the frame of its view.
struct ReferencePoint {
  Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
};

/// A planar area of a view, through its points by least squares.
struct Patch {
  Vec3 center = Vec3::Zero(), normal = Vec3::Zero();
  std::vector<std::uint32_t> members;  ///< points of the view
};

/// Grown by the consistency of normals (section 4); small ones, as they occur beside creases, are left out as unstable.
/// Larger planar areas are pieces of bounded size: of a few whole faces the centres would not fix six numbers. Largest
/// first.
std::vector<Patch> planar_patches(const ViewSurface& surface, const PaperOptions& options);

/// The view's surface, Delaunay triangulated in its image, in its own frame, facing its sensor: one vertex for every
/// `cell` x `cell` pixels, nothing across creases and steps.
TriangleMesh triangulated_view(const ViewSurface& surface, double cell);

/// The finest such surface of at most `most` triangles.
TriangleMesh coarse_surface(const ViewSurface& surface, std::size_t most);

/// P of a view, with normals. Centres of coarse triangles are moved along the normal onto the surface as it was
/// measured: inside of where it bends they led views of a lump of 20 mm 7 degrees away from their true places, on it 1
/// degree.
std::vector<ReferencePoint> reference_points(const ViewSurface& surface, const PaperOptions& options);

}  // namespace partscribe::scan
