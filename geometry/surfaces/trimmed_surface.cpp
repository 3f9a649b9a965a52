#include "geometry/surfaces/trimmed_surface.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <queue>
#include <set>
#include <tuple>

#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_part.h"
#include "geometry/surfaces/nurbs_edit.h"

namespace partscribe::geometry {
namespace {

constexpr std::uint32_t no_corner = ~0u;

// ---- edges ------------------------------------------------------------------------------------------------------

/// A use of an edge by one surface.
struct BorderUse {
  std::uint32_t patch, loop, curve;
};

/// Places along an edge, as shares of the domain of its first curve, and the corners of the mesh there.
struct Edge {
  std::vector<BorderUse> uses;
  std::vector<double> shares;
  std::vector<std::uint32_t> corners;
};

Vec2 place_at(const SurfaceTrim& trim, double share) {
  const auto& t = trim.curve.t;
  return trim.curve.at(t.low() + share * (t.high() - t.low()));
}

class EdgeSampler {
 public:
  EdgeSampler(std::span<const TrimmedSurface> surfaces, const Edge& edge, double deviation)
      : surfaces_(surfaces), edge_(edge), deviation_(deviation) {}

  std::vector<double> shares() const {
    std::vector<double> result = {0};
    // A curve of many spans may cross its chord between two places; each span is looked at by itself.
    std::vector<double> breaks;
    for (std::size_t i = 0; i < edge_.uses.size(); ++i) {
      const auto& t = trim(i).curve.t;
      for (const double knot : t.breaks()) {
        const double share = (knot - t.low()) / (t.high() - t.low());
        breaks.push_back(i == 0 ? share : 1 - share);
      }
    }
    std::sort(breaks.begin(), breaks.end());
    for (const double at : breaks)
      if (at > result.back() + 1e-9) refine(result.back(), std::min(at, 1.0), 0, result);
    result.back() = 1;
    return result;
  }

 private:
  const SurfaceTrim& trim(std::size_t use) const {
    const BorderUse& e = edge_.uses[use];
    return surfaces_[e.patch].loops[e.loop][e.curve];
  }
  Vec3 on(std::size_t use, const Vec2& uv) const { return surfaces_[edge_.uses[use].patch].surface.at(uv.x(), uv.y()); }

  void refine(double a, double b, int depth, std::vector<double>& out) const {
    bool straight = depth >= 1;  // two pieces at least: the middle of a closed curve says nothing
    for (std::size_t i = 0; straight && i < edge_.uses.size(); ++i) {
      const auto uv = [&](double share) { return place_at(trim(i), i == 0 ? share : 1 - share); };
      const Vec2 p = uv(a), q = uv(b);
      const Vec3 from = on(i, p), to = on(i, q);
      for (const double at : {0.31, 0.5, 0.73}) {
        const Vec3 exact = on(i, uv(a + at * (b - a))), chord = from + at * (to - from);
        const Vec3 along = (to - from).normalized(), off = exact - chord;
        straight = straight && (off - off.dot(along) * along).norm() < deviation_ &&
                   (on(i, p + at * (q - p)) - exact).norm() < 8 * deviation_;
      }
    }
    if (straight || depth > 12) {
      out.push_back(b);
      return;
    }
    refine(a, 0.5 * (a + b), depth + 1, out);
    refine(0.5 * (a + b), b, depth + 1, out);
  }

