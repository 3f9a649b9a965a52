#include "geometry/segment/grow_faces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "geometry/segment/faces.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t most_fitted = 1500;  // samples that a fit is made of while growing
constexpr int most_rounds = 14;
constexpr std::size_t least_members = 12;
constexpr double enough_border = 0.85;  // of a border that ends at creases or gaps: nothing else is tried
constexpr double crease = 0.4;          // rad
constexpr std::size_t plain_kinds = 2;  // planes and cylinders, tried before the others

/// Where growth begins: so many samples within so wide an angle of the seed's normal.
struct SeedSize {
  std::size_t count;
  double turn;
};
constexpr std::array<SeedSize, 2> seed_sizes = {SeedSize{30, 0.44}, SeedSize{90, 0.9}};

int numbers_of(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::plane:
      return 3;
    case PrimitiveKind::cylinder:
      return 5;
    case PrimitiveKind::sphere:  // four, but balls are rarer than cones
    case PrimitiveKind::cone:
      return 6;
    default:
      return 7;
  }
}

/// rad, of unit vectors.
double between(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& all, const std::vector<std::uint32_t>& some) {
  std::vector<std::uint32_t> rest;
  std::set_difference(all.begin(), all.end(), some.begin(), some.end(), std::back_inserter(rest));
  return rest;
}

class Growth {
 public:
  Growth(const FaceSamples& samples, const std::vector<std::uint8_t>& taken) : samples_(samples), taken_(taken) {}

  std::vector<std::uint32_t> seed_members(std::uint32_t seed, const SeedSize& size) const {
    return flood({seed}, size.count,
                 [&](std::uint32_t i) { return between(samples_.normals[i], samples_.normals[seed]) <= size.turn; });
  }

  std::optional<GrownFace> grown(PrimitiveKind kind, std::vector<std::uint32_t> members) const {
    if (members.size() < least_members) return std::nullopt;
    auto surface = fit_samples(samples_, kind, members, std::nullopt);
    if (!surface) return std::nullopt;
    const std::size_t begin = members.size();
    double sense = sense_of(samples_, *surface, members);
    for (int round = 0; round < most_rounds; ++round) {
      const auto explained = [&](std::uint32_t i) { return explains(*surface, sense, i); };
      std::vector<std::uint32_t> roots;
      for (const auto i : members)
        if (explained(i)) roots.push_back(i);
      auto next = flood(std::move(roots), 3 * members.size() + 60, explained);
      if (next.size() < std::max(least_members, begin / 2)) return std::nullopt;
      auto again = fit_samples(samples_, kind, next, surface);
      if (!again) return std::nullopt;
      const bool settled = 100 * std::max(next.size(), members.size()) <= 101 * std::min(next.size(), members.size());
      members = std::move(next), surface = *again;
      sense = sense_of(samples_, *surface, members);
      if (settled && round > 0) break;
    }
    GrownFace face{*surface, sense, std::move(members), 0};
    std::sort(face.members.begin(), face.members.end());
    face.gain = gain_of(samples_, face.surface, face.members);
    return face;
  }

  /// Its border is made of creases, gaps and other faces: no other surface could go on there.
  bool is_bounded(const GrownFace& face) const {
    std::vector<std::uint8_t> inside(samples_.size(), 0);
    for (const auto i : face.members) inside[i] = 1;
    std::size_t border = 0, open = 0;
    for (const auto i : face.members)
      for (const auto j : samples_.around(i)) {
        if (inside[j]) continue;
        ++border;
        if (!taken_[j] && turn_of(samples_, j, face.surface, face.sense) < crease) ++open;
      }
    return static_cast<double>(open) <= (1 - enough_border) * static_cast<double>(border);
  }

 private:
  const FaceSamples& samples_;
  const std::vector<std::uint8_t>& taken_;

  bool explains(const Primitive& surface, double sense, std::uint32_t i) const {
    return std::abs(residual_of(samples_, i, surface)) <= widest_distance &&
           turn_of(samples_, i, surface, sense) <= widest_turn;
  }

  /// Samples that `fits` takes, reached from the roots in rings, at most `most`.
  template <class Fits>
  std::vector<std::uint32_t> flood(std::vector<std::uint32_t> roots, std::size_t most, const Fits& fits) const {
    std::vector<std::uint8_t> seen(samples_.size(), 0);
    for (const auto i : roots) seen[i] = 1;
    for (std::size_t k = 0; k < roots.size() && roots.size() < most; ++k)
      for (const auto j : samples_.around(roots[k])) {
        if (seen[j] || taken_[j]) continue;
        seen[j] = 1;
        if (fits(j)) roots.push_back(j);
      }
    return roots;
  }
};

}  // namespace

