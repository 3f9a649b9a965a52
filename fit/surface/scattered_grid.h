/// Scattered points resampled to the rectangular grid that a tensor product surface needs: by triangles and contours.
///
/// Koivunen, Vezien and Bajcsy 1993, section 3.2: "in the case of scattered samples, the points are typically organized
/// into triangular faces and then the contours, e.g., isoparametric lines, are interpolated". What comes out is for
/// published_surface(). Pieces of triangulations (piece_fit.h) are fitted at the places of their points instead, which
/// no interpolation changes.
#pragma once

#include <limits>
#include <vector>

#include "core/result.h"
#include "fit/surface/published_spline.h"

namespace partscribe::fit {

struct ScatteredGridOptions {
  int columns = 40, rows = 40;  ///< at least 2; finer than the points repeats what triangles say
  double inset = 0.5;           ///< steps between the points' ends across the rows and the first and last row, above 0
  /// mm in the plane; triangles with a longer edge are none: they span bays and windows of the outline. Rows run
  /// straight across what is missing inside of them.
  double longest_edge = std::numeric_limits<double>::infinity();
};

/// Points that are a height over the plane x, y of `world_from_plane`: their feet are Delaunay triangulated, each row
/// is the contour of the triangles at its y, and its columns are equal steps along it from where it enters the outline
/// to where it leaves it: the outline need not be a rectangle, and the last columns follow it. mm, in the world.
///
/// Between points the grid is straight: off a surface of curvature k by up to k s^2 / 8 for triangles of size s, which
/// are longest along the outline. Fails below three points that are not on a line, and where a row meets no triangle.
Result<PlaceGrid> grid_of_scattered(const std::vector<Vec3>& points, const Pose& world_from_plane,
                                    const ScatteredGridOptions& options);

}  // namespace partscribe::fit
