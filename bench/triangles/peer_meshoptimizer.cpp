// meshoptimizer: its simplifiers by count and by its own error; it is handed floats from the middle of the mesh.
#include "bench/triangles/peers.h"

#ifdef PARTSCRIBE_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>

#include <cfloat>
#endif

namespace bench {
#ifdef PARTSCRIBE_HAS_MESHOPTIMIZER
namespace {

struct FloatMesh {
  explicit FloatMesh(const TriangleMesh& source) : middle(source.bounds().center()) {
    for (const Vec3& v : source.vertices)
      for (int k = 0; k < 3; ++k) positions.push_back(float(v[k] - middle[k]));
    for (const auto& t : source.triangles) indices.insert(indices.end(), t.begin(), t.end());
  }
  static constexpr std::size_t stride = 3 * sizeof(float);
  std::size_t vertices() const { return positions.size() / 3; }
  float relative(double error) const {  // to the size of the mesh; 0: no bound
    return error > 0 ? float(error / meshopt_simplifyScale(positions.data(), vertices(), stride)) : FLT_MAX;
  }
  Vec3 middle;
  std::vector<float> positions;
  std::vector<unsigned> indices;
};

TriangleMesh from_indices(std::vector<Vec3> vertices, const std::vector<unsigned>& left) {
  TriangleMesh result;
  result.vertices = std::move(vertices);
  for (std::size_t i = 0; i + 2 < left.size(); i += 3) result.triangles.push_back({left[i], left[i + 1], left[i + 2]});
  return welded(result, 0);
}

/// `error`: mm. Corners are corners of the source, in double.
Simplified simplified_by_meshoptimizer(const TriangleMesh& source, std::size_t count, double error) {
  const FloatMesh mesh(source);
  std::vector<unsigned> left(mesh.indices.size());
  const double before = processor_seconds();
  left.resize(meshopt_simplify(left.data(), mesh.indices.data(), left.size(), mesh.positions.data(), mesh.vertices(),
                               mesh.stride, 3 * count, mesh.relative(error), 0, nullptr));
  const double seconds = processor_seconds() - before;
  return {from_indices(source.vertices, left), seconds};
}

#if MESHOPTIMIZER_VERSION >= 1000
/// Corners move to where the quadrics are least.
Simplified moved_by_meshoptimizer(const TriangleMesh& source, double triangles) {
  FloatMesh mesh(source);
  const double before = processor_seconds();
  mesh.indices.resize(meshopt_simplifyWithUpdate(mesh.indices.data(), mesh.indices.size(), mesh.positions.data(),
                                                 mesh.vertices(), mesh.stride, nullptr, 0, nullptr, 0, nullptr,
                                                 3 * std::size_t(triangles), FLT_MAX, 0, nullptr));
  const double seconds = processor_seconds() - before;
  std::vector<Vec3> vertices;
  for (std::size_t v = 0; v < mesh.vertices(); ++v)
    vertices.push_back(mesh.middle + Eigen::Map<const Eigen::Vector3f>(&mesh.positions[3 * v]).cast<double>());
  return {from_indices(std::move(vertices), mesh.indices), seconds};
}
#endif

Simplified to_count(const TriangleMesh& source, double triangles) {
  return simplified_by_meshoptimizer(source, std::size_t(triangles), 0);
}
Simplified to_error(const TriangleMesh& source, double error) { return simplified_by_meshoptimizer(source, 0, error); }

}  // namespace

std::vector<Contestant> meshoptimizer_simplifiers() {
  const std::string version = std::to_string(MESHOPTIMIZER_VERSION);
  return {
    {"meshoptimizer", version, Knob::count, &to_count}, {"meshoptimizer by error", version, Knob::error, &to_error},
#if MESHOPTIMIZER_VERSION >= 1000
        {"meshoptimizer, moving", version, Knob::count, &moved_by_meshoptimizer},
#endif
  };
}
#else
std::vector<Contestant> meshoptimizer_simplifiers() {
  return {{"meshoptimizer", "", Knob::count, {}}, {"meshoptimizer by error", "", Knob::error, {}}};
}
#endif

}  // namespace bench
