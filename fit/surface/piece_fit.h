/// One piece of a surface that lies open in a plane, fitted as a B-spline surface.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fit/candidate.h"
#include "fit/surface/spline_fit.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/surfaces/trimmed_surface.h"

namespace partscribe::fit {

/// Of the tolerance, what a fit may leave; the rest is for rounding and trims.
inline constexpr double fit_share = 0.7;

/// Where a point of a triangle goes in the layout of its mesh (`places` of the vertices).
Vec2 place_on(const TriangleMesh& mesh, std::span<const Vec2> places, std::size_t triangle, const Vec3& point);

/// The surface through points of a scan over a box a little larger than their places, which is whole multiples of what
/// is printed. Nothing where it would take too many control points; the log says so.
std::optional<SplineFit> fit_piece(const SplineData& data, const FitInput& input, Context& context);

/// The same for points of which the last `data.held` lie on edges and are to be met within `held_tolerance`
/// (mm), beginning with the surface that was found before.
std::optional<SplineFit> fit_piece_again(const SplineData& data, const NurbsSurface& before, double held_tolerance,
                                         const FitInput& input, Context& context);

/// Numbers as they are printed: control points and parameters to some hundredth of the tolerance; trims stay
/// inside of the domain.
void round_numbers(TrimmedSurface& trimmed, double tolerance);

}  // namespace partscribe::fit
