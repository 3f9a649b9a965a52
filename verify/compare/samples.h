/// Even, repeatable samples of a triangle mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::verify {

/// Each sample stands for the same area: area(mesh) / samples.
struct SurfaceSample {
  Vec3 point;
  std::uint32_t triangle;
};

/// `count` samples at equal steps of accumulated area, placed inside their triangle by a low-discrepancy sequence.
std::vector<SurfaceSample> even_samples(const TriangleMesh& mesh, std::size_t count);

}  // namespace partscribe::verify