  std::span<const TrimmedSurface> surfaces_;
  const Edge& edge_;
  double deviation_;
};

// ---- one surface ------------------------------------------------------------------------------------------------

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
struct PatchVertex {
  std::uint32_t corner = no_corner;
};
struct PatchFace {
  int depth = -1;
  bool inside = false;
};
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<PatchVertex, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<PatchFace, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Delaunay =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::Exact_predicates_tag>;

/// A corner of the triangles of one surface.
struct Corner {
  Vec2 uv;
  std::uint32_t vertex;  ///< of the mesh; no_corner: inside, not made yet
};

/// Between which places along a line v = const. the loops hold the surface, ascending.
template <class Place>
std::vector<double> crossings(const std::vector<std::vector<Place>>& loops, double v) {
  std::vector<double> result;
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec2 &a = loop[i].uv, &b = loop[(i + 1) % loop.size()].uv;
      if ((a.y() <= v) == (b.y() <= v)) continue;
      result.push_back(a.x() + (v - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
  std::sort(result.begin(), result.end());
  return result;
}

/// The triangles of one surface: its border first, then the crossings of its knots, then places where a triangle lies
/// farthest off the surface, until none lies too far off (Delaunay insertion, coarse to fine).
class Patch {
 public:
  Patch(const NurbsSurface& surface, std::vector<std::vector<Corner>> loops, double deviation)
      : surface_(surface), loops_(std::move(loops)), deviation_(deviation) {
    for (const auto& loop : loops_)
      for (const Corner& c : loop) low_ = low_.cwiseMin(c.uv), high_ = high_.cwiseMax(c.uv);
    scale_ = lengths();
  }

  void triangulate(std::uint32_t number, SurfaceTriangles& out) {
    if (!finite()) return;
    for (const auto& loop : loops_) {
      Vertex first, last;
      for (const Corner& c : loop) {
        const Vertex vertex = insert(c);
        if (last != nullptr && last != vertex) delaunay_.insert_constraint(last, vertex);
        if (last == nullptr) first = vertex;
        last = vertex;
      }
      if (last != nullptr && last != first) delaunay_.insert_constraint(last, first);
    }
    if (delaunay_.dimension() < 2) return;  // a border without an inside
    // Where loops cross each other there are vertices that nobody asked for.
    for (const auto vertex : delaunay_.finite_vertex_handles()) {
      if (vertex->info().corner != no_corner) continue;
      vertex->info().corner = static_cast<std::uint32_t>(corners_.size());
      corners_.push_back({{vertex->point().x() / scale_.x(), vertex->point().y() / scale_.y()}, no_corner});
    }
    for (const Vec2& uv : crossings_of_knots()) insert({uv, no_corner});
    mark();
    refine();
    for (const auto face : delaunay_.finite_face_handles()) {
      if (!face->info().inside) continue;
      std::array<std::uint32_t, 3> triangle;
      std::array<Vec2, 3> place;
      for (int k = 0; k < 3; ++k) {
        Corner& c = corners_[face->vertex(k)->info().corner];
        if (c.vertex == no_corner) {
          c.vertex = static_cast<std::uint32_t>(out.mesh.vertices.size());
          out.mesh.vertices.push_back(surface_.at(c.uv.x(), c.uv.y()));
        }
        triangle[std::size_t(k)] = c.vertex, place[std::size_t(k)] = c.uv;
      }
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
      out.mesh.triangles.push_back(triangle);
      out.patch.push_back(number);
      out.place.push_back(place);
      out.deviation = std::max(out.deviation, worst_place(face).off);
    }
  }

 private:
  bool finite() const {
    bool all = scale_.allFinite();
    for (const auto& loop : loops_)
      for (const Corner& c : loop) all = all && c.uv.allFinite();
    for (const Vec3& p : surface_.points) all = all && p.allFinite();
    return all;
  }

  using Vertex = Delaunay::Vertex_handle;
  using Face = Delaunay::Face_handle;

  Vertex insert(const Corner& corner) {
    const auto vertex =
        delaunay_.insert(Kernel::Point_2(corner.uv.x() * scale_.x(), corner.uv.y() * scale_.y()), hint_);
    hint_ = vertex->face();
    if (vertex->info().corner != no_corner) return vertex;  // there was one already
    vertex->info().corner = static_cast<std::uint32_t>(corners_.size());
    corners_.push_back(corner);
    return vertex;
  }

  /// mm per unit of u and of v, on the whole: triangles are to be round in space.
  Vec2 lengths() const {
    Vec2 sum = Vec2::Zero();
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j) {
        const Vec2 uv = low_ + (high_ - low_).cwiseProduct(Vec2((i + 0.5) / 8, (j + 0.5) / 8));
        const SurfacePoint at = surface_.derivatives(uv.x(), uv.y());
        sum += Vec2(at.du.norm(), at.dv.norm());
      }
    return (sum / 64).cwiseMax(1e-9);
  }

  /// Where lines of knots cross inside of the border: between them the surface is one polynomial.
  std::vector<Vec2> crossings_of_knots() const {
    std::vector<Vec2> result;
    const auto us = surface_.u.breaks(), vs = surface_.v.breaks();
    for (const double v : vs) {
      if (!(v > low_.y() && v < high_.y())) continue;
      const auto crossed = crossings(loops_, v);
      for (std::size_t i = 1; i + 1 < us.size(); ++i) {
        const auto next = std::upper_bound(crossed.begin(), crossed.end(), us[i]);
        if ((next - crossed.begin()) % 2 == 0) continue;
        const double free = std::min(next == crossed.end() ? 1e300 : *next - us[i], us[i] - *(next - 1));
        if (free > 0.3 * std::min(us[i] - us[i - 1], us[i + 1] - us[i])) result.emplace_back(us[i], v);
      }
    }
    return result;
  }

  /// Inside are the triangles with an odd number of borders between them and the outside.
  void mark() {
    for (const auto face : delaunay_.all_face_handles()) face->info().depth = -1;
    std::vector<Face> level = {delaunay_.infinite_face()}, next;
    for (int depth = 0; !level.empty(); ++depth, level.swap(next), next.clear())
      while (!level.empty()) {
        const auto face = level.back();
        level.pop_back();
        if (face->info().depth >= 0) continue;
        face->info().depth = depth, face->info().inside = depth % 2 == 1;
        for (int k = 0; k < 3; ++k) (face->is_constrained(k) ? next : level).push_back(face->neighbor(k));
      }
  }

  struct Worst {
    double off = 0;  ///< mm
    Vec2 uv;
  };

  /// Where a triangle lies farthest off: of its middle and the middles of edges that are no border.
  Worst worst_place(Face face) const {
    Vec2 uv[3];
    Vec3 p[3];
    for (int k = 0; k < 3; ++k) {
      uv[k] = corners_[face->vertex(k)->info().corner].uv;
      p[k] = surface_.at(uv[k].x(), uv[k].y());
    }
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    Worst worst;
    const auto look = [&](const Vec2& at, const Vec3& flat) {
      const double off = std::abs((surface_.at(at.x(), at.y()) - flat).dot(normal));
      if (off > worst.off) worst = {off, at};
    };
    look((uv[0] + uv[1] + uv[2]) / 3, (p[0] + p[1] + p[2]) / 3);
    for (int k = 0; k < 3; ++k)
      if (!face->is_constrained(k))
        look(0.5 * (uv[(k + 1) % 3] + uv[(k + 2) % 3]), 0.5 * (p[(k + 1) % 3] + p[(k + 2) % 3]));
    return worst;
  }

  void refine() {
    // The worst first; what was told of a triangle that is no more is passed over.
    struct Entry {
      double off;
      std::uint32_t corner[3];
      Face face;
      Vec2 uv;
      bool operator<(const Entry& o) const {
        return off != o.off ? off < o.off : std::lexicographical_compare(corner, corner + 3, o.corner, o.corner + 3);
      }
    };
    std::priority_queue<Entry> queue;
    const auto enter = [&](Face face) {
      const Worst worst = worst_place(face);
      if (!(worst.off > deviation_)) return;
      Entry entry{worst.off, {}, face, worst.uv};
      for (int k = 0; k < 3; ++k) entry.corner[k] = face->vertex(k)->info().corner;
      queue.push(entry);
    };
    for (const auto face : delaunay_.finite_face_handles())
      if (face->info().inside) enter(face);
    constexpr std::size_t most = 2'000'000;
    while (!queue.empty() && corners_.size() < most) {
      const Entry worst = queue.top();
      queue.pop();
      bool there = true;
      for (int k = 0; k < 3; ++k) there = there && worst.face->vertex(k)->info().corner == worst.corner[k];
      if (!there) continue;
      hint_ = worst.face;
      const std::size_t before = delaunay_.number_of_vertices();
      const Vertex vertex = insert({worst.uv, no_corner});
      if (delaunay_.number_of_vertices() == before) continue;  // there was one, but for rounding
      auto face = delaunay_.incident_faces(vertex);
      const auto end = face;
      do {
        face->info().inside = true;
        enter(face);
      } while (++face != end);
    }
  }

  const NurbsSurface& surface_;
  std::vector<std::vector<Corner>> loops_;
  double deviation_;
  Vec2 low_ = Vec2::Constant(1e300), high_ = Vec2::Constant(-1e300), scale_ = Vec2::Ones();
  std::vector<Corner> corners_;
  Delaunay delaunay_;
  Face hint_;
};

/// Two surfaces may each have an inner edge between the same two corners of their borders, the first `border_corners`
/// of the mesh. Each of these gets a corner of its own in the middle, so that no edge has more than two triangles.
void split_twins(std::span<const TrimmedSurface> surfaces, std::uint32_t border_corners, SurfaceTriangles& out) {
  struct Use {
    std::uint32_t a, b, patch, triangle;
    bool operator<(const Use& o) const {
      return std::tie(a, b, patch, triangle) < std::tie(o.a, o.b, o.patch, o.triangle);
    }
  };
  const auto split = [&](const Use& use, std::uint32_t middle, const Vec2& uv) {
    auto &corners = out.mesh.triangles[use.triangle], rest = corners;
    auto &places = out.place[use.triangle], places_of_rest = places;
    for (std::size_t k = 0; k < 3; ++k) {
      if (corners[k] == use.a) rest[k] = middle, places_of_rest[k] = uv;
      if (corners[k] == use.b) corners[k] = middle, places[k] = uv;
    }
    out.mesh.triangles.push_back(rest), out.place.push_back(places_of_rest), out.patch.push_back(use.patch);
  };
  const auto middle_of = [&](const Use& use) {
    Vec2 sum = Vec2::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      if (const auto corner = out.mesh.triangles[use.triangle][k]; corner == use.a || corner == use.b)
        sum += out.place[use.triangle][k];
    return Vec2(0.5 * sum);
  };
  for (std::set<std::uint32_t> changed = {0}; !changed.empty();) {
    changed.clear();
    std::vector<Use> uses;
    for (std::uint32_t t = 0; t < out.mesh.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(out.mesh.triangles[t][k], out.mesh.triangles[t][(k + 1) % 3]);
        if (b < border_corners) uses.push_back({a, b, out.patch[t], t});
      }
    std::sort(uses.begin(), uses.end());
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
      while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
      for (std::size_t k = i; end - i > 2 && k + 1 < end; ++k) {
        const Use one = uses[k], other = uses[k + 1];
        if (one.patch != other.patch || changed.count(one.triangle) || changed.count(other.triangle)) continue;
        const auto middle = static_cast<std::uint32_t>(out.mesh.vertices.size());
        const Vec2 uv = middle_of(one);
        out.mesh.vertices.push_back(surfaces[one.patch].surface.at(uv.x(), uv.y()));
        for (const Use& use : {one, other}) split(use, middle, uv), changed.insert(use.triangle);
      }
    }
  }
}

}  // namespace

TrimmedSurface turned_over(const TrimmedSurface& given) {
  TrimmedSurface result = given;
  const NurbsSurface& s = result.surface = reversed(given.surface, true);
  for (auto& loop : result.loops) {
    std::reverse(loop.begin(), loop.end());
    for (auto& trim : loop) {
      trim.curve = reversed(trim.curve);
      for (Vec2& p : trim.curve.points) p.x() = s.u.low() + s.u.high() - p.x();
    }
  }
  return result;
}

EdgeEnds::EdgeEnds(std::span<const TrimmedSurface> surfaces) {
  std::vector<int> parent;
  const auto root = [&](int i) {
    while (parent[std::size_t(i)] != i) i = parent[std::size_t(i)];
    return i;
  };
  const auto number = [&](int edge, bool last) {
    const auto [at, is_new] = places_.try_emplace({edge, last}, static_cast<int>(parent.size()));
    if (is_new) parent.push_back(at->second);
    return root(at->second);
  };
  std::set<int> used;
  for (const auto& surface : surfaces)
    for (const auto& loop : surface.loops) {
      std::vector<char> against;
      for (const auto& trim : loop) against.push_back(!used.insert(trim.edge).second);
      for (std::size_t c = 0; c < loop.size(); ++c) {
        const std::size_t after = (c + 1) % loop.size();
        const int a = number(loop[c].edge, !against[c]), b = number(loop[after].edge, against[after]);
        parent[std::size_t(std::max(a, b))] = std::min(a, b);
      }
    }
  for (auto& [end, place] : places_) place = root(place);
}

SurfaceTriangles triangulated(std::span<const TrimmedSurface> surfaces, double deviation) {
  SurfaceTriangles result;
  std::map<int, Edge> edges;
  for (std::uint32_t p = 0; p < surfaces.size(); ++p)
    for (std::uint32_t l = 0; l < surfaces[p].loops.size(); ++l)
      for (std::uint32_t c = 0; c < surfaces[p].loops[l].size(); ++c)
        edges[surfaces[p].loops[l][c].edge].uses.push_back({p, l, c});
  // The first use runs with its edge, the second against it.
  const auto forward = [&](std::uint32_t p, std::uint32_t l, std::uint32_t c) {
    const BorderUse& first = edges[surfaces[p].loops[l][c].edge].uses.front();
    return first.patch == p && first.loop == l && first.curve == c;
  };
  const EdgeEnds ends(surfaces);
  std::map<int, std::uint32_t> corner_of_end;
  for (auto& [number, edge] : edges) {
    edge.shares = EdgeSampler(surfaces, edge, 0.8 * deviation).shares();
    const BorderUse& first = edge.uses.front();
    const SurfaceTrim& trim = surfaces[first.patch].loops[first.loop][first.curve];
    for (std::size_t i = 0; i < edge.shares.size(); ++i) {
      const bool at_end = i == 0 || i + 1 == edge.shares.size();
      const auto next = static_cast<std::uint32_t>(result.mesh.vertices.size());
      if (at_end) {
        const auto [at, is_new] = corner_of_end.try_emplace(ends.place(number, i > 0), next);
        edge.corners.push_back(at->second);
        if (!is_new) continue;
      } else {
        edge.corners.push_back(next);
      }
      const Vec2 uv = place_at(trim, edge.shares[i]);
      result.mesh.vertices.push_back(surfaces[first.patch].surface.at(uv.x(), uv.y()));
    }
  }
  const auto border_corners = static_cast<std::uint32_t>(result.mesh.vertices.size());
  for (std::uint32_t p = 0; p < surfaces.size(); ++p) {
    std::vector<std::vector<Corner>> loops;
    for (std::uint32_t l = 0; l < surfaces[p].loops.size(); ++l) {
      auto& corners = loops.emplace_back();
      const auto& loop = surfaces[p].loops[l];
      for (std::uint32_t c = 0; c < loop.size(); ++c) {
        const Edge& edge = edges[loop[c].edge];
        const bool with = forward(p, l, c);
        for (std::size_t i = 0; i + 1 < edge.shares.size(); ++i) {
          const std::size_t at = with ? i : edge.shares.size() - 1 - i;
          corners.push_back({place_at(loop[c], with ? edge.shares[at] : 1 - edge.shares[at]), edge.corners[at]});
        }
      }
    }
    Patch(surfaces[p].surface, std::move(loops), deviation).triangulate(p, result);
  }
  split_twins(surfaces, border_corners, result);
  return result;
}

// ---- distances --------------------------------------------------------------------------------------------------

namespace {

/// A place on the border of a surface.
struct BorderPlace {
  const SurfaceTrim* trim;
  double t;
  Vec2 uv;
};

struct BorderFoot {
  const SurfaceTrim* trim;
  double t;
  Vec3 point;
};

/// The nearest place to a point along one piece of a border, from a start near it.
BorderFoot nearest_along(const NurbsSurface& surface, const SurfaceTrim& trim, const Vec3& p, double t) {
  const auto at = [&](double where) {
    const Vec2 uv = trim.curve.at(where);
    return surface.at(uv.x(), uv.y());
  };
  const double low = trim.curve.t.low(), high = trim.curve.t.high();
  Vec3 best = at(t);
  for (int round = 0; round < 30; ++round) {
    Vec2 uv, first, second;
    trim.curve.derivatives(t, uv, first, second);
    const SurfacePoint s = surface.derivatives(uv.x(), uv.y());
    const Vec3 along = first.x() * s.du + first.y() * s.dv, r = s.p - p;
    const Vec3 bend = first.x() * first.x() * s.duu + 2 * first.x() * first.y() * s.duv +
                      first.y() * first.y() * s.dvv + second.x() * s.du + second.y() * s.dv;
    double slope = along.squaredNorm() + r.dot(bend);
    if (!(slope > 1e-3 * along.squaredNorm())) slope = along.squaredNorm();
    bool nearer = false;
    for (double step = 1; step > 1e-3 && !nearer; step /= 4) {
      const double next = std::clamp(t - step * r.dot(along) / std::max(slope, 1e-300), low, high);
      const Vec3 there = at(next);
      if (!((there - p).squaredNorm() < (best - p).squaredNorm())) continue;
      best = there, t = next, nearer = true;
    }
    if (!nearer) break;
  }
  return {&trim, t, best};
}

}  // namespace

struct SurfaceDistance::Parts {
  std::vector<TrimmedSurface> surfaces;
  SurfaceTriangles triangles;
  double deviation;
  bool closed;
  std::vector<std::vector<std::vector<BorderPlace>>> loops;                           // of each surface
  std::map<int, std::vector<std::pair<std::uint32_t, const SurfaceTrim*>>> sides_of;  // of each edge
  MeshDistance distance;

