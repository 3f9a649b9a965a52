/// Exact signed distances from points to the trimmed surfaces of a boundary representation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "geometry/vec.h"

class TopoDS_Shape;

namespace partscribe::verify {

/// The nearest place on a shape's faces.
struct BrepHit {
  double distance = 0;     ///< mm; negative inside a solid whose faces point outward
  std::uint32_t face = 0;  ///< in the order of TopExp_Explorer
  Vec3 point = Vec3::Zero();
};

/// A coarse mesh of the faces leads to the few surfaces and edges that can be nearest; on those the foot is computed:
/// in closed form on planes, cylinders, cones, spheres, tori, lines and circles, by Newton's method elsewhere. Keeps
/// what it needs of the shape; queries may run on many threads.
class BrepDistance {
 public:
  /// Null if a face cannot be meshed or has no usable surface, or if places on the faces are not found again: then only
  /// a mesh can be asked.
  static std::shared_ptr<const BrepDistance> make(const TopoDS_Shape& shape);
  ~BrepDistance();

  BrepHit closest(const Vec3& query) const;
  std::vector<BrepHit> closest(std::span<const Vec3> queries, int threads) const;
  /// Hands every answer to `take(index, hit)`, in any order and on any thread.
  void for_each_closest(std::span<const Vec3> queries, int threads,
                        const std::function<void(std::size_t index, const BrepHit& hit)>& take) const;

  std::size_t faces() const;

  struct Parts;  ///< defined in the .cpp files

 private:
  explicit BrepDistance(std::unique_ptr<Parts> parts);
  bool knows_its_faces() const;  ///< the middle of every triangle's part of its face lies on the shape
  std::unique_ptr<Parts> parts_;
};

}  // namespace partscribe::verify
