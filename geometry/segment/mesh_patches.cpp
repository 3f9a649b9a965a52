#include "geometry/segment/mesh_patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/disjoint_sets.h"
#include "core/number.h"
#include "core/statistics.h"
#include "geometry/segment/faces.h"
#include "geometry/segment/fit_facets.h"

namespace partscribe::geometry {
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
using Patch = MeshPatch;

class Grower {
 public:
  Grower(const TriangleMesh& mesh, const Facets& facets, const FaceOptions& options)
      : mesh_(mesh),
        parts_(facets),
        options_(options),
        size_(mesh.bounds().diagonal()),
        corner_error_(std::max(4e-6 * size_, 0.01 * options.tolerance)) {}

  MeshPatches run() {
    prepare();
    find_pieces();
    for (const auto& piece : pieces_) take_piece(piece);
    if (options_.is_round) take_coarse_circles();
    unite_neighbours();
    absorb_strips();
    unite_neighbours();
    if (options_.join_pieces) merge_round();
    take_planes();
    take_rest();
    return {std::move(patches_), corner_error_};
  }

 private:
  const TriangleMesh& mesh_;
  const Facets& parts_;
  const FaceOptions& options_;
  double size_, corner_error_;
  double total_area_ = 0, small_area_ = 0;
  std::vector<std::vector<std::uint32_t>> links_of_;  // of each facet, indices into parts_.links
  std::vector<std::uint8_t> smooth_;                  // of each link
  std::vector<std::uint32_t> patch_of_;               // of each facet
  std::vector<Members> pieces_;
  std::vector<std::uint32_t> piece_of_;       // of each facet; none if it is in no piece of three
  mutable std::vector<std::uint32_t> marks_;  // of each facet: the last group it was marked for
  mutable std::uint32_t mark_ = 0;
  std::vector<Patch> patches_;
  std::size_t tori_tried_ = 0;

  const Facet& facet(std::uint32_t f) const { return parts_.facets[f]; }
  std::uint32_t other(std::uint32_t link, std::uint32_t f) const {
    const auto& l = parts_.links[link];
    return l.first == f ? l.second : l.first;
  }

  void prepare() {
    patch_of_.assign(parts_.facets.size(), none);
    piece_of_.assign(parts_.facets.size(), none);
    marks_.assign(parts_.facets.size(), 0);
    links_of_.resize(parts_.facets.size());
    for (const auto& f : parts_.facets) total_area_ += f.area;
    small_area_ = std::max(16 * options_.tolerance * options_.tolerance, 2e-5 * total_area_);
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
      if (piece.size() < 3) continue;
      for (const auto f : piece) piece_of_[f] = static_cast<std::uint32_t>(pieces_.size());
      pieces_.push_back(std::move(piece));
    }
  }

  /// Marks the facets of one group; those of the group before are no longer marked.
  void mark(const Members& group) const {
    ++mark_;
    for (const auto f : group) marks_[f] = mark_;
  }
  bool marked(std::uint32_t f) const { return marks_[f] == mark_; }

  /// Largest angle between neighbours inside the marked group.
  double bend_of(const Members& group) const {
    double bend = 0;
    for (const auto f : group)
      for (const auto l : links_of_[f])
        if (smooth_[l] && marked(other(l, f))) bend = std::max(bend, parts_.links[l].angle);
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
    patch.surface = *found;
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
    mark(piece);
    const double bend = bend_of(piece);
    for (const auto kind : kinds)
      if (auto whole = fit(piece, kind, bend, true)) {
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
      auto patch = grown_from(seed);
      if (patch)
        keep(std::move(*patch)), failures = 0;
      else
        ++failures;
    }
    drop_chance(piece, first);
  }

  /// Facets around `seed` in the piece, ring by ring, at most `most`.
  Members around(std::uint32_t seed, std::size_t rings, std::size_t most) const {
    Members group = {seed};
    std::size_t begin = 0;
    for (std::size_t ring = 0; ring < rings; ++ring) {
      const std::size_t end = group.size();
      for (; begin < end; ++begin)
        for (const auto l : links_of_[group[begin]]) {
          const auto g = other(l, group[begin]);
          if (!smooth_[l] || !inside(g, seed) || patch_of_[g] != none || group.size() >= most) continue;
          if (std::find(group.begin(), group.end(), g) == group.end()) group.push_back(g);
        }
    }
    return group;
  }

