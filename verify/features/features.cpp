#include "verify/features/features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/number.h"
#include "core/statistics.h"
#include "verify/features/facets.h"
#include "verify/features/feature_names.h"
#include "verify/features/fit_facets.h"

namespace partscribe::verify {
namespace {

constexpr double widest_bend = 0.81;       // rad: eight facets close a circle
constexpr double fine_bend = 0.55;         // rad; coarser than this, three equal facets may be a chamfered edge
constexpr double similar_width = 0.45;     // facets of one round surface are nearly equally wide
constexpr double sharpest_bend = 1.6;      // rad: four facets close a circle
constexpr double alike_bend = 0.02;        // rad, between the corners of a regular polygon
constexpr double enough_turning = 0.6;     // rad that a strip turns before it is believed
constexpr double least_turning = 0.35;     // rad that a patch of a piece must turn to be more than chance
constexpr std::size_t most_failures = 60;  // seeds of one piece in a row that lead nowhere
constexpr std::size_t most_planes = 400;
constexpr std::size_t most_tori = 300;  // fits of a mesh; they take longest
constexpr std::array kinds = {PrimitiveKind::cylinder, PrimitiveKind::cone, PrimitiveKind::sphere,
                              PrimitiveKind::torus};
constexpr std::uint32_t none = ~0u;

using Members = std::vector<std::uint32_t>;  // facets

/// One patch before it has a name.
struct Patch {
  Members facets;
  std::optional<Primitive> primitive;
  bool hollow = false;
  bool small = false;
};

class Recogniser {
 public:
  Recogniser(const TriangleMesh& mesh, double tolerance, const IsRound& is_round)
      : mesh_(mesh),
        is_round_(is_round),
        tolerance_(tolerance),
        size_(mesh.bounds().diagonal()),
        corner_error_(std::max(4e-6 * size_, 0.01 * tolerance)),
        parts_(flat_pieces(mesh, std::max(2e-6 * size_, 1e-3 * tolerance))) {}

  MeshFeatures run() {
    prepare();
    find_pieces();
    for (const auto& piece : pieces_) take_piece(piece);
    if (is_round_) take_coarse_circles();
    absorb_strips();
    merge_round();
    take_planes();
    take_rest();
    return named();
  }

 private:
  const TriangleMesh& mesh_;
  const IsRound& is_round_;
  double tolerance_, size_, corner_error_;
  Facets parts_;
  double total_area_ = 0, small_area_ = 0;
  std::vector<std::vector<std::uint32_t>> links_of_;  // of each facet, indices into parts_.links
  std::vector<std::uint8_t> smooth_;                  // of each link
  std::vector<std::uint32_t> patch_of_;               // of each facet
  std::vector<Members> pieces_;
  std::vector<Patch> patches_;
  std::size_t tori_tried_ = 0;

  const Facet& facet(std::uint32_t f) const { return parts_.facets[f]; }
  std::uint32_t other(std::uint32_t link, std::uint32_t f) const {
    const auto& l = parts_.links[link];
    return l.first == f ? l.second : l.first;
  }

  void prepare() {
    patch_of_.assign(parts_.facets.size(), none);
    links_of_.resize(parts_.facets.size());
    for (const auto& f : parts_.facets) total_area_ += f.area;
    small_area_ = std::max(16 * tolerance_ * tolerance_, 2e-5 * total_area_);
    smooth_.assign(parts_.links.size(), 0);
    for (std::uint32_t i = 0; i < parts_.links.size(); ++i) {
      const auto& l = parts_.links[i];
      links_of_[l.first].push_back(i), links_of_[l.second].push_back(i);
      const double narrow = std::min(l.first_width, l.second_width), wide = std::max(l.first_width, l.second_width);
      smooth_[i] = l.angle <= widest_bend && narrow >= similar_width * wide;
    }
  }