  Parts(std::vector<TrimmedSurface> given, double within, bool bounds_body)
      : surfaces(std::move(given)),
        triangles(triangulated(surfaces, within)),
        deviation(std::max(within, triangles.deviation)),
        closed(bounds_body),
        distance(triangles.mesh) {
    for (const auto& surface : surfaces) {
      auto& outlines = loops.emplace_back();
      for (const auto& loop : surface.loops) {
        auto& outline = outlines.emplace_back();
        for (const auto& trim : loop) {
          sides_of[trim.edge].emplace_back(static_cast<std::uint32_t>(loops.size() - 1), &trim);
          const auto breaks = trim.curve.t.breaks();
          for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
            for (int k = 0, pieces = 4 * trim.curve.t.degree; k < pieces; ++k) {
              const double t = breaks[i] + (breaks[i + 1] - breaks[i]) * k / pieces;
              outline.push_back({&trim, t, trim.curve.at(t)});
            }
        }
      }
    }
  }

  /// The nearest place to p on the border of a surface, which is near (u, v).
  BorderFoot on_border(std::uint32_t patch, const Vec3& p, const Vec2& uv) const {
    // On the two pieces that come nearest: the place may lie on either side of a corner between them.
    const BorderPlace* nearest[2] = {};
    double least[2] = {1e300, 1e300};
    for (const auto& loop : loops[patch])
      for (const BorderPlace& place : loop) {
        const double d = (place.uv - uv).squaredNorm();
        const bool of_first = nearest[0] && nearest[0]->trim == place.trim;
        if (d < least[0]) {
          if (!of_first) least[1] = least[0], nearest[1] = nearest[0];
          least[0] = d, nearest[0] = &place;
        } else if (!of_first && d < least[1]) {
          least[1] = d, nearest[1] = &place;
        }
      }
    const NurbsSurface& surface = surfaces[patch].surface;
    const BorderFoot first = nearest_along(surface, *nearest[0]->trim, p, nearest[0]->t);
    if (!nearest[1]) return first;
    const BorderFoot second = nearest_along(surface, *nearest[1]->trim, p, nearest[1]->t);
    return (first.point - p).squaredNorm() <= (second.point - p).squaredNorm() ? first : second;
  }

