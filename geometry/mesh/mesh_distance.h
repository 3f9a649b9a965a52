/// Exact distances and rays against a triangle mesh, through one bounding-volume tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// The nearest place on a mesh.
struct MeshHit {
  double distance = 0;         ///< mm; negative only where a sign was asked for
  std::uint32_t triangle = 0;  ///< among equally near triangles the one of lowest index
  Vec3 point = Vec3::Zero();
};

/// Where a query ended, as a start for one close to it; belongs to one MeshDistance.
struct MeshHint {
  std::uint32_t triangle = ~0u, leaf = ~0u;
};

enum class Sign { none, inside_negative };

/// Built once over a mesh that the caller keeps alive; queries may run on many threads.
class MeshDistance {
 public:
  explicit MeshDistance(const TriangleMesh& mesh, int threads = 1);
  ~MeshDistance();
  MeshDistance(MeshDistance&&) noexcept;

  /// The mesh must have a triangle.
  MeshHit closest(const Vec3& query) const;
  /// As closest, when the answer is no farther than `bound`; nothing otherwise.
  std::optional<MeshHit> closest_within(const Vec3& query, double bound) const;
  /// Does the mesh come within `bound` of the query? Quick for queries close to the one that left the hint.
  bool comes_within(const Vec3& query, double bound, MeshHint& hint) const;
  /// Negative inside a closed, outward-facing mesh (angle-weighted pseudonormals, Baerentzen & Aanaes 2005).
  double signed_distance(const Vec3& query) const;
  /// The same, and where the nearest place is.
  double signed_distance(const Vec3& query, MeshHit& hit) const;

  /// The same answers as one by one, several times faster: queries are put in an order in which neighbours follow
  /// each other.
  std::vector<MeshHit> closest(std::span<const Vec3> queries, int threads, Sign sign = Sign::none) const;
  /// Hands every answer to `take(index, hit)`, in any order and on any thread. Needs some tens of MB for any number
  /// of queries.
  void for_each_closest(std::span<const Vec3> queries, int threads, Sign sign,
                        const std::function<void(std::size_t index, const MeshHit& hit)>& take) const;

  /// The first triangle met by origin + t * direction with t in (0, max_t]; `distance` is t.
  std::optional<MeshHit> first_hit(const Vec3& origin, const Vec3& direction, double max_t) const;

  /// Memory held for searching, without the mesh and without what signs need.
  std::size_t tree_bytes() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace partscribe::geometry