  void find_pieces() {
    std::vector<char> seen(parts_.facets.size(), 0);
    for (std::uint32_t seed = 0; seed < seen.size(); ++seed) {
      if (seen[seed]) continue;
      seen[seed] = 1;
      Members piece = {seed};
      for (std::size_t i = 0; i < piece.size(); ++i)
        for (const auto l : links_of_[piece[i]])
          if (const auto g = other(l, piece[i]); smooth_[l] && !seen[g]) seen[g] = 1, piece.push_back(g);
      std::sort(piece.begin(), piece.end());
      if (piece.size() >= 3) pieces_.push_back(std::move(piece));
    }
  }

  /// Largest angle between neighbours inside the group.
  double bend_of(const Members& group, const std::vector<char>& inside) const {
    double bend = 0;
    for (const auto f : group)
      for (const auto l : links_of_[f])
        if (smooth_[l] && inside[other(l, f)]) bend = std::max(bend, parts_.links[l].angle);
    return bend;
  }

  std::optional<Patch> fit(const Members& group, PrimitiveKind kind, double bend, bool whole) {
    // Three equal flat faces at 45 degrees are a chamfered corner before they are a circle.
    if (bend > fine_bend && group.size() < 5) return std::nullopt;
    const bool strips = kind == PrimitiveKind::cylinder || kind == PrimitiveKind::cone;
    if (!strips && group.size() < 6) return std::nullopt;
    if (kind == PrimitiveKind::torus && !whole && ++tori_tried_ > most_tori) return std::nullopt;
    const FacetGroup corners(mesh_, parts_, group);
    if (corners.turning() < (whole ? 0.05 : 0.12)) return std::nullopt;
    auto found = corners.fit(kind, corner_error_, bend);
    if (!found || found->radius > 4 * size_) return std::nullopt;
    Patch patch;
    patch.facets = group;
    patch.hollow = is_hollow(*found, group);
    patch.primitive = *found;
    return patch;
  }

  bool is_hollow(const Primitive& primitive, const Members& group) const {
    double sum = 0;
    for (const auto f : group) sum += facet(f).area * facet(f).normal.dot(surface_normal(primitive, facet(f).middle));
    return sum < 0;
  }

  void keep(Patch patch) {
    const auto number = static_cast<std::uint32_t>(patches_.size());
    for (const auto f : patch.facets) patch_of_[f] = number;
    patches_.push_back(std::move(patch));
  }

  void take_piece(const Members& piece) {
    std::vector<char> inside(parts_.facets.size(), 0);
    for (const auto f : piece) inside[f] = 1;
    for (const auto kind : kinds)
      if (auto whole = fit(piece, kind, bend_of(piece, inside), true)) {
        keep(std::move(*whole));
        return;
      }
    Members seeds = piece;
    std::sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
      return facet(a).area != facet(b).area ? facet(a).area > facet(b).area : a < b;
    });
    std::size_t failures = 0;
    const std::size_t first = patches_.size();
    for (const auto seed : seeds) {
      if (patch_of_[seed] != none) continue;
      if (failures >= most_failures) break;
      auto patch = grown_from(seed, inside);
      if (patch)
        keep(std::move(*patch)), failures = 0;
      else
        ++failures;
    }
    drop_chance(piece, first);
  }

  /// Facets around `seed` in the piece, ring by ring, at most `most`.
  Members around(std::uint32_t seed, const std::vector<char>& inside, std::size_t rings, std::size_t most) const {
    Members group = {seed};
    std::size_t begin = 0;
    for (std::size_t ring = 0; ring < rings; ++ring) {
      const std::size_t end = group.size();
      for (; begin < end; ++begin)
        for (const auto l : links_of_[group[begin]]) {
          const auto g = other(l, group[begin]);
          if (!smooth_[l] || !inside[g] || patch_of_[g] != none || group.size() >= most) continue;
          if (std::find(group.begin(), group.end(), g) == group.end()) group.push_back(g);
        }
    }
    return group;
  }

