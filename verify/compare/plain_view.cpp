#include "verify/compare/plain_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/disjoint_sets.h"
#include "core/number.h"
#include "core/parallel.h"
#include "geometry/mesh/mesh_facets.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t direction_count = 250;  // 13 degrees apart
constexpr std::size_t scene_count = 4000;     // samples of what else a direction sees
constexpr std::size_t asked_of_patch = 120;   // samples
constexpr std::size_t asked_of_border = 200;  // edges
constexpr double least_reach = 5;             // spacings
constexpr double one_face = 0.866;            // cosine of 30 degrees, between neighbouring triangles
constexpr double unseen_share = 0.8;          // of a face without data
constexpr double plain = 0.5;                 // cosine of 60 degrees: so steep a surface returns for certain
constexpr double steep = 0.26;                // cosine of 75 degrees: surface that may return
constexpr double shown_share = 0.2;           // of a patch, so that a direction shows it
constexpr double missing_share = 0.05;        // of what else a direction shows in plain view
constexpr double least_lean = 0.17;   // sine of 10 degrees: a patch that looks along the direction leans nowhere
constexpr double least_share = 0.02;  // of all directions
constexpr std::size_t least_views = 2;
constexpr std::uint32_t none = ~0u;

struct Patch {
  std::uint32_t root = none;  // its least triangle
  std::vector<std::uint32_t> samples;
};

class PlainView {
 public:
  PlainView(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface,
            const std::vector<Vec3>& normals, double tolerance, const SurfaceField& field, int threads)
      : source_(source),
        mesh_(mesh),
        surface_(surface),
        normals_(normals),
        tolerance_(tolerance),
        field_(field),
        threads_(threads),
        size_(mesh.bounds().diagonal()),
        uses_(edge_uses(mesh.triangles)) {
    find_patches();
  }

  /// Samples of patches that the scan must have shown.
  std::vector<std::uint32_t> invented(double least_area) {
    const double each = field_.samples.empty() ? 0 : area(mesh_) / static_cast<double>(field_.samples.size());
    std::erase_if(patches_, [&](const Patch& p) {
      return each * static_cast<double>(p.samples.size()) < least_area || !far_from_points(p) || !backs_itself(p) ||
             needed(p);
    });
    std::vector<std::uint32_t> result;
    if (patches_.empty()) return result;
    for (const auto& p : patches_)
      if (shown_by_views(p) || shown_by_directions(p)) result.insert(result.end(), p.samples.begin(), p.samples.end());
    std::sort(result.begin(), result.end());
    return result;
  }

 private:
  const ScanSource& source_;
  const TriangleMesh& mesh_;
  const MeshDistance& surface_;
  const std::vector<Vec3>& normals_;
  double tolerance_;
  const SurfaceField& field_;
  int threads_;
  double size_;
  std::vector<EdgeUse> uses_;
  std::vector<std::uint32_t> patch_of_;  // of each triangle, or none
  std::vector<Patch> patches_;
  std::vector<Vec3> directions_;
  std::vector<std::uint32_t> scene_;  // samples
  // by direction, of the scene: 1 seen at less than 75 degrees, 2 than 60
  std::vector<std::vector<std::uint8_t>> seen_;

  const Vec3& normal_of(std::uint32_t sample) const { return normals_[field_.samples[sample].triangle]; }
  bool scanned(std::uint32_t sample) const { return field_.support[sample] == Support::supported; }

  bool free_towards(std::uint32_t sample, const Vec3& direction, double reach) const {
    return !surface_.first_hit(field_.samples[sample].point + 1e-6 * size_ * normal_of(sample), direction, reach);
  }

  static std::vector<std::uint32_t> some_of(const std::vector<std::uint32_t>& samples) {
    std::vector<std::uint32_t> some;
    const std::size_t step = samples.size() / asked_of_patch + 1;
    for (std::size_t i = step / 2; i < samples.size(); i += step) some.push_back(samples[i]);
    return some;
  }

