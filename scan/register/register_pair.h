/// One view against what is placed already: alignment from a start, and how well a pose agrees with the evidence.
#pragma once

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include "geometry/normals/symmetric_planes.h"
#include "geometry/points/nearest_map.h"
#include "scan/register/register_surface.h"

namespace partscribe::scan {

/// Oriented points in one frame.
struct Surfels {
  std::vector<Vec3> points, normals;
};

/// `count` of the samples of a view, in its own frame.
Surfels sample_surfels(const ViewSurface& surface, std::size_t count);

/// `count` of the samples at equal strides: spread like the samples themselves, and quickly taken.
Surfels strided_surfels(const ViewSurface& surface, std::size_t count);
Surfels strided_surfels(const Surfels& all, std::size_t count);

/// One oriented point for every cube of edge `cell` (mm) and direction, in the frame of the view.
Surfels thin_surfels(const ViewSurface& surface, double cell);

/// Placed surfaces as one set of oriented points, one per cube of edge `cell` and direction.
struct PlacedModel {
  Surfels surfels;                      ///< world frame
  std::vector<OrientedPoint> oriented;  ///< the same
  std::unique_ptr<KdTree> tree;         ///< over surfels.points
  std::unique_ptr<NearestMap> map;      ///< where partners are looked up: faster, and only about the nearest
  double cell = 0;
};

/// Built in one go; `poses` are world_from_view. `mapped`: partners will be looked up.
std::unique_ptr<PlacedModel> place_surfaces(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                                            const std::vector<std::size_t>& views, double cell, bool mapped = false);

struct AlignOptions {
  double start_reach = 20;  ///< mm; how far apart partners may be at first; wider basins, more wrong partners
  double end_reach = 0.5;   ///< mm, in the last rounds
  double noise = 0.05;      ///< mm along the normal, of a difference
  int iterations = 60;
  double settled = 1e-4;       ///< steps of this share of end_reach are the last
  bool pure_rotation = false;  ///< about an axis that is found, without a shift along it
  double angle = 0;            ///< rad, of that rotation; 0: found as well
};

struct AlignPair {
  const Surfels* source;
  const PlacedModel* target;
};

/// Symmetric point to plane (Rusinkiewicz 2019) under a Welsch kernel that narrows as the steps get small. Directions
/// that the partners leave free are not moved along.
Pose align_symmetric(const Surfels& source, const PlacedModel& target, const Pose& start, const AlignOptions& options);
/// The one motion that lays every source over its target.
Pose align_symmetric(const std::vector<AlignPair>& pairs, const Pose& start, const AlignOptions& options);

/// A motion along which distances hardly change, for each mm that the view's points move in the mean.
struct WeakMotion {
  Vec3 center, turn, shift;  ///< world frame; rad about the center, mm
  Pose by(double mm) const {
    const Mat3 rotation = rotation_of(mm * turn);
    return {rotation, center - rotation * center + mm * shift};
  }
};

/// At most three, the weakest first; fixed by less than `weak` of what the best one is.
std::vector<WeakMotion> weak_motions(const Surfels& source, const PlacedModel& target, const Pose& pose, double reach,
                                     double noise, double weak);

/// What the other views say of a pose.
struct Agreement {
  int samples = 0;
  int confirmed = 0;     ///< of the view's samples: another view has the same surface there
  int through = 0;       ///< looked through by another view (the worst one)
  int back_through = 0;  ///< samples of others that the view itself looked through, scaled to its number of samples
  std::vector<int>
      missing_by;  ///< by each of the views: faced by a sensor that returned nothing around them, whoever was asked
  int faced = 0;   ///< lie where another view measured a surface and face its sensor, summed over the views
  int odd = 0;     ///< of these, with another surface there than the view's own
  double residual = 0;  ///< median |distance| along the normal of the confirmed ones, mm
  int missing() const { return missing_by.empty() ? 0 : std::ranges::max(missing_by); }  ///< by the worst one
  double disagreement() const { return faced ? double(odd) / faced : 0; }
  double overlap() const { return samples ? double(confirmed) / samples : 0; }
  double seen_through() const { return samples ? double(std::max(through, back_through)) / samples : 0; }
  /// What speaks against a pose, as a share of the samples; by all: with what is missing by each of the views, not by
  /// the worst one.
  double contradiction() const { return against(missing()); }
  double contradiction_by_all() const { return against(std::accumulate(missing_by.begin(), missing_by.end(), 0)); }
  /// What ranks poses: confirmed less what contradicts.
  double score() const { return samples ? overlap() - contradiction() : -1; }
  double unanswered() const { return samples ? double(missing()) / samples : 0; }

 private:
  double against(int unanswered) const {
    return samples ? (3.0 * (through + back_through) + unanswered) / double(samples) + disagreement() : 1;
  }
};

/// Whether another surface beside a crease speaks against a pose. At true poses places beside creases are most of what
/// does, for places and normals are of either side there or between them. Where nothing is known of the poses, of
/// blocks seen with few pixels, they are also most of what tells one place from another.
enum class Creases { count, left_out };

/// `reach` is how far off a confirmed place may be along the normal, three times that across.
Agreement agreement(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses, std::size_t view,
                    const Pose& pose, const std::vector<std::size_t>& others, double reach, std::size_t samples,
                    Creases creases = Creases::count);

/// Whether two poses put the middle of a view within `shift` (mm) of one place and turn it within `angle` (rad) alike.
bool same_place(const ViewSurface& surface, const Pose& a, const Pose& b, double angle, double shift);

/// The pose a share of the way from one to another along the screw that leads there.
Pose between(const Pose& a, const Pose& b, double share);

/// The line that a pure rotation leaves in place.
struct FixedLine {
  Vec3 point, axis;  ///< the point nearest to `near`
  double angle = 0;  ///< rad, right-handed about the axis
};
FixedLine fixed_line(const Pose& rotation, const Vec3& near);

/// The rotation about a line.
Pose rotation_about(const Vec3& point, const Vec3& axis, double angle);

/// Rotation vector of a rotation, exact near 0 and near pi.
Vec3 rotation_vector(const Mat3& rotation);

}  // namespace partscribe::scan
