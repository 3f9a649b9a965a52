/// Axis and profile of a turned part as published in 1993: conics fitted to sections across an assumed axis.
///
/// Koivunen, Vezien and Bajcsy, section 3.3: "the actual model building process fits conic sections along the assumed
/// axis of symmetry to recover the rotation axis and the profile NURBS curve accurately". propose_revolves() finds the
/// axis by itself, profiles that fold back, and steps; here every section meets the profile once.
#pragma once

#include <vector>

#include "core/result.h"
#include "geometry/surfaces/ellipse_fit.h"
#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

struct PublishedRevolutionOptions {
  int sections = 40;       ///< of equal height; more follow the profile more closely, each holds fewer points
  double tolerance = 0.1;  ///< mm between profile and sections; above the noise of these
  int rounds = 20;         ///< at most; each is twice as near to the axis or better
};

/// The points of one slice across the axis.
struct ConicSection {
  double height = 0;     ///< mm along the axis, of its middle, from `point`
  PlaneEllipse conic;    ///< about the axis, in the plane x, y of rotation_onto_axis(direction)
  std::size_t held = 0;  ///< points
  double rms = 0;        ///< mm, of these from the conic
};

struct PublishedRevolution {
  Vec3 point = Vec3::Zero(), direction = Vec3::UnitZ();  ///< of the axis; at the middle of the points, and unit
  NurbsCurve<2> profile;                                 ///< (radius, height), mm, upwards; cubic
  std::vector<ConicSection> sections;                    ///< that counted, upwards
  int rounds = 0;                                        ///< until the axis stood still
  double profile_error = 0;                              ///< mm, the farthest section at equal parameters
};

/// Slices the points across the assumed axis, fits an ellipse to each slice, and lays a better axis through the
/// centres; from there again, until it stands still. The radii of the last ellipses become the profile.
///
/// Where the radius changes by r' per mm, the centre of a section that is tilted by the angle theta lies theta r r'
/// beside the axis; the line through the centres takes that into account. Sections that lie flatter than two in one
/// (steps, faces of ends), or whose points are far from any ellipse, do not count.
///
/// Fails if fewer than five sections hold an ellipse, or if their centres tell nothing of the axis, as those of a ball.
Result<PublishedRevolution> published_revolution(const std::vector<Vec3>& points, const Vec3& assumed_point,
                                                 const Vec3& assumed_direction,
                                                 const PublishedRevolutionOptions& options);

}  // namespace partscribe::fit
