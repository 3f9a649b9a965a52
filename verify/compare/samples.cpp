#include "verify/compare/samples.h"

#include <Eigen/Geometry>
#include <cmath>

namespace partscribe::verify {

std::vector<SurfaceSample> even_samples(const TriangleMesh& mesh, std::size_t count) {
  std::vector<SurfaceSample> samples;
  const double total = area(mesh);
  if (!(total > 0) || count == 0) return samples;
  samples.reserve(count);
  const double step = total / static_cast<double>(count);
  double passed = 0;
  std::size_t number = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0), ab = mesh.corner(t, 1) - a, ac = mesh.corner(t, 2) - a;
    passed += 0.5 * ab.cross(ac).norm();
    while (number < count && (static_cast<double>(number) + 0.5) * step <= passed) {
      // The additive sequence of the plastic number (Roberts 2018) fills the unit square evenly.
      double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(number), 1.0);
      double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(number), 1.0);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      samples.push_back({a + u * ab + v * ac, t});
      ++number;
    }
  }
  return samples;
}

}  // namespace partscribe::verify