  /// The nearest place, from that on the triangles; `beyond`: on other surfaces as well where that of the triangle
  /// ends.
  Hit nearest(const Vec3& p, const MeshHit& near, std::size_t triangle, bool beyond) const {
    const auto& corners = triangles.place[triangle];
    const std::uint32_t patch = triangles.patch[triangle];
    // From the shares of the nearest triangle's corners.
    const Vec3 a = triangles.mesh.corner(triangle, 0), ab = triangles.mesh.corner(triangle, 1) - a,
               ac = triangles.mesh.corner(triangle, 2) - a, d = near.point - a;
    const double bb = ab.squaredNorm(), cc = ac.squaredNorm(), bc = ab.dot(ac),
                 det = std::max(bb * cc - bc * bc, 1e-300);
    const double s = (cc * d.dot(ab) - bc * d.dot(ac)) / det, t = (bb * d.dot(ac) - bc * d.dot(ab)) / det;
    const Vec2 start = corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]);
    Hit hit{near.distance, patch, near.point, triangle_normal(triangles.mesh, triangle)};
    // Within the mesh's deviation: a foot farther away belongs to another part of the surface.
    double most = near.distance + 2 * deviation;
    const auto take = [&](std::uint32_t of, const Vec2& from) {
      const NurbsSurface& surface = surfaces[of].surface;
      const SplineFoot foot = foot_near(surface, p, from.x(), from.y());
      if (!(foot.distance <= most) || !holds(of, {foot.u, foot.v})) return false;
      hit.distance = most = foot.distance, hit.point = foot.point, hit.patch = of;
      if (const Vec3 n = surface.derivatives(foot.u, foot.v).normal(); n.squaredNorm() > 0.5) hit.normal = n;
      return true;
    };
    if (take(patch, start)) return hit;
    const BorderFoot edge = on_border(patch, p, start);
    if (const double off = (edge.point - p).norm(); off < most) {
      hit.distance = most = off, hit.point = edge.point;
      const Vec2 uv = edge.trim->curve.at(edge.t);
      const Vec3 n = surfaces[patch].surface.derivatives(uv.x(), uv.y()).normal();
      if (n.squaredNorm() > 0.5) hit.normal = n;
    }
    if (!beyond) return hit;
    // It may lie on the surface beyond the edge.
    const auto& knots = edge.trim->curve.t;
    for (const auto& [other, trim] : sides_of.at(edge.trim->edge))
      if (trim != edge.trim) take(other, place_at(*trim, 1 - (edge.t - knots.low()) / (knots.high() - knots.low())));
    return hit;
  }

  /// The triangles of one surface.
  struct Alone {
    std::vector<std::uint32_t> triangles;
    MeshDistance distance;
  };
  const Alone& alone(std::uint32_t patch) const {
    std::call_once(parted, [&] {
      std::vector<std::vector<std::uint32_t>> of(surfaces.size());
      for (std::uint32_t t = 0; t < triangles.patch.size(); ++t) of[triangles.patch[t]].push_back(t);
      for (auto& list : of) {
        const MeshPart part = part_of(triangles.mesh, list);
        by_patch.push_back(std::make_unique<Alone>(Alone{std::move(list), MeshDistance(part.mesh)}));
      }
    });
    return *by_patch[patch];
  }
  mutable std::once_flag parted;
  mutable std::vector<std::unique_ptr<Alone>> by_patch;

  bool holds(std::uint32_t patch, const Vec2& uv) const {
    const auto crossed = crossings(loops[patch], uv.y());
    return (std::upper_bound(crossed.begin(), crossed.end(), uv.x()) - crossed.begin()) % 2 == 1;
  }
};