  std::optional<Patch> grown_from(std::uint32_t seed, const std::vector<char>& inside) {
    std::vector<Members> groups;
    // The pair of neighbours on either side that bend alike: what a strip of a cylinder or cone has.
    const auto& links = links_of_[seed];
    double least_unlike = 0.1;
    Members strip;
    for (std::size_t i = 0; i < links.size(); ++i)
      for (std::size_t k = i + 1; k < links.size(); ++k) {
        const auto &p = parts_.links[links[i]], &q = parts_.links[links[k]];
        const auto a = other(links[i], seed), b = other(links[k], seed);
        if (!smooth_[links[i]] || !smooth_[links[k]] || a == b || p.convex != q.convex) continue;
        if (!inside[a] || !inside[b] || patch_of_[a] != none || patch_of_[b] != none || p.angle < 1e-3) continue;
        const double unlike = std::abs(p.angle - q.angle) / (p.angle + q.angle) - 1e-3 * (p.length + q.length) / size_;
        if (unlike < least_unlike) least_unlike = unlike, strip = {a, seed, b};
      }
    if (!strip.empty()) groups.push_back(strip), groups.push_back(longer(strip, inside));
    groups.push_back(around(seed, inside, 1, 16));
    groups.push_back(around(seed, inside, 2, 32));
    // A few strips of a torus pass for a cylinder: of all kinds the one that goes furthest is taken.
    std::optional<Patch> found;
    for (const auto kind : kinds) {
      if (kind == PrimitiveKind::torus && found && found->facets.size() > 40) break;
      std::optional<Patch> best;
      for (const auto& group : groups) {
        if (group.size() < 3) continue;
        std::vector<char> members(parts_.facets.size(), 0);
        for (const auto f : group) members[f] = 1;
        auto start = fit(group, kind, std::max(bend_of(group, members), 1e-3), false);
        if (!start) continue;
        auto patch = grown(std::move(*start), inside);
        if (patch && (!best || patch->facets.size() > best->facets.size())) best = std::move(patch);
      }
      if (best && (!found || 4 * best->facets.size() > 5 * found->facets.size())) found = std::move(best);
    }
    return found;
  }

  /// A strip goes on at both ends, bent alike, until it turns enough to tell a cone from a cylinder: facets may be
  /// fine.
  Members longer(const Members& strip, const std::vector<char>& inside) const {
    auto link_between = [&](std::uint32_t a, std::uint32_t b) {
      for (const auto l : links_of_[a])
        if (other(l, a) == b) return l;
      return none;
    };
    Members group = strip;
    double turning = 0;
    for (const auto& [from, to] : {std::pair(strip[1], strip[0]), std::pair(strip[1], strip[2])}) {
      std::uint32_t here = to, link = link_between(from, to);
      if (link == none) continue;
      const double bend = parts_.links[link].angle;
      const bool convex = parts_.links[link].convex;
      for (double turned = bend; turned < 0.5 * enough_turning;) {
        std::uint32_t next = none;
        for (const auto l : links_of_[here]) {
          const auto g = other(l, here);
          const auto& p = parts_.links[l];
          if (l == link || !smooth_[l] || !inside[g] || patch_of_[g] != none || p.convex != convex) continue;
          if (std::abs(p.angle - bend) < 0.1 * bend && std::find(group.begin(), group.end(), g) == group.end())
            next = l;
        }
        if (next == none) break;
        here = other(next, here), link = next, turned += parts_.links[next].angle;
        group.push_back(here);
        turning += parts_.links[next].angle;
      }
    }
    return turning > 0 ? group : Members{};
  }

