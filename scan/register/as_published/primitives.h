/// The primitives of a model of 1993, and the closest point on the closest of them (sections 2.1.1 and 2.1.2).
///
/// The matching knows nothing of what a model is made of: it asks for the closest point, and the type of the primitive
/// defines the distance.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/kd_tree.h"
#include "scan/register/as_published/reference_points.h"

namespace partscribe::scan {

/// x_i: the closest point of the closest primitive.
struct ClosestPoint {
  Vec3 place = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< n_x, of the primitive
};

/// What has been registered so far, in the world; empty to begin with.
class PublishedModel {
 public:
  virtual ~PublishedModel() = default;
  /// Adds what a view shows, at its registered pose.
  virtual void add(const ViewSurface& surface, const Pose& world_from_view) = 0;
  /// Something must have been added.
  virtual ClosestPoint closest(const Vec3& p) const = 0;
  virtual std::size_t primitives() const = 0;
};

/// Primitives are planar patches. A patch ends where its points do: the closest point is the foot on its plane if that
/// lies among them, else the nearest of them, on the plane.
std::unique_ptr<PublishedModel> model_of_patches(const PaperOptions& options);

/// Primitives are the triangles of one Delaunay triangulated surface per view; of each further view only those that lie
/// where the model has no surface yet.
std::unique_ptr<PublishedModel> model_of_triangles(const PaperOptions& options);

}  // namespace partscribe::scan
