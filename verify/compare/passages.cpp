#include "verify/compare/passages.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t block = 256;       // points of one parallel task
constexpr double flattest_sight = 0.26;  // cosine of 75 degrees: sensors lose steeper surface and see what is behind it

class Finder {
 public:
  Finder(const ScanSource& source, const MeshDistance& surface, const std::vector<Vec3>& normals, double margin)
      : source_(source), surface_(surface), normals_(normals), margin_(margin) {
    Box3 box;
    for (const auto& p : source.points) box.add(p);
    reach_ = 2 * box.diagonal();
  }

  /// The first place where the surface would have hidden the point, if it would.
  std::optional<MeshHit> passage(std::size_t point) const {
    const auto sight = line_of_sight(source_, point, reach_);
    if (!sight) return {};
    const auto hit = hidden_by(surface_, *sight, margin_);
    if (!hit) return {};
    const double cosine = -normals_[hit->triangle].dot(sight->ray);
    if (cosine < flattest_sight || (sight->length - hit->distance) * cosine <= margin_) return {};
    // An edge within the tolerance of its place hides nothing.
    const Vec3 side = sight->ray.unitOrthogonal(), up = sight->ray.cross(side);
    for (const Vec3& d : {side, Vec3(-side), up, Vec3(-up)})
      if (!hidden_by(surface_, *sight, margin_, std::max(sight->pixel, margin_) * d)) return {};
    return hit;
  }

 private:
  const ScanSource& source_;
  const MeshDistance& surface_;
  const std::vector<Vec3>& normals_;
  double margin_, reach_ = 0;
};

}  // namespace

Passages passages_through(const ScanSource& source, const PointField& points, const MeshDistance& surface,
                          const std::vector<Vec3>& normals, double tolerance, double false_alarm, int threads) {
  Passages result;
  if (source.sights.empty()) return result;
  const Finder finder(source, surface, normals, tolerance + 3 * source.noise);
  std::vector<std::vector<MeshHit>> hits(source.points.size() / block + 1);
  parallel_for(
      source.points.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          if (const auto hit = finder.passage(i)) hits[begin / block].push_back(*hit);
      },
      block);
  OutlierScene scene;
  for (const auto& of_block : hits)
    for (const auto& hit : of_block) {
      result.places.push_back(hit.point), result.triangles.push_back(hit.triangle);
      scene.foot_normals.push_back(normals[hit.triangle]);
    }
  scene.off = scene.feet = result.places;
  scene.source = &source, scene.is_off = &points.outlier, scene.triangle = &points.triangle, scene.normals = &normals;
  result.clusters = clusters_beyond_chance(scene, false_alarm, threads);
  return result;
}

}  // namespace partscribe::verify