  /// Everything connected that lies on the patch's surface, fitted again; nothing if that is too little to be sure.
  std::optional<Patch> grown(Patch patch, const std::vector<char>& inside) const {
    for (int round = 0; round < 3; ++round) {
      std::vector<char> member(parts_.facets.size(), 0);
      Members group = {patch.facets.front()};
      for (const auto f : patch.facets) member[f] = 1;
      group = patch.facets;
      const double bend = std::max(bend_of(group, member), 1e-3);
      for (std::size_t i = 0; i < group.size(); ++i)
        for (const auto l : links_of_[group[i]]) {
          const auto g = other(l, group[i]);
          if (member[g] || !inside[g] || patch_of_[g] != none || parts_.links[l].angle > 1.3 * bend + 0.01) continue;
          if (!facet_fits(*patch.primitive, mesh_, facet(g), 2 * corner_error_, 1.3 * bend)) continue;
          if ((facet(g).normal.dot(surface_normal(*patch.primitive, facet(g).middle)) < 0) != patch.hollow) continue;
          member[g] = 1, group.push_back(g);
        }
      const bool same = group.size() == patch.facets.size();
      if (!same) {
        auto again = FacetGroup(mesh_, parts_, group).fit(patch.primitive->kind, 2 * corner_error_, 1.3 * bend);
        if (!again) break;
        patch.primitive = *again;
        patch.facets = group;
      }
      if (same) break;
    }
    const FacetGroup corners(mesh_, parts_, patch.facets);
    double area = 0;
    for (const auto f : patch.facets) area += facet(f).area;
    const bool strip = patch.primitive->kind == PrimitiveKind::cylinder || patch.primitive->kind == PrimitiveKind::cone;
    if (corners.turning() < least_turning || area < small_area_ || patch.facets.size() < (strip ? 3u : 6u))
      return std::nullopt;
    if (patch.facets.size() < 8 && goes_on(patch.facets)) return std::nullopt;
    return patch;
  }

  /// The surface around goes on in facets of the same kind: a few of them on one cylinder are chance.
  bool goes_on(const Members& group) const {
    double border = 0, smooth = 0;
    for (const auto f : group)
      for (const auto l : links_of_[f]) {
        const auto g = other(l, f);
        if (std::find(group.begin(), group.end(), g) != group.end()) continue;
        border += parts_.links[l].length;
        if (smooth_[l] && patch_of_[g] == none) smooth += parts_.links[l].length;
      }
    return smooth > 0.4 * border;
  }

  /// A free surface has spots that happen to lie on something round.
  void drop_chance(const Members& piece, std::size_t first) {
    double all = 0, left = 0;
    for (const auto f : piece) all += facet(f).area, left += patch_of_[f] == none ? facet(f).area : 0;
    if (left < 0.4 * all) return;
    for (std::size_t p = first; p < patches_.size(); ++p) {
      double area = 0;
      for (const auto f : patches_[p].facets) area += facet(f).area;
      if (area > 0.03 * all) continue;
      for (const auto f : patches_[p].facets) patch_of_[f] = none;
      patches_[p].facets.clear();
    }
    std::erase_if(patches_, [](const Patch& p) { return p.facets.empty(); });
    for (std::uint32_t p = 0; p < patches_.size(); ++p)
      for (const auto f : patches_[p].facets) patch_of_[f] = p;
  }

  /// The first and last strip of a round surface are often cut narrower than the others.
  void absorb_strips() {
    for (std::uint32_t p = 0; p < patches_.size(); ++p) {
      Patch& patch = patches_[p];
      std::vector<char> member(parts_.facets.size(), 0);
      for (const auto f : patch.facets) member[f] = 1;
      const double bend = std::max(bend_of(patch.facets, member), 1e-3);
      for (std::size_t i = 0; i < patch.facets.size(); ++i)
        for (const auto l : links_of_[patch.facets[i]]) {
          const auto g = other(l, patch.facets[i]);
          if (patch_of_[g] != none || parts_.links[l].angle > 1.05 * bend + 0.01) continue;
          if (!facet_fits(*patch.primitive, mesh_, facet(g), 2 * corner_error_, bend)) continue;
          if ((facet(g).normal.dot(surface_normal(*patch.primitive, facet(g).middle)) < 0) != patch.hollow) continue;
          // A flat face that only touches is no strip: its bend would have to be that of the others.
          if (facet(g).area > 1.5 * facet(patch.facets.front()).area && facet(g).area > 4 * small_area_) continue;
          patch_of_[g] = p;
          patch.facets.push_back(g);
        }
    }
  }

