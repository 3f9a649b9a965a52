/// Registration as published in 1993: constrained iterative closest point, one view after the other.
#pragma once

#include <vector>

#include "scan/register/register_start.h"

namespace partscribe::scan {

struct PaperOptions {
  double patch_angle = 0.12;       ///< rad; normals of one patch differ by no more
  double normal_angle = 0.785398;  ///< rad; alpha of the consistency of normals
  int iterations = 150;
};

/// A planar patch of a view: the paper's primitive, and its centre of gravity the paper's point. Where the surface is
/// curved, patches are pieces of bounded size, as its coarse triangles are.
struct Patch {
  Vec3 center = Vec3::Zero(), normal = Vec3::Zero();
  std::vector<std::uint32_t> members;  ///< points of the view
};

/// Grown by the consistency of normals; small ones are left out as unstable. Largest first.
std::vector<Patch> planar_patches(const ViewSurface& surface, const PaperOptions& options);

/// The rigid motion that lays `from` over `to` with the least sum of squares, by the quaternion that is the eigenvector
/// of the largest eigenvalue of N (Besl & McKay 1992).
Pose closest_motion(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// The first usable view is the model; each further view, in its order, is registered against the patches of those
/// before it from its guess and joins the model. Points that no earlier view can see by the guess, residuals above the
/// mean + 2 deviations of the last state and normals off by more than `normal_angle` are left out.
StartResult register_as_published(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                                  const PaperOptions& options, Context& context);

}  // namespace partscribe::scan
