/// All views at once: every pose is adjusted against its neighbours until nothing moves.
#pragma once

#include <vector>

#include "scan/register/register_surface.h"

namespace partscribe::scan {

struct JointOptions {
  double start_reach = 5;  ///< mm
  bool contours = true;
  int neighbours = 7;  ///< views that each view is held against
  int rounds = 50;
  bool roughly = false;  ///< poses alone, to a few tenths of a pixel: a few rounds, none with measured places
};

/// How far each view is fixed, and in which directions not.
struct JointResult {
  std::vector<Pose> poses;  ///< world_from_view
  /// 6 n x 6 n, view after view: rotation vector about `center` (rad), shift (mm); free motions left out.
  Eigen::MatrixXd covariance;
  Vec3 center = Vec3::Zero();
  double size = 1;  ///< mm; rms radius of the part, by which rotations are weighed
  /// Unit directions in the 6 n unknowns (rotation times `size`, shift; view after view) that nothing fixes.
  std::vector<Eigen::VectorXd> free_directions;
  double surface_sigma = 0;                    ///< of the distances between surfaces, mm
  double contour_sigma = 0, contour_bias = 0;  ///< pixels
  std::size_t surface_matches = 0, contour_matches = 0;
  std::vector<std::size_t> matches;      ///< of surface, of each view with any other
  std::vector<std::vector<double>> gap;  ///< median |distance| of each pair of views, mm; negative without overlap

  Mat6 covariance_of(std::size_t view) const {
    const auto i = static_cast<Eigen::Index>(6 * view);
    return covariance.block<6, 6>(i, i);
  }
};

/// The norm of the largest part of a direction, as in JointResult::free_directions, that any one view has.
double largest_of_a_view(const Eigen::VectorXd& direction);

/// Gauss-Newton on symmetric point-to-plane distances under Welsch weights, with the occluding contours of each view
/// against the faces that other views see edge-on to it. `views` are adjusted, the first of them stays.
/// A direction v counts as free when the distances change along it no more than noise in the normals explains:
/// v'Hv < 1.5 v'Mv (more for few matches). H sums w r r' over the rows r of the mean of two normals, M the same over
/// half their difference, less what the surface bends from one place to the other: where nothing fixes v the two have
/// the same expectation, whatever the noise and however it varies.
JointResult adjust_jointly(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                           const std::vector<std::size_t>& views, const JointOptions& options, Context& context);

}  // namespace partscribe::scan