  static bool same_surface(const Primitive& a, const Primitive& b, double within) {
    if (a.kind != b.kind || std::abs(a.radius - b.radius) > within || std::abs(a.tube - b.tube) > within) return false;
    const Vec3 apart = b.point - a.point;
    if (a.kind == PrimitiveKind::sphere) return apart.norm() <= within;
    if (std::abs(a.axis.dot(b.axis)) < 1 - 1e-6) return false;
    const Vec3 across = apart - apart.dot(a.axis) * a.axis;
    if (a.kind == PrimitiveKind::torus) return apart.norm() <= within;
    return across.norm() <= within && (a.kind == PrimitiveKind::cylinder);
  }

  /// Four to seven equal walls that close a circle, where the part is round: what a program makes of a small circle.
  void take_coarse_circles() {
    for (std::uint32_t seed = 0; seed < parts_.facets.size(); ++seed)
      for (std::size_t i = 0; i < links_of_[seed].size() && patch_of_[seed] == none; ++i) {
        const auto& link = parts_.links[links_of_[seed][i]];
        if (link.angle <= widest_bend || link.angle > sharpest_bend) continue;
        const Members ring = ring_from(seed, links_of_[seed][i]);
        if (ring.empty()) continue;
        const auto cylinder = FacetGroup(mesh_, parts_, ring).fit(PrimitiveKind::cylinder, corner_error_, link.angle);
        if (!cylinder) continue;
        double low = 1e300, high = -1e300;
        for (const auto f : ring)
          for (const auto v : facet(f).vertices) {
            const double t = (mesh_.vertices[v] - cylinder->point).dot(cylinder->axis);
            low = std::min(low, t), high = std::max(high, t);
          }
        if (!is_round_(*cylinder, low, high)) continue;
        Patch patch;
        patch.facets = ring, patch.primitive = *cylinder, patch.hollow = is_hollow(*cylinder, ring);
        keep(std::move(patch));
      }
  }

  /// The facets about the axis that the seed and its neighbour across `link` turn about, each bent like these two;
  /// empty if they do not close a circle.
  Members ring_from(std::uint32_t seed, std::uint32_t link) const {
    const double bend = parts_.links[link].angle;
    const bool convex = parts_.links[link].convex;
    const Vec3 axis = facet(seed).normal.cross(facet(other(link, seed)).normal).normalized();
    Members ring = {seed};
    while (ring.size() < 8) {
      const auto here = other(link, ring.back());
      if (here == seed)
        return std::abs(bend - 2 * pi / static_cast<double>(ring.size())) < alike_bend ? ring : Members{};
      if (patch_of_[here] != none || std::find(ring.begin(), ring.end(), here) != ring.end()) return {};
      ring.push_back(here);
      std::uint32_t next = none;
      for (const auto l : links_of_[here]) {
        const auto& p = parts_.links[l];
        if (l == link || p.convex != convex || std::abs(p.angle - bend) > alike_bend) continue;
        if (facet(here).normal.cross(facet(other(l, here)).normal).normalized().dot(axis) > 0.99) next = l;
      }
      if (next == none) return {};
      link = next;
    }
    return {};
  }

