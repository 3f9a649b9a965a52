/// Brings the views of one part into one frame, and says how sure that is or why it cannot be done.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/result.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::scan {

/// One view in its own frame. With rays, the sensor is the place where they meet or the direction that they share;
/// with pixels and the size of the image, borders count as occluding contours. What is missing is estimated.
struct RegisterView {
  std::string name;
  PointCloud cloud;            ///< normals, rays, sigma, pixel and rejected where they are known; `view` is not read
  std::vector<Vec3> measured;  ///< where each point was before a filter moved it; empty: where it is
  int width = 0, height = 0;   ///< pixels, 0 for unorganised points
  std::optional<Pose> guess;   ///< world_from_view, roughly
};

/// What is known of the poses beforehand.
enum class Arrangement {
  guessed,    ///< every view has a guess
  unknown,    ///< nothing: the poses follow from features
  turntable,  ///< the part (or the sensor) was turned about one axis between the views, in their order; by equal steps
              ///< if it is not round
};

enum class PairMethod {
  symmetric,  ///< voxels for the basin, then symmetric planes with a Welsch kernel, then all views together
  paper,      ///< constrained iterative closest point as published in 1993, one view after the other; planar patches
  paper_triangles,  ///< the same for free form: coarse triangles' centres against the triangulated surface so far
};

struct RegisterOptions {
  Arrangement arrangement = Arrangement::guessed;
  PairMethod method = PairMethod::symmetric;
  double guess_angle = 0.35;       ///< rad; a view that would turn farther from its guess is refused
  double guess_shift = 0;          ///< mm at the middle of the part; 0: 0.35 of its diagonal
  double tolerance = 0;            ///< mm; a view whose sigma exceeds a quarter of it is refused; 0: no such demand
  double min_overlap = 0.15;       ///< share of a view's points that other views must confirm
  double max_seen_through = 0.05;  ///< share of a view's points that another view may have looked through
  double max_unanswered = 0.25;    ///< share of a view's points that face another sensor which returned nothing there
  bool contours = true;            ///< borders of range images fix what surfaces leave free; doubles the time
  bool correct_depth = false;  ///< turntable: depths are made to fit widths where a round part shows that they do not
  int samples = 2500;          ///< points of a view used in the joint adjustment; more is slower
};

enum class ViewStatus {
  reference,  ///< where it was; the others are placed against it
  registered,
  refused,  ///< the pose is only the best that was found: do not use it
};

using Mat6 = Eigen::Matrix<double, 6, 6>;

struct RegisteredView {
  Pose world_from_view;
  /// Of the rotation vector about Registration::center (rad) and the shift (mm) in world axes, against the reference.
  /// Free motions are left out of it.
  Mat6 covariance = Mat6::Zero();
  double overlap = 0;          ///< share of its points that at least one other view confirms
  double residual_median = 0;  ///< of |distance| along the normal, mm
  double seen_through = 0;     ///< largest share of its points that any other view looked through
  ViewStatus status = ViewStatus::refused;
  std::string reason;  ///< in words; empty for a view without trouble
};

/// A motion of one or several views that the data do not fix; along it they stay at their guess.
struct FreeMotion {
  std::vector<std::size_t> views;
  bool turns = false;                              ///< about the axis through `point`; else slides along it
  Vec3 axis = Vec3::Zero(), point = Vec3::Zero();  ///< world frame
  std::string words;                               ///< "views 2, 3 turn about (0, 0, 1) through (0, 0, 5)"
};

/// Views that fit as well somewhere else, for a turn lays the part onto itself as far as they show it.
struct AlikePlaces {
  std::vector<std::size_t> views;
  double angle = 0;                                ///< rad, right-handed about the axis through `point`
  Vec3 axis = Vec3::Zero(), point = Vec3::Zero();  ///< world frame
  std::string words;  ///< "views 2, 3 fit as well turned by 180 degrees about (0, 0, 1) through (0, 0, 5)"
};

/// What a turntable did; in the frame of the first view.
struct Turntable {
  Vec3 axis, point;       ///< unit direction, and its point nearest to the middle of the first view
  double step = 0;        ///< rad, from each view to the next, right-handed about the axis; the mean if they differ
  double step_sigma = 0;  ///< rad; infinite if only the order of the views says it
  bool step_observed =
      false;  ///< false: the part is round and smooth about the axis, the step is the one of a full turn
  std::vector<double> steps;  ///< rad, each; empty if they are equal
};

/// What makes depths fit widths in the frame of a sensor: p becomes center + linear (p - center), which adds to the
/// depth `stretch` for each mm of depth and `shear` for each mm of width. Nothing tells whether depths or widths are
/// wrong; widths are left as they are.
struct DepthCorrection {
  Mat3 linear = Mat3::Identity();
  Vec3 center = Vec3::Zero();
  double stretch = 0, shear = 0;
  double stretch_sigma = 0, shear_sigma = 0;
  Vec3 operator*(const Vec3& p) const { return center + linear * (p - center); }
};

struct Registration {
  std::vector<RegisteredView> views;
  Vec3 center = Vec3::Zero();  ///< middle of the part in the world frame
  /// 6 n x 6 n: of all views together, each as in its own `covariance`; views with one neighbour in common err
  /// together. Along free motions a fiftieth of the part's size.
  Eigen::MatrixXd covariance;
  double worst_gap = 0;  ///< largest median distance between two overlapping views, mm
  std::vector<FreeMotion> free_motions;
  std::vector<AlikePlaces>
      alike;  ///< without guesses: these views lie in one of several places, and their surface is the same in all
  std::optional<Turntable> turntable;
  std::optional<DepthCorrection>
      depth;  ///< of every view in its own frame, before its pose; only if it was asked for and is needed
  std::vector<std::string> warnings;
};

/// The views of a scan, each in its own frame with its pose as the guess. `measured`: where its points were before a
/// filter moved them, in the same order; empty: where they are.
std::vector<RegisterView> views_of(const Scan& scan, const std::vector<Vec3>& measured = {});

/// Moves the points, rays and normals of `scan` to the registered poses, with depths corrected where `registration`
/// says so; points of refused views are left out. The views of `registration` must be those of views_of(scan).
void place_views(const Registration& registration, Scan& scan);

/// Points of `cloud` (in the world, with normals and view) that would smear what is known: a free motion of their view
/// would move them along their normal, so that only the guess says where they lie, and within `reach` (mm) a view that
/// does not move so shows the same face. Where nobody else saw the face they stay: they are all there is. One entry per
/// point, 1 floats. A motion that most views share is taken as one of the others.
std::vector<std::uint8_t> floating_points(const Registration& registration, const PointCloud& cloud, double reach);

/// Fails for bad requests (no guess where one is needed, no points at all) and when cancelled; a view that cannot be
/// placed is refused with its reason, not an error. The first usable view is the reference. Same views, same bytes,
/// for any number of threads.
Result<Registration> register_views(const std::vector<RegisterView>& views, const RegisterOptions& options,
                                    Context& context);

}  // namespace partscribe::scan
