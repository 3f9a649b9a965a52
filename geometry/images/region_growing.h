/// Patches of one surface each, grown from flat seeds: planes first, second-order surfaces where a plane does not do.
#pragma once

#include <vector>

#include "core/context.h"
#include "geometry/normals/characterize.h"

namespace partscribe::geometry {

/// z = x0 + x1 u + x2 v (+ x3 u^2 + x4 uv + x5 v^2) in a frame of its own.
struct SurfacePatch {
  int order = 1;  ///< 1: plane, 2: second order
  Vec3 origin = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< columns u, v and the normal at the seed
  double coefficients[6] = {};   ///< mm, from the origin
  std::size_t points = 0;
  double rms = 0;  ///< of the residuals, in units of each point's noise

  double height(const Vec3& point) const;  ///< of a point above the patch along the axis, mm
  Vec3 normal(const Vec3& point) const;    ///< of the patch below or above a point
};

struct PatchOptions {
  std::size_t least_points = 60;  ///< smaller patches are not significant; their points stay without one
  double max_angle = 0.26;        ///< rad between a point's normal and the patch's, beyond what noise explains
  double max_deviations = 3.5;    ///< of a point's distance from the patch, in units of its noise
};

struct Patches {
  std::vector<SurfacePatch> patches;  ///< in the order found
  std::vector<int> label;             ///< per node, -1: none
};

Patches grow_patches(const SurfaceGraph& graph, const std::vector<CharacterizedPoint>& points,
                     const PatchOptions& options, Context& context);

/// The largest number of patches met along any row and any column of an image: what a spline mesh has to follow.
/// A patch counts once per stretch of at least `least_run` pixels; shorter ones are noise along a common border.
struct PatchCounts {
  int along_row = 0, along_column = 0;
};
PatchCounts most_patches(const std::vector<int>& label, int width, int height, int least_run = 6);

}  // namespace partscribe::geometry