  /// Pieces of one cylinder or sphere that slots divide are one feature if they overlap along the axis.
  void merge_round() {
    const double within = 4 * corner_error_;
    auto range = [&](const Patch& patch, const Primitive& p) {
      std::array<double, 2> r = {1e300, -1e300};
      for (const auto f : patch.facets)
        for (const auto v : facet(f).vertices) {
          const double t = (mesh_.vertices[v] - p.point).dot(p.axis);
          r[0] = std::min(r[0], t), r[1] = std::max(r[1], t);
        }
      return r;
    };
    for (std::size_t a = 0; a < patches_.size(); ++a)
      for (std::size_t b = a + 1; b < patches_.size(); ++b) {
        Patch &p = patches_[a], &q = patches_[b];
        if (!p.primitive || !q.primitive || p.facets.empty() || q.facets.empty() || p.hollow != q.hollow) continue;
        if (!same_surface(*p.primitive, *q.primitive, within)) continue;
        if (p.primitive->kind == PrimitiveKind::cylinder) {
          const auto r = range(p, *p.primitive), s = range(q, *p.primitive);
          if (std::min(r[1], s[1]) - std::max(r[0], s[0]) < -10 * within) continue;
        }
        p.facets.insert(p.facets.end(), q.facets.begin(), q.facets.end());
        q.facets.clear();
      }
    std::vector<Patch> rest;
    for (auto& p : patches_)
      if (!p.facets.empty()) rest.push_back(std::move(p));
    patches_ = std::move(rest);
    for (std::uint32_t p = 0; p < patches_.size(); ++p)
      for (const auto f : patches_[p].facets) patch_of_[f] = p;
  }

  /// Isolated facets are flat faces; in a piece of many facets, those that are far larger than the others.
  void take_planes() {
    std::vector<std::uint32_t> company(parts_.facets.size(), 0);
    std::vector<double> typical(parts_.facets.size(), 0);
    for (const auto& piece : pieces_) {
      std::vector<double> areas;
      for (const auto f : piece)
        if (patch_of_[f] == none) areas.push_back(facet(f).area);
      if (areas.size() < 3) continue;
      const double middle = median_in_place(areas);
      for (const auto f : piece)
        if (patch_of_[f] == none) company[f] = static_cast<std::uint32_t>(areas.size()), typical[f] = middle;
    }
    Members planes;
    for (std::uint32_t f = 0; f < parts_.facets.size(); ++f) {
      if (patch_of_[f] != none || facet(f).area < small_area_) continue;
      const bool alone = company[f] < 3 && (facet(f).area > 4e-3 * total_area_ || !is_tessellation(f));
      const bool outstanding = facet(f).area > 8 * typical[f] && facet(f).area > 2e-3 * total_area_;
      const bool few = company[f] < 12 && facet(f).area > 1e-3 * total_area_;
      if (alone || outstanding || few) planes.push_back(f);
    }
    std::sort(planes.begin(), planes.end(), [&](std::uint32_t a, std::uint32_t b) {
      return facet(a).area != facet(b).area ? facet(a).area > facet(b).area : a < b;
    });
    if (planes.size() > most_planes) planes.resize(most_planes);
    for (const auto f : planes) {
      Patch patch;
      patch.facets = {f};
      Primitive plane;
      plane.kind = PrimitiveKind::plane;
      plane.point = facet(f).middle, plane.axis = facet(f).normal;
      patch.primitive = plane;
      keep(std::move(patch));
    }
  }

  /// It bends little into another facet of much the same size: a piece of something curved.
  bool is_tessellation(std::uint32_t f) const {
    for (const auto l : links_of_[f]) {
      const auto g = other(l, f);
      const double ratio = facet(g).area / facet(f).area;
      if (patch_of_[g] == none && parts_.links[l].angle < radians(20) && ratio > 0.1 && ratio < 10) return true;
    }
    return false;
  }