SurfaceDistance::SurfaceDistance(std::vector<TrimmedSurface> surfaces, double deviation, bool closed)
    : parts_(std::make_unique<Parts>(std::move(surfaces), deviation, closed)) {}
SurfaceDistance::~SurfaceDistance() = default;

Box3 SurfaceDistance::bounds() const {
  Box3 box = parts_->triangles.mesh.bounds();
  box.low.array() -= parts_->deviation, box.high.array() += parts_->deviation;
  return box;
}

SurfaceDistance::Hit SurfaceDistance::operator()(const Vec3& p) const {
  const Parts& parts = *parts_;
  const MeshHit near = parts.distance.closest(p);
  Hit hit = parts.nearest(p, near, near.triangle, true);
  const bool behind = parts.closed && near.distance > 2 * parts.deviation ? parts.distance.signed_distance(p) < 0
                                                                          : (p - hit.point).dot(hit.normal) < 0;
  if (behind) hit.distance = -hit.distance;
  return hit;
}

SurfaceDistance::Hit SurfaceDistance::on(std::uint32_t patch, const Vec3& p) const {
  const Parts::Alone& alone = parts_->alone(patch);
  const MeshHit near = alone.distance.closest(p);
  return parts_->nearest(p, near, alone.triangles[near.triangle], false);
}

}  // namespace partscribe::geometry