  /// Connected faces of which hardly anything was scanned. Of a face that was scanned in part, the rest is lost, not
  /// invented.
  void find_patches() {
    DisjointSets faces(mesh_.triangles.size()), patches(mesh_.triangles.size());
    for_each_edge(uses_, [&](auto around) {
      for (std::size_t i = 1; i < around.size(); ++i)
        if (normals_[around[0].triangle].dot(normals_[around[i].triangle]) > one_face)
          faces.unite(around[0].triangle, around[i].triangle);
    });
    std::vector<std::array<double, 2>> counts(mesh_.triangles.size(), {0, 0});
    for (std::uint32_t i = 0; i < field_.samples.size(); ++i)
      counts[faces.root(field_.samples[i].triangle)][!scanned(i)] += 1;
    patch_of_.assign(mesh_.triangles.size(), none);
    for (std::uint32_t t = 0; t < patch_of_.size(); ++t) {
      const auto& [with, without] = counts[faces.root(t)];
      if (without > 0 && without >= unseen_share * (with + without)) patch_of_[t] = t;
    }
    for_each_edge(uses_, [&](auto around) {
      for (std::size_t i = 1; i < around.size(); ++i)
        if (patch_of_[around[0].triangle] != none && patch_of_[around[i].triangle] != none)
          patches.unite(around[0].triangle, around[i].triangle);
    });
    std::map<std::uint32_t, Patch> found;
    for (auto& p : patch_of_)
      if (p != none) p = patches.root(p);
    for (std::uint32_t i = 0; i < field_.samples.size(); ++i)
      if (const auto p = patch_of_[field_.samples[i].triangle]; p != none && !scanned(i))
        found[p].root = p, found[p].samples.push_back(i);
    for (auto& [root, patch] : found) patches_.push_back(std::move(patch));
  }

  /// It reaches farther from all that was scanned than the gaps between the points.
  bool far_from_points(const Patch& patch) const {
    const double reach = least_reach * source_.spacing;
    return std::any_of(patch.samples.begin(), patch.samples.end(), [&](std::uint32_t i) {
      return source_.tree->nearest_one(field_.samples[i].point).sq_distance > reach * reach;
    });
  }

  /// Through the material behind most of it one comes to the patch itself: a fin or a pin has its own back, the wall of
  /// a pocket and the bottom of a part have not.
  bool backs_itself(const Patch& patch) const {
    const auto some = some_of(patch.samples);
    std::size_t own = 0;
    for (const auto i : some) {
      const Vec3 in = -normal_of(i);
      const auto hit = surface_.first_hit(field_.samples[i].point + 1e-6 * size_ * in, in, 2 * size_);
      own += hit && patch_of_[hit->triangle] == patch.root;
    }
    return 2 * own >= some.size();
  }

  /// Without the patch the scanned surface would fall apart, as top and bottom of a plate do without its sides. What
  /// merely continues on the other side, as a shaft does behind a collar, is not apart.
  bool needed(const Patch& patch) const {
    struct Border {
      Vec3 middle;
      std::uint32_t triangle;
    };
    DisjointSets whole(mesh_.triangles.size()), rest(mesh_.triangles.size());
    std::vector<Border> borders;
    for_each_edge(uses_, [&](auto around) {
      for (std::size_t i = 1; i < around.size(); ++i) {
        const auto a = around[0].triangle, b = around[i].triangle;
        const bool own_a = patch_of_[a] == patch.root, own_b = patch_of_[b] == patch.root;
        whole.unite(a, b);
        if (!own_a && !own_b) rest.unite(a, b);
        if (own_a != own_b)
          borders.push_back(
              {0.5 * (mesh_.vertices[around[0].low()] + mesh_.vertices[around[0].high()]), own_a ? b : a});
      }
    });
    const std::size_t step = borders.size() / asked_of_border + 1;
    for (std::size_t i = 0; i < borders.size(); i += step)
      for (std::size_t j = i + step; j < borders.size(); j += step) {
        const Vec3 across = borders[j].middle - borders[i].middle;
        const Vec3 &n = normals_[borders[i].triangle], &m = normals_[borders[j].triangle];
        const double off = std::max(std::abs(across.dot(n)), std::abs(across.dot(m)));
        if (n.dot(m) > one_face && off < tolerance_ + 0.1 * across.norm())
          rest.unite(borders[i].triangle, borders[j].triangle);
      }
    std::map<std::uint32_t, std::size_t> pieces;  // of the patch's body, with scanned surface
    for (std::uint32_t i = 0; i < field_.samples.size(); ++i) {
      const auto t = field_.samples[i].triangle;
      if (scanned(i) && patch_of_[t] != patch.root && whole.root(t) == whole.root(patch.root)) ++pieces[rest.root(t)];
    }
    std::erase_if(pieces, [](const auto& piece) { return piece.second < 5; });
    return pieces.size() != 1;
  }