  /// What is left: connected free surfaces, and one collection of what is too small.
  void take_rest() {
    Members crumbs;
    for (std::uint32_t seed = 0; seed < parts_.facets.size(); ++seed) {
      if (patch_of_[seed] != none) continue;
      Patch patch;
      patch.facets = {seed};
      patch_of_[seed] = static_cast<std::uint32_t>(patches_.size());
      double area = 0;
      for (std::size_t i = 0; i < patch.facets.size(); ++i) {
        area += facet(patch.facets[i]).area;
        for (const auto l : links_of_[patch.facets[i]]) {
          const auto g = other(l, patch.facets[i]);
          if (patch_of_[g] != none || parts_.links[l].angle > widest_bend) continue;
          patch_of_[g] = patch_of_[seed];
          patch.facets.push_back(g);
        }
      }
      if (area >= std::max(small_area_, 1e-3 * total_area_)) {
        patches_.push_back(std::move(patch));
      } else {
        crumbs.insert(crumbs.end(), patch.facets.begin(), patch.facets.end());
        for (const auto f : patch.facets) patch_of_[f] = none - 1;
      }
    }
    if (crumbs.empty()) return;
    Patch patch;
    patch.facets = std::move(crumbs);
    patch.small = true;
    keep(std::move(patch));
  }

  // ---------------------------------------------------------------------------------------------------- description

  MeshFeature described(const Patch& patch, std::uint32_t number) const {
    MeshFeature feature;
    feature.primitive = patch.primitive;
    feature.hollow = patch.hollow;
    Vec3 middle = Vec3::Zero();
    for (const auto f : patch.facets) {
      feature.area += facet(f).area, middle += facet(f).area * facet(f).middle;
      feature.triangles.insert(feature.triangles.end(), facet(f).triangles.begin(), facet(f).triangles.end());
    }
    std::sort(feature.triangles.begin(), feature.triangles.end());
    if (feature.area > 0) middle /= feature.area;
    feature.middle = middle;
    if (!patch.primitive) {
      feature.kind = patch.small ? "small faces" : "free surface";
      return feature;
    }
    Primitive& p = *feature.primitive;
    Eigen::Index along;
    p.axis.cwiseAbs().maxCoeff(&along);
    if (p.kind != PrimitiveKind::plane && p.kind != PrimitiveKind::cone && p.axis[along] < 0) p.axis = -p.axis;
    for (const auto f : patch.facets)
      feature.sagitta = std::max(feature.sagitta, std::abs(distance(p, facet(f).middle)));
    if (p.kind == PrimitiveKind::plane) {
      feature.kind = "plane", feature.sagitta = 0;
      return feature;
    }
    feature.tangent = runs_into_neighbours(patch, number);
    if (p.kind == PrimitiveKind::sphere) {
      feature.kind = "sphere", feature.middle = p.point, feature.arc = 2 * pi;
      return feature;
    }
    measure_along_axis(patch, feature);
    // The foot of the patch's own middle, so that places are on the feature.
    const double middle_along = 0.5 * (feature.low + feature.high);
    if (p.kind == PrimitiveKind::cylinder) {
      p.point += middle_along * p.axis;
      feature.low -= middle_along, feature.high -= middle_along;
    }
    feature.middle = p.kind == PrimitiveKind::cone ? Vec3(p.point + middle_along * p.axis) : p.point;
    const bool full = feature.arc > radians(240);
    if (p.kind == PrimitiveKind::torus)
      feature.kind = feature.tangent ? feature.hollow ? "fillet" : "round" : "torus";
    else if (p.kind == PrimitiveKind::cone)
      feature.kind = "cone";
    else if (full)
      feature.kind = feature.hollow ? "hole" : "boss";
    else if (feature.tangent && feature.arc < radians(150))
      feature.kind = feature.hollow ? "fillet" : "round";
    else
      feature.kind = "cylinder";
    return feature;
  }

  /// More than half of its border with other faces is smooth.
  bool runs_into_neighbours(const Patch& patch, std::uint32_t number) const {
    double border = 0, smooth = 0;
    std::vector<char> member(parts_.facets.size(), 0);
    for (const auto f : patch.facets) member[f] = 1;
    const double limit = std::max(1.1 * bend_of(patch.facets, member), radians(3));
    for (const auto f : patch.facets)
      for (const auto l : links_of_[f])
        if (patch_of_[other(l, f)] != number) {
          border += parts_.links[l].length;
          if (parts_.links[l].angle < std::min(limit, radians(30))) smooth += parts_.links[l].length;
        }
    return smooth > 0.5 * border;
  }

