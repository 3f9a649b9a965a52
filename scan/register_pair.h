/// One view against what is placed already: alignment from a start, and how well a pose agrees with the evidence.
#pragma once

#include <memory>
#include <vector>

#include "scan/register_surface.h"

namespace partscribe {

/// Oriented points in one frame.
struct Surfels {
  std::vector<Vec3> points, normals;
};

/// `count` of the samples of a view, in its own frame.
Surfels sample_surfels(const ViewSurface& surface, std::size_t count);

/// One oriented point for every cube of edge `cell` (mm) and direction, in the frame of the view.
Surfels thin_surfels(const ViewSurface& surface, double cell);

/// Placed surfaces as one set of oriented points, one per cube of edge `cell` and direction.
struct PlacedModel {
  Surfels surfels;               ///< world frame
  std::unique_ptr<KdTree> tree;  ///< over surfels.points
  double cell = 0;
};

/// Built in one go; `poses` are world_from_view.
std::unique_ptr<PlacedModel> place_surfaces(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                                            const std::vector<std::size_t>& views, double cell);

struct AlignOptions {
  double start_reach = 20;   ///< mm; how far apart partners may be at first; wider basins, more wrong partners
  double end_reach = 0.5;    ///< mm, in the last rounds
  double noise = 0.05;       ///< mm along the normal, of a difference
  int iterations = 60;
};

/// Symmetric point to plane (Rusinkiewicz 2019) under a Welsch kernel that narrows as the steps get small. Directions
/// that the partners leave free are not moved along.
Pose align_symmetric(const Surfels& source, const PlacedModel& target, const Pose& start, const AlignOptions& options);

struct PaperOptions {
  double normal_angle = 0.785398;  ///< rad
  double stop = 1e-6;              ///< mm; the least change of the root of the mean square error
  int iterations = 120;
};

/// A planar patch: the paper's primitive, and its centre of gravity the paper's point.
struct Patch {
  Vec3 center, normal;
  double area = 0;                        ///< mm^2, as the points cover it
  std::vector<std::uint32_t> members;     ///< points of the view
};

/// Patches grown by the consistency of normals; small ones are dropped as unstable. Where the surface is curved the
/// patches are what the paper's low-resolution triangles are: pieces of it of bounded size.
std::vector<Patch> planar_patches(const ViewSurface& surface, double angle, double most_radius);

/// The paper's constrained iterative closest point (section 2.1): e(q) = 1/N sum |x - R p - t|^2 by quaternions, x the
/// nearest point of the nearest plane of the model; invisible points, residuals above mean + 2 deviations of the last
/// state and normals off by more than `normal_angle` are left out until none is.
Pose align_paper(const std::vector<Patch>& source, const std::vector<Patch>& model_patches,
                 const std::vector<Vec3>& model_points, const std::vector<std::uint8_t>& visible, const Pose& start,
                 const PaperOptions& options);

/// What the other views say of a pose.
struct Agreement {
  int samples = 0;
  int confirmed = 0;     ///< of the view's samples: another view has the same surface there
  int through = 0;       ///< looked through by another view (the worst one)
  int back_through = 0;  ///< samples of others that the view itself looked through, scaled to its number of samples
  int missing = 0;       ///< faced by a sensor that returned nothing around them
  double residual = 0;   ///< median |distance| along the normal of the confirmed ones, mm
  double overlap() const { return samples ? double(confirmed) / samples : 0; }
  double seen_through() const { return samples ? double(std::max(through, back_through)) / samples : 0; }
  /// What ranks poses: confirmed less what contradicts.
  double score() const { return samples ? (confirmed - 3.0 * (through + back_through) - missing) / double(samples) : -1; }
};

/// `reach` is how far off a confirmed place may be along the normal, three times that across.
Agreement agreement(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses, std::size_t view,
                    const Pose& pose, const std::vector<std::size_t>& others, double reach, std::size_t samples);

/// The pose a share of the way from one to another along the screw that leads there.
Pose between(const Pose& a, const Pose& b, double share);

/// Rotation vector of a rotation, exact near 0 and near pi.
Vec3 rotation_vector(const Mat3& rotation);

}  // namespace partscribe
