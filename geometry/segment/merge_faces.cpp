#include "geometry/segment/merge_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "core/parallel.h"
#include "geometry/segment/faces.h"
#include "geometry/segment/label_faces.h"

namespace partscribe::geometry {
namespace {

constexpr double smooth_border = 0.45;  // rad between faces that may be one
constexpr std::size_t least_links = 4;

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// The best single surface for these samples, of the kinds that cost at most `most` nats.
std::optional<GrownFace> best_surface(const FaceSamples& samples, const std::vector<std::uint32_t>& members,
                                      std::vector<Primitive> starts, double most = 1e300) {
  std::optional<GrownFace> best;
  const auto judge = [&](const std::optional<Primitive>& surface) {
    if (!surface) return;
    GrownFace face{*surface, sense_of(samples, *surface, members), members, gain_of(samples, *surface, members)};
    if (!best || face.gain > best->gain) best = std::move(face);
  };
  for (const auto kind : face_kinds)
    if (cost_of(kind, members.size()) <= most) judge(fit_samples(samples, kind, members, std::nullopt));
  for (const auto& start : starts) judge(fit_samples(samples, start.kind, members, start));
  return best;
}

/// Whether one surface for all these may gain more than `before` (nats): tried with a few of them. Numbers that few
/// samples tell less exactly cost up to a quarter of what they are uncertain by, and three times that by chance.
bool may_gain(const FaceSamples& samples, const std::vector<std::uint32_t>& members,
              const std::vector<Primitive>& starts, double before) {
  constexpr std::size_t few = 150;
  constexpr double numbers = 7;
  if (members.size() < 2 * few) return true;
  std::vector<std::uint32_t> some;
  for (std::size_t k = 0; k < few; ++k) some.push_back(members[k * members.size() / few]);
  const double uncertain = 3 * 0.25 * numbers / few * static_cast<double>(members.size());
  const auto gains = [&](const std::optional<Primitive>& surface) {
    return surface && gain_of(samples, *surface, members) + uncertain > before;
  };
  return std::ranges::any_of(face_kinds,
                             [&](auto kind) { return gains(fit_samples(samples, kind, some, std::nullopt)); }) ||
         std::ranges::any_of(starts, [&](auto& start) { return gains(fit_samples(samples, start.kind, some, start)); });
}

/// What another surface could save at most (nats), as far as members tell: residuals of neighbours agree where the
/// surface is not theirs, and by chance.
double still_to_save(const FaceSamples& samples, const GrownFace& face) {
  std::vector<double> residual(samples.size(), 0);
  for (const auto i : face.members)
    residual[i] = std::clamp(residual_of(samples, i, face.surface), -widest_distance, widest_distance);
  double sum = 0;
  for (const auto i : face.members) {
    double near = 0;
    std::size_t count = 0;
    for (const auto j : samples.around(i))
      if (residual[j] != 0) near += residual[j], ++count;
    if (count > 0) sum += residual[i] * near / static_cast<double>(count);
  }
  return 0.25 * (sum + 3 * std::sqrt(static_cast<double>(face.members.size()) / 3));
}

/// Neighbours whose surfaces meet smoothly, by the angle between them.
std::set<Pair> smooth_pairs(const FaceSamples& samples, const std::vector<GrownFace>& faces,
                            const std::vector<std::uint32_t>& label) {
  struct Meeting {
    std::size_t links = 0;
    double turned = 0;
  };
  std::map<Pair, Meeting> meetings;
  for (std::uint32_t i = 0; i < samples.size(); ++i)
    for (const auto j : samples.around(i)) {
      const auto f = label[i], g = label[j];
      if (f == no_face || g == no_face || f == g) continue;
      Meeting& meeting = meetings[{std::min(f, g), std::max(f, g)}];
      ++meeting.links;
      meeting.turned += turn_of(samples, j, faces[f].surface, faces[f].sense);
    }
  std::set<Pair> pairs;
  for (const auto& [pair, meeting] : meetings)
    if (meeting.links >= least_links && meeting.turned < smooth_border * static_cast<double>(meeting.links))
      pairs.insert(pair);
  return pairs;
}

std::vector<std::uint32_t> united(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  std::vector<std::uint32_t> all;
  std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
  return all;
}

}  // namespace

bool merge_faces(const FaceSamples& samples, std::vector<GrownFace>& faces, std::vector<std::uint32_t>& label,
                 int threads) {
  bool changed = false;
  parallel_for(
      faces.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          faces[f].gain = gain_of(samples, faces[f].surface, faces[f].members);
          const double most =
              cost_of(faces[f].surface.kind, faces[f].members.size()) + still_to_save(samples, faces[f]);
          if (auto other = best_surface(samples, faces[f].members, {}, most); other && other->gain > faces[f].gain)
            faces[f] = std::move(*other);
        }
      },
      1);
  auto pairs = smooth_pairs(samples, faces, label);
  std::map<Pair, GrownFace> tried;  // what one surface for both would be
  while (!pairs.empty()) {
    std::vector<Pair> fresh;
    for (const auto& pair : pairs)
      if (!tried.contains(pair)) fresh.push_back(pair);
    std::vector<std::optional<GrownFace>> found(fresh.size());
    parallel_for(
        fresh.size(), threads,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t k = begin; k < end; ++k) {
            const GrownFace &a = faces[fresh[k].first], &b = faces[fresh[k].second];
            const auto both = united(a.members, b.members);
            if (may_gain(samples, both, {a.surface, b.surface}, a.gain + b.gain))
              found[k] = best_surface(samples, both, {a.surface, b.surface});
          }
        },
        1);
    for (std::size_t k = 0; k < fresh.size(); ++k) {
      const double before = faces[fresh[k].first].gain + faces[fresh[k].second].gain;
      if (found[k] && found[k]->gain > before)
        tried[fresh[k]] = std::move(*found[k]);
      else
        pairs.erase(fresh[k]);
    }
    const auto better = [&](const Pair& p) { return tried.at(p).gain - faces[p.first].gain - faces[p.second].gain; };
    const auto best = std::max_element(pairs.begin(), pairs.end(),
                                       [&](const Pair& a, const Pair& b) { return better(a) < better(b); });
    if (best == pairs.end()) break;
    const auto [f, g] = *best;
    faces[f] = std::move(tried.at(*best));
    faces[g].members.clear();
    for (const auto i : faces[f].members) label[i] = f;
    changed = true;
    std::set<Pair> rest;
    for (const auto& p : pairs) {
      const auto a = p.first == g ? f : p.first, b = p.second == g ? f : p.second;
      if (a == b) continue;
      if (p.first == f || p.second == f || p.first == g || p.second == g)
        tried.erase(p), tried.erase({std::min(a, b), std::max(a, b)});
      rest.insert({std::min(a, b), std::max(a, b)});
    }
    pairs = std::move(rest);
  }
  drop_faces(faces, label, 1);
  return changed;
}

}  // namespace partscribe::geometry