  bool inside(std::uint32_t f, std::uint32_t seed) const { return piece_of_[f] == piece_of_[seed]; }

  std::optional<Patch> grown_from(std::uint32_t seed) {
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
        if (!inside(a, seed) || !inside(b, seed) || patch_of_[a] != none || patch_of_[b] != none || p.angle < 1e-3)
          continue;
        const double unlike = std::abs(p.angle - q.angle) / (p.angle + q.angle) - 1e-3 * (p.length + q.length) / size_;
        if (unlike < least_unlike) least_unlike = unlike, strip = {a, seed, b};
      }
    if (!strip.empty()) groups.push_back(strip), groups.push_back(longer(strip));
    groups.push_back(around(seed, 1, 16));
    groups.push_back(around(seed, 2, 32));
    // A few strips of a torus pass for a cylinder: of all kinds the one that goes furthest is taken.
    std::optional<Patch> found;
    for (const auto kind : kinds) {
      if (kind == PrimitiveKind::torus && found && found->facets.size() > 40) break;
      std::optional<Patch> best;
      for (const auto& group : groups) {
        if (group.size() < 3) continue;
        mark(group);
        auto start = fit(group, kind, std::max(bend_of(group), 1e-3), false);
        if (!start) continue;
        auto patch = grown(std::move(*start));
        if (patch && (!best || patch->facets.size() > best->facets.size())) best = std::move(patch);
      }
      if (best && (!found || 4 * best->facets.size() > 5 * found->facets.size())) found = std::move(best);
    }
    return found;
  }

  /// A strip goes on at both ends, bent alike, until it turns enough to tell a cone from a cylinder: facets may be
  /// fine.
  Members longer(const Members& strip) const {
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
          if (l == link || !smooth_[l] || !inside(g, strip[0]) || patch_of_[g] != none || p.convex != convex) continue;
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
  std::optional<Patch> grown(Patch patch) const {
    for (int round = 0; round < 3; ++round) {
      Members group = patch.facets;
      mark(group);
      const double bend = std::max(bend_of(group), 1e-3);
      for (std::size_t i = 0; i < group.size(); ++i)
        for (const auto l : links_of_[group[i]]) {
          const auto g = other(l, group[i]);
          if (marked(g) || !inside(g, group.front()) || patch_of_[g] != none ||
              parts_.links[l].angle > 1.3 * bend + 0.01)
            continue;
          if (!facet_fits(*patch.surface, mesh_, facet(g), 2 * corner_error_, 1.3 * bend)) continue;
          if ((facet(g).normal.dot(surface_normal(*patch.surface, facet(g).middle)) < 0) != patch.hollow) continue;
          marks_[g] = mark_, group.push_back(g);
        }
      const bool same = group.size() == patch.facets.size();
      if (!same) {
        auto again = FacetGroup(mesh_, parts_, group).fit(patch.surface->kind, 2 * corner_error_, 1.3 * bend);
        if (!again) break;
        patch.surface = *again;
        patch.facets = group;
      }
      if (same) break;
    }
    const FacetGroup corners(mesh_, parts_, patch.facets);
    double area = 0;
    for (const auto f : patch.facets) area += facet(f).area;
    const bool strip = patch.surface->kind == PrimitiveKind::cylinder || patch.surface->kind == PrimitiveKind::cone;
    if (corners.turning() < least_turning || area < small_area_ || patch.facets.size() < (strip ? 3u : 6u))
      return std::nullopt;
    if (patch.facets.size() < 8 && goes_on(patch.facets)) return std::nullopt;
    return patch;
  }

  /// The surface around goes on in facets of the same kind: a few of them on one cylinder are chance.
  bool goes_on(const Members& group) const {
    double border = 0, smooth = 0;
    mark(group);
    for (const auto f : group)
      for (const auto l : links_of_[f]) {
        const auto g = other(l, f);
        if (marked(g)) continue;
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
    number_patches();
  }

  /// Neighbours that one surface of either kind goes through are one: growth may have stopped at facets that are bent
  /// more than those where it began.
  void unite_neighbours() {
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::uint32_t l = 0; l < parts_.links.size(); ++l) {
      const auto p = patch_of_[parts_.links[l].first], q = patch_of_[parts_.links[l].second];
      const bool bent = parts_.links[l].angle <= widest_bend;  // how wide the facets are does not matter here
      if (bent && p != q && p != none && q != none) pairs.insert({std::min(p, q), std::max(p, q)});
    }
    DisjointSets united(patches_.size());
    for (const auto& [first, second] : pairs) {
      const auto p = united.root(first), q = united.root(second);
      if (p == q || patches_[p].hollow != patches_[q].hollow) continue;
      Members both = patches_[p].facets;
      both.insert(both.end(), patches_[q].facets.begin(), patches_[q].facets.end());
      mark(both);
      const double bend = std::max(bend_of(both), 1e-3);
      const FacetGroup group(mesh_, parts_, both);
      const bool larger = patches_[p].facets.size() >= patches_[q].facets.size();
      for (const auto kind : {patches_[larger ? p : q].surface->kind, patches_[larger ? q : p].surface->kind})
        if (const auto surface = group.fit(kind, 2 * corner_error_, 1.3 * bend)) {
          united.unite(p, q);
          const auto into = united.root(p), gone = into == p ? q : p;
          patches_[into].facets = std::move(both), patches_[into].surface = *surface;
          patches_[gone].facets.clear();
          break;
        }
    }
    number_patches();
  }

  /// Drops empty patches; facets follow.
  void number_patches() {
    std::erase_if(patches_, [](const Patch& p) { return p.facets.empty(); });
    for (std::uint32_t p = 0; p < patches_.size(); ++p)
      for (const auto f : patches_[p].facets) patch_of_[f] = p;
  }

  /// The first and last strip of a round surface are often cut narrower than the others.
  void absorb_strips() {
    for (std::uint32_t p = 0; p < patches_.size(); ++p) {
      Patch& patch = patches_[p];
      mark(patch.facets);
      const double bend = std::max(bend_of(patch.facets), 1e-3);
      for (std::size_t i = 0; i < patch.facets.size(); ++i)
        for (const auto l : links_of_[patch.facets[i]]) {
          const auto g = other(l, patch.facets[i]);
          if (patch_of_[g] != none || parts_.links[l].angle > 1.05 * bend + 0.01) continue;
          if (!facet_fits(*patch.surface, mesh_, facet(g), 2 * corner_error_, bend)) continue;
          if ((facet(g).normal.dot(surface_normal(*patch.surface, facet(g).middle)) < 0) != patch.hollow) continue;
          // A flat face that only touches is no strip: its bend would have to be that of the others.
          if (facet(g).area > 1.5 * facet(patch.facets.front()).area && facet(g).area > 4 * small_area_) continue;
          patch_of_[g] = p;
          patch.facets.push_back(g);
        }
    }
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
        if (!options_.is_round(*cylinder, low, high)) continue;
        Patch patch;
        patch.facets = ring, patch.surface = *cylinder, patch.hollow = is_hollow(*cylinder, ring);
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

  static bool same_surface(const Primitive& a, const Primitive& b, double within) {
    if (a.kind != b.kind || std::abs(a.radius - b.radius) > within || std::abs(a.tube - b.tube) > within) return false;
    const Vec3 apart = b.point - a.point;
    if (a.kind == PrimitiveKind::sphere) return apart.norm() <= within;
    if (std::abs(a.axis.dot(b.axis)) < 1 - 1e-6) return false;
    const Vec3 across = apart - apart.dot(a.axis) * a.axis;
    if (a.kind == PrimitiveKind::torus) return apart.norm() <= within;
    return across.norm() <= within && (a.kind == PrimitiveKind::cylinder);
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
        if (!p.surface || !q.surface || p.facets.empty() || q.facets.empty() || p.hollow != q.hollow) continue;
        if (!same_surface(*p.surface, *q.surface, within)) continue;
        if (p.surface->kind == PrimitiveKind::cylinder) {
          const auto r = range(p, *p.surface), s = range(q, *p.surface);
          if (std::min(r[1], s[1]) - std::max(r[0], s[0]) < -10 * within) continue;
        }
        p.facets.insert(p.facets.end(), q.facets.begin(), q.facets.end());
        q.facets.clear();
      }
    number_patches();
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
      patch.surface = plane;
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
    patch.crumbs = true;
    keep(std::move(patch));
  }
};

}  // namespace

MeshPatches mesh_patches(const TriangleMesh& mesh, const Facets& facets, const FaceOptions& options) {
  return Grower(mesh, facets, options).run();
}

}  // namespace partscribe::geometry