std::optional<PrimitiveFit> robust_fit(PrimitiveKind kind, const std::vector<Vec3>& points,
                                       const std::vector<Vec3>& normals, const std::vector<double>& sigmas,
                                       const std::optional<Primitive>& start) {
  PrimitiveFitOptions options;
  options.sigmas = &sigmas, options.robust = 2.5, options.start = start;
  return fit_primitive(kind, points, normals, options);
}

double residual_of(const FaceSamples& samples, std::uint32_t sample, const Primitive& surface) {
  return distance(surface, samples.points[sample]) / samples.sigma[sample];
}

double turn_of(const FaceSamples& samples, std::uint32_t sample, const Primitive& surface, double sense) {
  return between(samples.normals[sample], sense * surface_normal(surface, samples.points[sample]));
}

double sense_of(const FaceSamples& samples, const Primitive& surface, const std::vector<std::uint32_t>& members) {
  double sum = 0;
  for (const auto i : members) sum += samples.normals[i].dot(surface_normal(surface, samples.points[i]));
  return sum < 0 ? -1 : 1;
}

double gain_of(const FaceSamples& samples, const Primitive& surface, const std::vector<std::uint32_t>& members) {
  double sum = 0;
  for (const auto i : members) {
    const double u = residual_of(samples, i, surface);
    sum += std::max(0.0, 4 - 0.5 * u * u) / 2;
  }
  return sum - cost_of(surface.kind, members.size());
}

double cost_of(PrimitiveKind kind, std::size_t members) {
  return 25 + numbers_of(kind) * (10 + 0.005 * static_cast<double>(members));
}

std::optional<Primitive> fit_samples(const FaceSamples& samples, PrimitiveKind kind,
                                     const std::vector<std::uint32_t>& members, const std::optional<Primitive>& start) {
  std::vector<Vec3> points, normals;
  std::vector<double> sigmas;
  const std::size_t step = (members.size() + most_fitted - 1) / most_fitted;
  for (std::size_t k = 0; k < members.size(); k += step) {
    points.push_back(samples.points[members[k]]), normals.push_back(samples.normals[members[k]]);
    sigmas.push_back(samples.sigma[members[k]]);
  }
  const auto fit = robust_fit(kind, points, normals, sigmas, start);
  if (!fit || !fit->determined) return std::nullopt;
  return fit->primitive;
}

std::optional<GrownFace> grow_face(const FaceSamples& samples, std::uint32_t seed,
                                   const std::vector<std::uint8_t>& taken, int threads) {
  const Growth growth(samples, taken);
  std::array<std::vector<std::uint32_t>, seed_sizes.size()> starts;
  for (std::size_t s = 0; s < starts.size(); ++s) starts[s] = growth.seed_members(seed, seed_sizes[s]);
  if (auto plane = growth.grown(PrimitiveKind::plane, starts[0]);
      plane && plane->gain > 0 && plane->members.size() > starts[1].size() && growth.is_bounded(*plane))
    return plane;
  std::array<std::optional<GrownFace>, face_kinds.size() * seed_sizes.size()> found;
  const auto try_kinds = [&](std::size_t first, std::size_t last) {
    parallel_for((last - first) * starts.size(), threads,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin + first * starts.size(); i < end + first * starts.size(); ++i)
                     found[i] = growth.grown(face_kinds[i / starts.size()], starts[i % starts.size()]);
                 },
                 1);
  };
  const auto best_found = [&] {
    std::optional<GrownFace> best;
    for (const auto& face : found)
      if (face && face->gain > 0 && (!best || face->gain > best->gain)) best = face;
    return best;
  };
  try_kinds(0, plain_kinds);
  auto best = best_found();
  if (best && best->members.size() > starts[1].size() && growth.is_bounded(*best)) return best;
  try_kinds(plain_kinds, face_kinds.size());
  best = best_found();
  if (!best) return best;
  // A surface that explains much because it follows two faces badly gives way to one of these, if that one and the rest
  // of the other save more together.
  for (bool better = true; better;) {
    better = false;
    const GrownFace wide = *best;
    double most = wide.gain;
    for (const auto& face : found) {
      if (!face || face->gain <= 0 || face->members.size() >= wide.members.size()) continue;
      const double both =
          face->gain + std::max(0.0, gain_of(samples, wide.surface, without(wide.members, face->members)));
      if (both > most) most = both, best = face, better = true;
    }
  }
  return best;
}

}  // namespace partscribe::geometry
