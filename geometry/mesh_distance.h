/// Exact distances and rays against a triangle mesh, through one bounding-volume tree.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "geometry/triangle_mesh.h"

namespace partscribe {

/// The nearest place on a mesh.
struct MeshHit {
  double distance = 0;         ///< mm, never negative
  std::uint32_t triangle = 0;  ///< among equally near triangles the one of lowest index
  Vec3 point = Vec3::Zero();
};

/// Built once over a mesh that the caller keeps alive; queries may run on many threads.
class MeshDistance {
 public:
  explicit MeshDistance(const TriangleMesh& mesh);
  ~MeshDistance();
  MeshDistance(MeshDistance&&) noexcept;

  /// The mesh must have a triangle.
  MeshHit closest(const Vec3& query) const;
  /// As closest, when the answer is no farther than `bound`; nothing otherwise.
  std::optional<MeshHit> closest_within(const Vec3& query, double bound) const;
  /// Negative inside a closed, outward-facing mesh (angle-weighted pseudonormals, Baerentzen & Aanaes 2005).
  double signed_distance(const Vec3& query) const;
  /// The same, and where the nearest place is.
  double signed_distance(const Vec3& query, MeshHit& hit) const;
  /// The first triangle met by origin + t * direction with t in (0, max_t]; `distance` is t.
  std::optional<MeshHit> first_hit(const Vec3& origin, const Vec3& direction, double max_t) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace partscribe
