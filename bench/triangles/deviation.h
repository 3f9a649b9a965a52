/// How far two meshes are from each other, by the same places for every contestant.
#pragma once

#include <vector>

#include "geometry/mesh/mesh_distance.h"

namespace bench {

using namespace partscribe::geometry;

struct Deviation {
  double data_to_mesh = 0, mesh_to_data = 0;  ///< mm, the largest found
  double two_sided() const { return std::max(data_to_mesh, mesh_to_data); }
};

/// All vertices, places on edges no farther than `spacing` apart, and a net so fine on faces. In a fixed order.
std::vector<Vec3> places_on(const TriangleMesh& mesh, double spacing);

/// Keeps the places of the data, which must outlive it.
class DeviationFrom {
 public:
  DeviationFrom(const TriangleMesh& data, double spacing, int threads);
  Deviation of(const TriangleMesh& mesh) const;
  /// As of(mesh).two_sided() <= bound, and faster where it is not.
  bool within(const TriangleMesh& mesh, double bound) const;

 private:
  MeshDistance data_;
  std::vector<Vec3> places_;
  double spacing_;
  int threads_;
};

}  // namespace bench
