#include "verify/compare/model_to_data.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "geometry/mesh/mesh_facets.h"
#include "verify/compare/plain_view.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t sample_count = 60000;
constexpr double widest_drop_out = 10;          // spacings, radius of a dark or shiny place that a scanner may lose
constexpr double widest_drop_out_share = 0.03;  // of the part's size
constexpr std::size_t outlook_count = 1000;     // directions, 6 degrees apart
constexpr double flattest_outlook = 0.26;       // cosine of 75 degrees
constexpr double passage_reach = 2;             // spacings around a passed place where surface is refuted with it
constexpr double false_alarm = 0.0005;          // chance of refusing a true model because outliers seem seen through it

class Coverage {
 public:
  Coverage(const ScanSource& source, const PointField& points, const MeshDistance& surface,
           const std::vector<Vec3>& normals, const MeshPieces& bodies, double tolerance, double size)
      : source_(source),
        points_(points),
        surface_(surface),
        normals_(normals),
        bodies_(bodies),
        tolerance_(tolerance),
        size_(size),
        far_(tolerance + 3 * source.noise) {
    if (source.sights.empty()) outlooks_ = even_directions(outlook_count);
  }

  Support support_of(const Vec3& place, std::uint32_t triangle, std::vector<Neighbour>& near) const {
    const Vec3& normal = normals_[triangle];
    if (source_.surface) {
      const double distance = source_.surface->closest(place).distance;
      if (distance <= far_) return Support::supported;
      if (source_.closed_surface) return Support::contradicted;
    } else if (points_near(place, triangle, 1, near)) {
      return Support::supported;
    }
    for (const auto& map : source_.sights)
      if (seen_through(map, place, normal, far_)) return Support::contradicted;
    if (hides_scanned_surface(place, normal, near)) return Support::contradicted;
    return Support::not_scanned;
  }

  /// At least two views face the place, nothing of the model stands between, and none of them returned anything there.
  bool unanswered(const Vec3& place, const Vec3& normal) const {
    int views = 0;
    for (const auto& map : source_.sights) {
      const auto sensor = unanswered_from(map, place, normal);
      if (sensor && !surface_.first_hit(place + 1e-6 * size_ * normal, *sensor, 2 * size_) && ++views == 2) return true;
    }
    return false;
  }

 private:
  const ScanSource& source_;
  const PointField& points_;
  const MeshDistance& surface_;
  const std::vector<Vec3>& normals_;
  const MeshPieces& bodies_;
  double tolerance_, size_, far_;
  std::vector<Vec3> outlooks_;  // directions from which a scan without lines of sight may have been taken

  /// At least `wanted` points within reach along the surface and within the tolerance across it, on a face
  /// of the same body that looks the same way; a quarter of them belong to this very sheet, not to one in front of it
  /// or behind.
  bool points_near(const Vec3& place, std::uint32_t triangle, int wanted, std::vector<Neighbour>& near) const {
    const Vec3& normal = normals_[triangle];
    const auto nearest = source_.tree->nearest_one(place).index;
    const double spacing = std::max(points_.places[points_.place[nearest]].spacing, source_.spacing);
    const double reach = std::max(3 * std::min(spacing, 3 * source_.spacing), tolerance_) + tolerance_;
    const double radius = std::hypot(reach, far_);
    auto count = [&] {
      int found = 0, other = 0;
      for (const auto& n : near) {
        if (n.sq_distance > radius * radius) break;
        if (points_.outlier[n.index] || !points_.places[points_.place[n.index]].decided) continue;
        const Vec3 offset = source_.points[n.index] - place;
        const double height = normal.dot(offset);
        const double along = (offset - height * normal).norm();
        if (std::abs(height) > far_ || along > reach) continue;
        if (bodies_.of[points_.triangle[n.index]] != bodies_.of[triangle]) continue;
        const Vec3& facet = normals_[points_.triangle[n.index]];
        const double cosine = facet.dot(normal);
        if (cosine < 0.5) continue;
        // The point's own foot on the model: as high above the place as the surface bends on the way.
        const double foot = height - points_.distance[n.index] * cosine;
        const bool this_sheet =
            std::abs(foot) <= 0.25 * tolerance_ + along * std::sqrt(std::max(0.0, 1 - cosine * cosine));
        ++(this_sheet ? found : other);
      }
      return found >= wanted && 3 * found >= other;
    };
    source_.tree->nearest(place, 16, near);
    if (near.size() < 16 || near.back().sq_distance > radius * radius) return count();
    if (count()) return true;
    source_.tree->within(place, radius, near);
    return count();
  }