  void measure_along_axis(const Patch& patch, MeshFeature& feature) const {
    const Primitive& p = *feature.primitive;
    const Mat3 frame = rotation_onto_axis(p.axis);
    std::vector<char> bins(720, 0);
    feature.low = 1e300, feature.high = -1e300;
    for (const auto f : patch.facets) {
      // Angles of the corners relative to the facet's middle, so that no facet spans the seam.
      const Vec3 m = frame.transpose() * (facet(f).middle - p.point);
      const double centre = std::atan2(m.y(), m.x());
      double first = 0, last = 0;
      for (const auto v : facet(f).vertices) {
        const Vec3 q = frame.transpose() * (mesh_.vertices[v] - p.point);
        feature.low = std::min(feature.low, q.z()), feature.high = std::max(feature.high, q.z());
        if (std::hypot(q.x(), q.y()) < 1e-6 * size_) continue;
        const double a = std::remainder(std::atan2(q.y(), q.x()) - centre, 2 * pi);
        first = std::min(first, a), last = std::max(last, a);
      }
      const double step = 2 * pi / 720;
      const auto from = static_cast<long>(std::floor((centre + first) / step)),
                 to = static_cast<long>(std::floor((centre + last) / step));
      for (long k = from; k <= to; ++k) bins[static_cast<std::size_t>(((k % 720) + 720) % 720)] = 1;
    }
    feature.arc = 2 * pi * static_cast<double>(std::count(bins.begin(), bins.end(), 1)) / 720;
  }

  MeshFeatures named() {
    MeshFeatures result;
    for (std::uint32_t p = 0; p < patches_.size(); ++p) result.features.push_back(described(patches_[p], p));
    name_features(result.features, small_count());
    result.feature_of.assign(mesh_.triangles.size(), 0);
    for (std::uint32_t i = 0; i < result.features.size(); ++i)
      for (const auto t : result.features[i].triangles) result.feature_of[t] = i;
    return result;
  }

  std::size_t small_count() const {
    for (const auto& p : patches_)
      if (p.small) return p.facets.size();
    return 0;
  }
};

}  // namespace

Vec3 surface_normal(const Primitive& primitive, const Vec3& point) {
  const Vec3 d = point - primitive.point;
  const double along = d.dot(primitive.axis);
  const Vec3 across = d - along * primitive.axis;
  const double radius = across.norm();
  const Vec3 outward = radius > 0 ? Vec3(across / radius) : Vec3(rotation_onto_axis(primitive.axis).col(0));
  switch (primitive.kind) {
    case PrimitiveKind::plane:
      return primitive.axis;
    case PrimitiveKind::sphere:
      return d.norm() > 0 ? Vec3(d.normalized()) : primitive.axis;
    case PrimitiveKind::cone:
      return std::cos(primitive.half_angle) * outward - std::sin(primitive.half_angle) * primitive.axis;
    case PrimitiveKind::torus: {
      const Vec3 from_ring = d - primitive.radius * outward;
      return from_ring.norm() > 0 ? Vec3(from_ring.normalized()) : outward;
    }
    default:
      return outward;
  }
}

MeshFeatures recognise_features(const TriangleMesh& mesh, double tolerance, const IsRound& is_round) {
  return Recogniser(mesh, tolerance, is_round).run();
}

int sides_of(const MeshFeature& feature) {
  if (!feature.primitive || feature.primitive->kind != PrimitiveKind::cylinder) return 0;
  const double radius = feature.primitive->radius;
  if (!(feature.sagitta > 1e-6 * radius) || !(feature.sagitta < radius)) return 0;
  return static_cast<int>(std::lround(pi / std::acos(1 - feature.sagitta / radius)));
}

}  // namespace partscribe::verify
