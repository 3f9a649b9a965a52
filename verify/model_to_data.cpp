#include "verify/model_to_data.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"

namespace partscribe {
namespace {

constexpr std::size_t sample_count = 60000;

class Coverage {
 public:
  Coverage(const ScanSource& source, const PointField& points, const MeshDistance& surface,
           const std::vector<Vec3>& normals, double tolerance, double size)
      : source_(source), points_(points), surface_(surface), normals_(normals), tolerance_(tolerance), size_(size),
        far_(tolerance + 3 * source.noise) {}

  Support support_of(const Vec3& place, std::uint32_t triangle, std::vector<Neighbour>& near) const {
    const Vec3& normal = normals_[triangle];
    if (source_.surface) {
      const double distance = source_.surface->closest(place).distance;
      if (distance <= far_) return Support::supported;
      if (source_.closed_surface) return Support::contradicted;
    } else if (points_near(place, normal, 1, near)) {
      return Support::supported;
    }
    for (const auto& map : source_.sights)
      if (seen_through(map, place, normal, far_)) return Support::contradicted;
    if (hides_scanned_surface(place, normal, near)) return Support::contradicted;
    return Support::not_scanned;
  }

 private:
  const ScanSource& source_;
  const PointField& points_;
  const MeshDistance& surface_;
  const std::vector<Vec3>& normals_;
  double tolerance_, size_, far_;

  /// At least `wanted` points within reach along the surface and within the tolerance across it, on a face that
  /// looks the same way.
  bool points_near(const Vec3& place, const Vec3& normal, int wanted, std::vector<Neighbour>& near) const {
    const auto nearest = source_.tree->nearest_one(place).index;
    const double spacing = std::max(points_.places[points_.place[nearest]].spacing, source_.spacing);
    const double reach = std::max(3 * std::min(spacing, 3 * source_.spacing), tolerance_) + tolerance_;
    const double radius = std::hypot(reach, far_);
    auto count = [&] {
      int found = 0;
      for (const auto& n : near) {
        if (n.sq_distance > radius * radius) break;
        if (points_.stray[n.index]) continue;
        const Vec3 offset = source_.points[n.index] - place;
        const double height = normal.dot(offset);
        if (std::abs(height) > far_ || (offset - height * normal).squaredNorm() > reach * reach) continue;
        if (normals_[points_.triangle[n.index]].dot(normal) < 0.5) continue;
        if (++found == wanted) return true;
      }
      return false;
    };
    source_.tree->nearest(place, 16, near);
    if (count()) return true;
    if (near.size() < 16 || near.back().sq_distance > radius * radius) return false;
    source_.tree->within(place, radius, near);
    return count();
  }

  /// Directly below the place, inside or behind the material, lies scanned surface of the model that looks the same
  /// way. Whoever saw that surface would have seen this one first, so this one is not there.
  bool hides_scanned_surface(const Vec3& place, const Vec3& normal, std::vector<Neighbour>& near) const {
    const Vec3 down = -normal;
    Vec3 from = place;
    double passed = 0;
    const double deepest = 0.1 * size_, step = 1e-9 * size_ + 1e-3 * tolerance_;
    for (int crossing = 0; crossing < 6; ++crossing) {
      const auto hit = surface_.first_hit(from + step * down, down, deepest - passed);
      if (!hit) return false;
      passed += hit->distance + step;
      if (passed >= deepest) return false;
      if (passed > far_ && normals_[hit->triangle].dot(normal) > 0.7 && points_near(hit->point, normals_[hit->triangle], 5, near))
        return true;
      from = hit->point;
    }
    return false;
  }
};

}  // namespace

SurfaceField model_to_data(const ScanSource& source, const PointField& points, const TriangleMesh& mesh,
                           const MeshDistance& surface, const std::vector<Vec3>& normals, const VerifyOptions& options,
                           Context& context) {
  SurfaceField field;
  field.samples = even_samples(mesh, sample_count);
  field.support.assign(field.samples.size(), Support::not_scanned);
  const Coverage coverage(source, points, surface, normals, options.tolerance, mesh.bounds().diagonal());
  parallel_for(field.samples.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i)
      field.support[i] = coverage.support_of(field.samples[i].point, field.samples[i].triangle, near);
  }, 256);
  field.summary.area = area(mesh);
  const double each = field.samples.empty() ? 0 : field.summary.area / static_cast<double>(field.samples.size());
  std::size_t counts[3] = {0, 0, 0};
  for (const auto s : field.support) ++counts[static_cast<int>(s)];
  field.summary.supported = each * static_cast<double>(counts[0]);
  field.summary.not_scanned = each * static_cast<double>(counts[1]);
  field.summary.contradicted = each * static_cast<double>(counts[2]);
  // Edges blur a view's picture by a few points; a disc of three spacings is the least that a scan can show.
  field.allowed_contradiction = std::max({0.001 * field.summary.area, pi * 9 * source.spacing * source.spacing, 3 * each});

  // The sample with the most contradicted company is where a person should look.
  std::vector<Vec3> bad;
  for (std::size_t i = 0; i < field.samples.size(); ++i)
    if (field.support[i] == Support::contradicted) bad.push_back(field.samples[i].point);
  if (!bad.empty()) {
    const KdTree tree(bad);
    std::vector<Neighbour> near;
    double tightest = std::numeric_limits<double>::infinity();
    const std::size_t stride = std::max<std::size_t>(1, bad.size() / 2000);
    for (std::size_t i = 0; i < bad.size(); i += stride) {
      tree.nearest(bad[i], 20, near);
      if (near.back().sq_distance < tightest) tightest = near.back().sq_distance, field.worst = bad[i];
    }
  }
  return field;
}

}  // namespace partscribe