  /// Do lines of sight reach most of the points nearest to `place` although the model is there? Where none is known:
  /// might any, between what the model has?
  bool in_sight(const Vec3& place, const Vec3& normal, std::vector<Neighbour>& near) const {
    if (source_.sights.empty()) {
      const Vec3 from = place + 1e-6 * size_ * normal;
      return std::any_of(outlooks_.begin(), outlooks_.end(), [&](const Vec3& d) {
        return normal.dot(d) > flattest_outlook && !surface_.first_hit(from, d, 2 * size_);
      });
    }
    constexpr int asked = 9;
    source_.tree->nearest(place, asked, near);
    int free = 0, known = 0;
    for (const auto& n : near) {
      const auto sight = line_of_sight(source_, n.index, 2 * size_);
      if (!sight) continue;
      ++known;
      free += !hidden_by(surface_, *sight, far_);
    }
    return 2 * free > known;
  }

  /// Directly below the place, inside or behind the material, lies scanned surface of the model that looks the same
  /// way. Whoever saw that surface would have seen this one first, so this one is not there; unless it is seen from
  /// aside: a wall hides nothing of the slot behind it.
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
      if (passed > far_ && normals_[hit->triangle].dot(normal) > 0.7 &&
          points_near(hit->point, hit->triangle, 5, near) && !in_sight(hit->point, normals_[hit->triangle], near))
        return true;
      from = hit->point;
    }
    return false;
  }
};

/// Patches that views look at and get no return from, wider than a scanner's drop-outs: such surface is not there. A
/// patch counts if somewhere no other sample lies within ten spacings and 3 % of the size.
void contradict_unanswered(const ScanSource& source, const Coverage& coverage, double size,
                           const std::vector<Vec3>& normals, SurfaceField& field, int threads) {
  const std::size_t count = field.samples.size();
  std::vector<char> silent(count, 0);
  parallel_for(
      count, threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          if (field.support[i] == Support::not_scanned)
            silent[i] = coverage.unanswered(field.samples[i].point, normals[field.samples[i].triangle]);
      },
      256);
  std::vector<Vec3> silent_places, other_places;
  std::vector<std::uint32_t> index;
  for (std::uint32_t i = 0; i < count; ++i)
    if (silent[i])
      silent_places.push_back(field.samples[i].point), index.push_back(i);
    else
      other_places.push_back(field.samples[i].point);
  if (silent_places.empty() || other_places.empty()) return;
  const double reach = std::max(widest_drop_out * source.spacing, widest_drop_out_share * size);
  const KdTree silent_tree(silent_places), other_tree(other_places);
  std::vector<char> taken(index.size(), 0);
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < index.size(); ++i)
    if (other_tree.nearest_one(silent_places[i]).sq_distance > reach * reach) taken[i] = 1, open.push_back(i);
  // The rest of each patch belongs to it.
  std::vector<Neighbour> near;
  while (!open.empty()) {
    const auto i = open.back();
    open.pop_back();
    silent_tree.within(silent_places[i], 3 * source.spacing, near);
    for (const auto& n : near)
      if (!taken[n.index]) taken[n.index] = 1, open.push_back(n.index);
  }
  for (std::size_t i = 0; i < index.size(); ++i)
    if (taken[i]) field.support[index[i]] = Support::contradicted;
}

/// Samples without data where points were seen through the surface.
void contradict_passed(const ScanSource& source, const std::vector<Vec3>& normals, SurfaceField& field) {
  std::vector<Vec3> places;
  std::vector<std::uint32_t> triangles;
  for (const auto& cluster : field.passages.clusters)
    for (const auto m : cluster.members)
      places.push_back(field.passages.places[m]), triangles.push_back(field.passages.triangles[m]);
  if (places.empty()) return;
  const KdTree tree(places);
  const double reach = passage_reach * source.spacing;
  std::vector<Neighbour> near;
  for (std::size_t i = 0; i < field.samples.size(); ++i) {
    if (field.support[i] != Support::not_scanned) continue;
    tree.within(field.samples[i].point, reach, near);
    const Vec3& normal = normals[field.samples[i].triangle];
    if (std::any_of(near.begin(), near.end(),
                    [&](const Neighbour& n) { return normals[triangles[n.index]].dot(normal) > 0.7; }))
      field.support[i] = Support::contradicted;
  }
}

