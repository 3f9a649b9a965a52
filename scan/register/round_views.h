/// Views of a part that is round about an axis: where that axis is in each, and whether the sensor shows it round.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "scan/register/register_surface.h"

namespace partscribe::scan {

struct AxisLine {
  Vec3 point, axis;  ///< unit direction
};

/// How far a normal passes by an axis, as a sine; places nearer than `least` (mm) to it count as that far away.
double off_axis(const AxisLine& line, const Vec3& p, const Vec3& normal, double least);

/// Whether a place may be on what is round about the axis: loops of yarn and threads of screws are.
bool round_about(const AxisLine& line, const ViewSurface& surface, std::size_t place);

/// Radius over the place along the axis: the median of each of equal bins.
struct RadiusProfile {
  double start = 0, bin = 1;   ///< mm
  std::vector<double> radius;  ///< negative where too few points are

  /// Radius and slope between the middles of bins; nothing at gaps and shoulders.
  std::optional<std::pair<double, double>> at(double along) const;
};

/// The axis of one view, and the directions from which angles about it are counted.
struct AxisFrame {
  AxisLine line;
  Vec3 across, beside;  ///< right-handed with the axis
};

struct CylinderPlace {
  double along, radius, angle;  ///< mm, mm, rad from `across` towards `beside`
};
CylinderPlace place_about(const AxisFrame& frame, const Vec3& p);

/// All views in their own frames; the profile is the same in each, the axes are not: round parts seldom stand in the
/// middle of their table.
struct RoundViews {
  std::vector<AxisFrame> frames;
  RadiusProfile profile;
  double width = 0;       ///< mm, of the kernel exp(-e^2 / 2 width^2) under which a point belongs to the profile
  double median_off = 0;  ///< mm, of the points from the profile
  DepthCorrection depth;  ///< in which all of this is
};

struct RoundFits {
  RoundViews raw;                     ///< as measured
  std::optional<RoundViews> rounder;  ///< with depths corrected, where that makes the part clearly rounder
};

/// Axes and profile by Gauss-Newton under Welsch weights, from an axis that holds for all views roughly; then with the
/// stretch and shear of the depth that make the part round in all views. They are the sensor's, since the part turned
/// between the views and they did not. Not found where the sensor looks along the axis.
RoundFits round_views(const std::vector<ViewSurface>& surfaces, const AxisLine& axis);

}  // namespace partscribe::scan