  bool shown_by_views(const Patch& patch) const {
    const auto some = some_of(patch.samples);
    std::size_t views = 0;
    for (const auto& map : source_.sights) {
      std::size_t shown = 0;
      for (const auto i : some) {
        const auto sight = sight_of(map, field_.samples[i].point);
        if (!sight || !(sight->to_sensor.dot(normal_of(i)) > plain)) continue;
        const bool hidden =
            std::ranges::any_of(sight->around, [&](float depth) { return depth < sight->depth - tolerance_; });
        shown += !hidden && free_towards(i, sight->to_sensor, sight->length);
      }
      views += static_cast<double>(shown) >= shown_share * static_cast<double>(some.size());
    }
    return views >= least_views;
  }

  /// What of the part is seen from where, asked for once.
  void look_around() {
    if (!directions_.empty()) return;
    directions_ = even_directions(direction_count);
    const std::size_t stride = field_.samples.size() / scene_count + 1;
    for (std::uint32_t i = 0; i < field_.samples.size(); i += static_cast<std::uint32_t>(stride)) scene_.push_back(i);
    seen_.assign(directions_.size(), std::vector<std::uint8_t>(scene_.size(), 0));
    parallel_for(
        directions_.size(), threads_,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t d = begin; d < end; ++d)
            for (std::size_t k = 0; k < scene_.size(); ++k) {
              const double cosine = normal_of(scene_[k]).dot(directions_[d]);
              if (cosine > steep && free_towards(scene_[k], directions_[d], 2 * size_))
                seen_[d][k] = cosine > plain ? 2 : 1;
            }
        },
        4);
  }

  bool shown_by_directions(const Patch& patch) {
    look_around();
    const auto some = some_of(patch.samples);
    std::vector<char> shows(directions_.size(), 0);
    parallel_for(
        directions_.size(), threads_,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t d = begin; d < end; ++d) {
            Vec3 facing = Vec3::Zero();
            std::size_t shown = 0;
            for (const auto i : some)
              if (normal_of(i).dot(directions_[d]) > plain && free_towards(i, directions_[d], 2 * size_))
                facing += normal_of(i), ++shown;
            if (shown > 0 && static_cast<double>(shown) >= shown_share * static_cast<double>(some.size()))
              shows[d] = looked_from(d, patch, facing.normalized());
          }
        },
        4);
    const auto count = static_cast<double>(std::count(shows.begin(), shows.end(), 1));
    return count >= least_share * static_cast<double>(directions_.size());
  }

  /// May the scanner have looked from there, at all but the patch, which looks to `facing`?
  bool looked_from(std::size_t d, const Patch& patch, const Vec3& facing) const {
    const Vec3& direction = directions_[d];
    const Vec3 aside = facing - facing.dot(direction) * direction;
    const double lean = aside.norm();
    std::size_t own = 0, others = 0, missing = 0, beyond = 0, beyond_missing = 0;
    for (std::size_t k = 0; k < scene_.size(); ++k) {
      if (!seen_[d][k]) continue;
      if (patch_of_[field_.samples[scene_[k]].triangle] == patch.root) {
        own += seen_[d][k] == 2;
        continue;
      }
      if (seen_[d][k] == 2) ++others, missing += !scanned(scene_[k]);
      if (normal_of(scene_[k]).dot(aside) >= 0.95 * lean * lean) ++beyond, beyond_missing += !scanned(scene_[k]);
    }
    if (own > others || others < 20 || static_cast<double>(missing) > missing_share * static_cast<double>(others))
      return false;
    return lean < least_lean || (beyond >= 5 && 10 * beyond_missing <= beyond);
  }
};

}  // namespace

std::vector<Vec3> even_directions(std::size_t count) {
  std::vector<Vec3> result;
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  for (std::size_t i = 0; i < count; ++i) {  // Fibonacci's sphere
    const double z = 1 - (2.0 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double r = std::sqrt(1 - z * z), a = 2 * pi * static_cast<double>(i) / golden;
    result.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  return result;
}

void contradict_in_plain_view(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface,
                              const std::vector<Vec3>& normals, double tolerance, SurfaceField& field, int threads) {
  // A smaller patch is hardly wider than the gaps between the points.
  const double least_area = pi * 9 * source.spacing * source.spacing;
  PlainView view(source, mesh, surface, normals, tolerance, field, threads);
  field.in_plain_view = view.invented(least_area);
  for (const auto i : field.in_plain_view) field.support[i] = Support::contradicted;
}

}  // namespace partscribe::verify