/// How many other bodies hold the place: crossings out of them less crossings into them along a ray.
int bodies_around(const Vec3& place, const Vec3& direction, std::uint32_t own, const MeshPieces& bodies,
                  const MeshDistance& surface, const std::vector<Vec3>& normals, double size) {
  int around = 0;
  Vec3 from = place;
  for (int crossing = 0; crossing < 200; ++crossing) {
    const auto hit = surface.first_hit(from, direction, 2 * size);
    if (!hit) break;
    if (bodies.of[hit->triangle] != own) around += normals[hit->triangle].dot(direction) > 0 ? 1 : -1;
    from = hit->point + 1e-9 * size * direction;
  }
  return around;
}

}  // namespace

double surface_inside_bodies(const TriangleMesh& mesh, const MeshDistance& surface, const std::vector<Vec3>& normals,
                             const SurfaceField& field, int threads) {
  const MeshPieces bodies = pieces_of(mesh);
  if (std::count_if(bodies.volume.begin(), bodies.volume.end(), [](double v) { return v > 0; }) < 2) return 0;
  const std::size_t step = 10, count = field.samples.size() / step;
  std::vector<char> inside(count, 0);
  const double size = mesh.bounds().diagonal();
  const Vec3 askew = Vec3(0.5341, 0.2711, 0.8008).normalized();  // along no edge that a designer would draw
  parallel_for(
      count, threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const auto& s = field.samples[i * step];
          const auto own = bodies.of[s.triangle];
          // From just below its own surface, and both ways: bodies that only touch are not inside one another, though a
          // ray may miss one of two facets that lie on each other.
          const Vec3 below = s.point - 1e-7 * size * normals[s.triangle];
          if (bodies.volume[own] > 0)
            inside[i] = bodies_around(below, askew, own, bodies, surface, normals, size) > 0 &&
                        bodies_around(below, -askew, own, bodies, surface, normals, size) > 0;
        }
      },
      64);
  const auto found = static_cast<double>(std::count(inside.begin(), inside.end(), 1));
  return count ? field.summary.area * found / static_cast<double>(count) : 0;
}

SurfaceField model_to_data(const ScanSource& source, const PointField& points, const TriangleMesh& mesh,
                           const MeshDistance& surface, const std::vector<Vec3>& normals, const VerifyOptions& options,
                           Context& context) {
  SurfaceField field;
  field.samples = even_samples(mesh, sample_count);
  field.support.assign(field.samples.size(), Support::not_scanned);
  const MeshPieces bodies = pieces_of(mesh);
  const Coverage coverage(source, points, surface, normals, bodies, options.tolerance, mesh.bounds().diagonal());
  parallel_for(
      field.samples.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbour> near;
        for (std::size_t i = begin; i < end; ++i)
          field.support[i] = coverage.support_of(field.samples[i].point, field.samples[i].triangle, near);
      },
      256);
  if (!source.surface || !source.closed_surface)
    contradict_in_plain_view(source, mesh, surface, normals, options.tolerance, field, context.threads);
  if (!source.sights.empty())
    contradict_unanswered(source, coverage, mesh.bounds().diagonal(), normals, field, context.threads);
  field.passages = passages_through(source, points, surface, normals, options.tolerance, false_alarm, context.threads);
  contradict_passed(source, normals, field);
  field.summary.area = area(mesh);
  const double each = field.samples.empty() ? 0 : field.summary.area / static_cast<double>(field.samples.size());
  std::size_t counts[3] = {0, 0, 0};
  for (const auto s : field.support) ++counts[static_cast<int>(s)];
  field.summary.supported = each * static_cast<double>(counts[0]);
  field.summary.not_scanned = each * static_cast<double>(counts[1]);
  field.summary.contradicted = each * static_cast<double>(counts[2]);
  // Edges blur a view's picture by a few points; a disc of three spacings is the least that a scan can show.
  field.allowed_contradiction =
      std::max({0.001 * field.summary.area, pi * 9 * source.spacing * source.spacing, 3 * each});

  // The sample with the most contradicted neighbours is reported as the place to look at.
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

}  // namespace partscribe::verify
