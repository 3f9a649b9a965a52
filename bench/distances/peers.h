/// The peers of the distance measurement behind one small interface, so that their compiler flags stay their own.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace peers {

/// A library that answers nearest-point queries one by one.
class Peer {
 public:
  virtual ~Peer() = default;
  /// Unsigned distances of queries[begin, end). `warm`: each search starts from the answer of the one before.
  virtual void distances(const std::vector<partscribe::geometry::Vec3>& queries, std::size_t begin, std::size_t end,
                         bool warm, double* out) const = 0;
  virtual std::size_t bytes() const = 0;  ///< held for searching, without the mesh itself; 0: not known
};

/// Null where the library is not installed.
std::unique_ptr<Peer> embree(const partscribe::geometry::TriangleMesh& mesh);
std::unique_ptr<Peer> cgal(const partscribe::geometry::TriangleMesh& mesh);

}  // namespace peers
