#include "fit/surface/height_field.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>

#include "core/ensure.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "fit/surface/picture.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::fit {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;
constexpr std::uint32_t none = ~0u;

// ---- averaging ------------------------------------------------------------------------------------------------

Samples usable(const PointCloud& cloud) {
  Samples samples;
  const bool rays = cloud.rays.size() == cloud.size();
  for (const std::uint32_t i : thinned(cloud.points, cloud.rejected, 0)) {
    if (!(cloud.normals[i].squaredNorm() > 0.25)) continue;
    samples.points.push_back(cloud.points[i]);
    samples.normals.push_back(cloud.normals[i].normalized());
    if (rays) samples.rays.push_back(cloud.rays[i]);
  }
  return samples;
}

/// Every point is moved along its normal to the robust mean of `count` neighbours with similar normals; points without
/// such neighbours are marked by an undefined place.
std::vector<Vec3> averaged(const Samples& s, const Projection& projection, std::size_t count, double spacing,
                           Context& context) {
  std::vector<Vec3> result(s.points.size());
  const KdTree tree(s.points);
  const double reach = 1.5 * spacing * std::sqrt(static_cast<double>(count)) + 2 * spacing;
  parallel_for(result.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    std::vector<double> off;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(s.points[i], 2 * count, near);
      off.clear();
      for (const Neighbour& n : near) {
        if (n.sq_distance > reach * reach || off.size() == count) break;
        if (std::abs(s.normals[n.index].dot(s.normals[i])) > 0.7)
          off.push_back(s.normals[i].dot(s.points[n.index] - s.points[i]));
      }
      if (off.size() < 5) {
        result[i] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      const double shift = robust_mean(off).mean;
      // On walls seen nearly edge-on the normal is uncertain, and points would change places in the picture.
      const double most = spacing * std::abs(s.normals[i].dot(projection.ray_to(s.points[i])));
      result[i] = std::abs(shift) > most ? s.points[i] : Vec3(s.points[i] + s.normals[i] * shift);
    }
  });
  return result;
}

// ---- where there is surface -----------------------------------------------------------------------------------

struct DenseFace {
  bool valid = false;
  std::uint32_t piece = none;
};
using DenseVertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using DenseFaceBase = CGAL::Triangulation_face_base_with_info_2<DenseFace, Kernel>;
using Dense =
    CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<DenseVertexBase, DenseFaceBase>>;

/// All samples triangulated in the picture; faces over steps and missing data are not valid.
class PictureDomain {
 public:
  PictureDomain(const std::vector<Vec3>& picture, const std::vector<Vec3>& places, const std::vector<Vec3>& normals,
                const Projection& projection, const HeightFieldOptions& options, double spacing)
      : places_(places) {
    std::vector<std::pair<Point, std::uint32_t>> all;
    for (std::uint32_t i = 0; i < picture.size(); ++i)
      if (places[i].allFinite()) all.emplace_back(Point(picture[i].x(), picture[i].y()), i);
    dense_.insert(all.begin(), all.end());
    if (dense_.dimension() < 2) return;
    std::vector<double> edges;
    for (auto e = dense_.finite_edges_begin(); e != dense_.finite_edges_end(); ++e)
      edges.push_back(std::sqrt(dense_.segment(e).squared_length()));
    const double longest = options.longest_edge * median_in_place(edges);
    const double flattest = std::cos(options.steepest), jump = std::max(2 * options.max_error, spacing);
    for (auto f = dense_.finite_faces_begin(); f != dense_.finite_faces_end(); ++f) {
      double length = 0, near = 1e300, far = -1e300;
      Vec3 p[3];
      for (int k = 0; k < 3; ++k) {
        length = std::max(length, (f->vertex(k)->point() - f->vertex((k + 1) % 3)->point()).squared_length());
        p[k] = places[f->vertex(k)->info()];
        const double depth = picture[f->vertex(k)->info()].z();
        near = std::min(near, depth), far = std::max(far, depth);
      }
      const Vec3 ray = projection.ray_to(p[0]);
      const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
      // A steep wall that was seen has steep normals; the edges of a jump look elsewhere.
      bool wall = normal.dot(ray) > 0.05;
      for (int k = 0; k < 3; ++k) wall = wall && std::abs(normals[f->vertex(k)->info()].dot(normal)) > 0.9;
      f->info().valid = length <= longest * longest && (far - near <= jump || normal.dot(ray) >= flattest || wall);
    }
    for (int round = 0; round < 30 && part_touching_pieces(); ++round) {
    }
    drop_specks();
  }

  const Dense& dense() const { return dense_; }

  bool holds(const Point& p, Dense::Face_handle& hint) const {
    hint = dense_.locate(p, hint);
    return hint != nullptr && !dense_.is_infinite(hint) && hint->info().valid;
  }

  /// Is the sample a corner of a valid face?
  std::vector<std::uint8_t> covered() const {
    std::vector<std::uint8_t> result(places_.size(), 0);
    for (auto f = dense_.finite_faces_begin(); f != dense_.finite_faces_end(); ++f)
      if (f->info().valid)
        for (int k = 0; k < 3; ++k) result[f->vertex(k)->info()] = 1;
    return result;
  }

  /// Closed chains of samples around the valid faces, in the order of their lowest sample.
  std::vector<std::vector<std::uint32_t>> borders() const {
    std::vector<std::uint32_t> next(places_.size(), none);
    for (auto f = dense_.finite_faces_begin(); f != dense_.finite_faces_end(); ++f)
      if (f->info().valid)
        for (int k = 0; k < 3; ++k)
          if (!valid(f->neighbor(k))) next[f->vertex(f->ccw(k))->info()] = f->vertex(f->cw(k))->info();
    std::vector<std::vector<std::uint32_t>> loops;
    for (std::uint32_t i = 0; i < next.size(); ++i) {
      if (next[i] == none) continue;
      auto& loop = loops.emplace_back();
      for (std::uint32_t v = i; v != none;) {
        loop.push_back(v);
        const std::uint32_t after = next[v];
        next[v] = none;
        v = after;
      }
      loop.pop_back();  // came round
    }
    return loops;
  }

 private:
  bool valid(Dense::Face_handle f) const { return !dense_.is_infinite(f) && f->info().valid; }

  /// Where pieces share no more than a corner, the smaller ones withdraw from it.
  bool part_touching_pieces() {
    bool changed = false;
    for (auto v = dense_.finite_vertices_begin(); v != dense_.finite_vertices_end(); ++v) {
      std::vector<Dense::Face_handle> around;
      auto f = dense_.incident_faces(v);
      const auto start = f;
      do around.push_back(f);
      while (++f != start);
      const std::size_t n = around.size();
      std::size_t first = 0;
      while (first < n && valid(around[first])) ++first;
      if (first == n) continue;
      std::size_t longest = 0, longest_at = 0, runs = 0;
      for (std::size_t k = 1; k <= n; ++k) {
        std::size_t length = 0;
        while (k + length <= n && valid(around[(first + k + length) % n])) ++length;
        if (length == 0) continue;
        ++runs;
        if (length > longest) longest = length, longest_at = k;
        k += length;
      }
      if (runs < 2) continue;
      changed = true;
      for (std::size_t k = 1; k <= n; ++k)
        if (k < longest_at || k >= longest_at + longest) around[(first + k) % n]->info().valid = false;
    }
    return changed;
  }

  void drop_specks() {
    std::vector<Dense::Face_handle> piece;
    std::uint32_t number = 0;
    for (auto f = dense_.finite_faces_begin(); f != dense_.finite_faces_end(); ++f) {
      if (!f->info().valid || f->info().piece != none) continue;
      piece.assign(1, f);
      f->info().piece = number;
      for (std::size_t i = 0; i < piece.size(); ++i)
        for (int k = 0; k < 3; ++k) {
          const auto other = piece[i]->neighbor(k);
          if (valid(other) && other->info().piece == none) other->info().piece = number, piece.push_back(other);
        }
      ++number;
      if (piece.size() < 4)
        for (auto& face : piece) face->info().valid = false;
    }
  }

  const std::vector<Vec3>& places_;
  Dense dense_;
};

/// Corners that a chain needs to stay within `bound` [Douglas & Peucker 1973]; the chain is closed.
std::vector<std::uint32_t> simplified_loop(const std::vector<std::uint32_t>& loop, const std::vector<Vec3>& places,
                                           double bound) {
  const std::size_t n = loop.size();
  if (n <= 3) return loop;
  auto at = [&](std::size_t i) -> const Vec3& { return places[loop[i % n]]; };
  auto off_chord = [&](std::size_t a, std::size_t b, std::size_t i) {
    const Vec3 along = at(b) - at(a), d = at(i) - at(a);
    const double sq = along.squaredNorm();
    const double t = sq > 0 ? std::clamp(along.dot(d) / sq, 0.0, 1.0) : 0;
    return (d - t * along).squaredNorm();
  };
  std::vector<std::uint8_t> keep(n, 0);
  auto farthest = [&](std::size_t a, std::size_t b, double& most) {
    std::size_t found = a;
    most = 0;
    for (std::size_t i = a + 1; i < b; ++i)
      if (const double d = off_chord(a, b, i); d > most) most = d, found = i;
    return found;
  };
  double most = 0;
  const std::size_t far = std::max<std::size_t>(farthest(0, n, most), 1);
  keep[0] = keep[far] = 1;
  double most_a = 0, most_b = 0;
  const std::size_t a = farthest(0, far, most_a), b = farthest(far, n, most_b);
  keep[most_a >= most_b ? a : b] = 1;
  std::vector<std::size_t> stops;
  for (std::size_t i = 0; i < n; ++i)
    if (keep[i]) stops.push_back(i);
  stops.push_back(n);
  std::vector<std::pair<std::size_t, std::size_t>> work;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) work.emplace_back(stops[i], stops[i + 1]);
  while (!work.empty()) {
    const auto [from, to] = work.back();
    work.pop_back();
    const std::size_t cut = farthest(from, to, most);
    if (most <= bound * bound) continue;
    keep[cut] = 1;
    work.emplace_back(from, cut), work.emplace_back(cut, to);
  }
  std::vector<std::uint32_t> result;
  for (std::size_t i = 0; i < n; ++i)
    if (keep[i]) result.push_back(loop[i]);
  return result;
}

// ---- insertion ------------------------------------------------------------------------------------------------

struct SparseFace {
  bool inside = false;
  std::uint32_t region = none, worst = none;
  std::vector<std::uint32_t> samples;
};
using SparseVertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using SparseFaceBase =
    CGAL::Triangulation_face_base_with_info_2<SparseFace, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Sparse = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<SparseVertexBase, SparseFaceBase>, CGAL::Exact_predicates_tag>;
using Face = Sparse::Face_handle;
using Vertex = Sparse::Vertex_handle;

class Insertion {
 public:
  Insertion(const PictureDomain& domain, const std::vector<Vec3>& picture, std::vector<Vec3> places, double bound)
      : domain_(domain), picture_(picture), places_(std::move(places)), bound_(bound) {}

  TriangleMesh run(Context& context) {
    place_borders();
    label_regions();
    share_out_samples();
    context.report("triangulation", 0.85);
    insert_worst();
    context.report("triangulation", 0.9);
    for (int round = 0; round < 2 && remove_idle(); ++round) {
    }
    return result();
  }

 private:
  Point at(std::uint32_t sample) const { return Point(picture_[sample].x(), picture_[sample].y()); }

  void place_borders() {
    used_.assign(picture_.size(), 0);
    for (const auto& border : domain_.borders()) {
      const auto loop = simplified_loop(border, places_, bound_);
      std::vector<Vertex> corners;
      for (const std::uint32_t s : loop) {
        const std::size_t before = sparse_.number_of_vertices();
        const bool flat = sparse_.dimension() < 2 || corners.empty();
        corners.push_back(sparse_.insert(at(s), flat ? Face() : corners.back()->face()));
        if (sparse_.number_of_vertices() > before) corners.back()->info() = s;
        used_[s] = 1;
      }
      for (std::size_t i = 0; i < corners.size(); ++i)
        if (const auto& next = corners[(i + 1) % corners.size()]; next != corners[i])
          sparse_.insert_constraint(corners[i], next);
    }
    // Corners where simplified borders cross belong to no sample.
    const std::size_t samples = picture_.size();
    const KdTree tree(flat_picture());
    for (auto v = sparse_.finite_vertices_begin(); v != sparse_.finite_vertices_end(); ++v) {
      const std::uint32_t s = v->info();
      if (s < samples && at(s) == v->point()) continue;
      const Vec3 here(v->point().x(), v->point().y(), 0);
      v->info() = static_cast<std::uint32_t>(places_.size());
      places_.push_back(places_[flat_index_[tree.nearest_one(here).index]]);
    }
  }

  const std::vector<Vec3>& flat_picture() {
    for (std::uint32_t i = 0; i < picture_.size(); ++i)
      if (places_[i].allFinite()) flat_.emplace_back(picture_[i].x(), picture_[i].y(), 0), flat_index_.push_back(i);
    return flat_;
  }

  /// Regions between borders are surface if most of their area is.
  void label_regions() {
    std::vector<double> votes;
    std::vector<Face> region;
    Dense::Face_handle hint;
    for (auto f = sparse_.finite_faces_begin(); f != sparse_.finite_faces_end(); ++f) f->info().region = none;
    for (auto f = sparse_.finite_faces_begin(); f != sparse_.finite_faces_end(); ++f) {
      if (f->info().region != none) continue;
      const auto number = static_cast<std::uint32_t>(votes.size());
      votes.push_back(0);
      region.assign(1, f);
      f->info().region = number;
      bool open = false;
      for (std::size_t i = 0; i < region.size(); ++i) {
        const Face g = region[i];
        const auto triangle = sparse_.triangle(g);
        votes.back() += domain_.holds(CGAL::centroid(triangle), hint) ? triangle.area() : -triangle.area();
        for (int k = 0; k < 3; ++k) {
          if (sparse_.is_constrained({g, k})) continue;
          const Face other = g->neighbor(k);
          if (sparse_.is_infinite(other))
            open = true;
          else if (other->info().region == none)
            other->info().region = number, region.push_back(other);
        }
      }
      if (open) votes.back() = -1;
    }
    for (auto f = sparse_.finite_faces_begin(); f != sparse_.finite_faces_end(); ++f)
      f->info().inside = votes[f->info().region] > 0;
  }

  /// Signed distance from the face's plane, along its normal.
  double error(Face f, std::uint32_t sample) const {
    const Vec3 &a = places_[f->vertex(0)->info()], &b = places_[f->vertex(1)->info()],
               &c = places_[f->vertex(2)->info()];
    const Vec3 n = (b - a).cross(c - a);
    const double size = n.norm();
    return size > 0 ? std::abs(n.dot(places_[sample] - a)) / size : (places_[sample] - a).norm();
  }

  void share_out_samples() {
    const auto covered = domain_.covered();
    face_of_.assign(picture_.size(), Face());
    Face hint;
    const Dense& dense = domain_.dense();
    for (auto v = dense.finite_vertices_begin(); v != dense.finite_vertices_end(); ++v) {
      const std::uint32_t s = v->info();
      if (!covered[s] || used_[s]) continue;
      hint = sparse_.locate(v->point(), hint);
      if (hint != nullptr && !sparse_.is_infinite(hint) && hint->info().inside) hint->info().samples.push_back(s);
    }
    for (auto f = sparse_.finite_faces_begin(); f != sparse_.finite_faces_end(); ++f) find_worst(f);
  }

  void find_worst(Face f) {
    auto& info = f->info();
    info.worst = none;
    double most = 0;
    for (const std::uint32_t s : info.samples) {
      face_of_[s] = f;
      const double e = error(f, s);
      if (e > most || (e == most && s < info.worst)) most = e, info.worst = s;
    }
    if (info.worst != none && most > bound_) queue_.push({most, info.worst});
  }

  bool holds(Face f, const Point& p) const {
    for (int k = 0; k < 3; ++k)
      if (CGAL::orientation(f->vertex(k)->point(), f->vertex((k + 1) % 3)->point(), p) == CGAL::RIGHT_TURN)
        return false;
    return true;
  }

  /// The faces around a new vertex take over the samples of those it replaced.
  void settle(Vertex v, std::vector<std::uint32_t>& samples) {
    std::vector<Face> star;
    auto f = sparse_.incident_faces(v);
    const auto start = f;
    do {
      if (sparse_.is_infinite(f)) continue;
      samples.insert(samples.end(), f->info().samples.begin(), f->info().samples.end());
      f->info().samples.clear();
      f->info().inside = true;
      star.push_back(f);
    } while (++f != start);
    std::sort(samples.begin(), samples.end());
    for (const std::uint32_t s : samples)
      for (const Face g : star)
        if (holds(g, at(s))) {
          g->info().samples.push_back(s);
          break;
        }
    for (const Face g : star) find_worst(g);
  }

  void insert_worst() {
    std::vector<Face> conflicts;
    std::vector<std::uint32_t> samples;
    while (!queue_.empty()) {
      const auto [size, s] = queue_.top();
      queue_.pop();
      const Face f = face_of_[s];
      if (used_[s] || f->info().worst != s || error(f, s) != size) continue;
      used_[s] = 1;
      Sparse::Locate_type type;
      int index = 0;
      const Face place = sparse_.locate(at(s), type, index, f);
      const bool on_border = type == Sparse::EDGE && sparse_.is_constrained({place, index});
      if (on_border || (type != Sparse::EDGE && type != Sparse::FACE)) {
        std::erase(f->info().samples, s);
        find_worst(f);
        continue;
      }
      conflicts.clear(), samples.clear();
      sparse_.get_conflicts(at(s), std::back_inserter(conflicts), place);
      for (const Face g : conflicts) {
        for (const std::uint32_t other : g->info().samples)
          if (other != s) samples.push_back(other);
        g->info().samples.clear();
      }
      const Vertex v = sparse_.insert(at(s), type, place, index);
      v->info() = s;
      inserted_.push_back(v);
      settle(v, samples);
    }
  }

  /// Takes away vertices that later ones made needless; false if there are none.
  bool remove_idle() {
    std::vector<Vertex> left;
    std::vector<std::uint32_t> samples;
    std::vector<std::pair<std::uint32_t, Face>> moved;
    bool any = false;
    for (const Vertex v : inserted_) {
      const std::uint32_t own = v->info();
      samples.clear();
      auto f = sparse_.incident_faces(v);
      const auto start = f;
      Vertex beside;
      do {
        samples.insert(samples.end(), f->info().samples.begin(), f->info().samples.end());
        beside = f->vertex(f->ccw(f->index(v)));
      } while (++f != start);
      samples.push_back(own);
      sparse_.remove(v);
      bool good = true;
      moved.clear();
      Face hint = beside->face();
      // The vertex's own sample is the most likely to violate the bound.
      for (std::size_t i = samples.size(); i-- > 0 && good;) {
        hint = sparse_.locate(at(samples[i]), hint);
        good = !sparse_.is_infinite(hint) && error(hint, samples[i]) <= bound_;
        moved.emplace_back(samples[i], hint);
      }
      if (good) {
        any = true;
        used_[own] = 0;
        for (const auto& [s, face] : moved) face->info().samples.push_back(s);
        continue;
      }
      const Vertex again = sparse_.insert(at(own), hint);
      again->info() = own;
      samples.pop_back();
      settle(again, samples);
      left.push_back(again);
    }
    inserted_ = std::move(left);
    return any;
  }

  TriangleMesh result() {
    label_regions();
    TriangleMesh mesh;
    std::vector<std::uint32_t> number(places_.size(), none);
    for (auto f = sparse_.finite_faces_begin(); f != sparse_.finite_faces_end(); ++f) {
      if (!f->info().inside) continue;
      std::array<std::uint32_t, 3> t;
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t s = f->vertex(k)->info();
        if (number[s] == none)
          number[s] = static_cast<std::uint32_t>(mesh.vertices.size()), mesh.vertices.push_back(places_[s]);
        // Depth grows away from the sensor, so that what runs left in the picture runs right seen by it.
        t[static_cast<std::size_t>(2 - k)] = number[s];
      }
      mesh.triangles.push_back(t);
    }
    return mesh;
  }

  struct Entry {
    double error;
    std::uint32_t sample;
    bool operator<(const Entry& other) const {
      return error != other.error ? error < other.error : sample > other.sample;
    }
  };

  const PictureDomain& domain_;
  const std::vector<Vec3>& picture_;
  std::vector<Vec3> places_;
  double bound_;
  Sparse sparse_;
  std::vector<Vec3> flat_;
  std::vector<std::uint32_t> flat_index_;
  std::vector<std::uint8_t> used_;
  std::vector<Face> face_of_;
  std::vector<Vertex> inserted_;
  std::priority_queue<Entry> queue_;
};

/// Fans of triangles that share only a vertex are separated: all but the largest get a vertex of their own.
void part_fans(TriangleMesh& mesh) {
  for (int round = 0; round < 10; ++round) {
    std::vector<std::vector<std::uint32_t>> fans(mesh.vertices.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) fans[v].push_back(t);
    std::vector<std::uint8_t> drop(mesh.triangles.size(), 0);
    bool any = false;
    for (std::uint32_t v = 0; v < fans.size(); ++v) {
      std::vector<std::uint32_t> rest = fans[v], best;
      std::size_t groups = 0;
      while (!rest.empty()) {
        std::vector<std::uint32_t> group = {rest.back()};
        rest.pop_back();
        for (std::size_t i = 0; i < group.size(); ++i)
          for (std::size_t k = 0; k < rest.size();) {
            int shared = 0;
            for (const std::uint32_t a : mesh.triangles[group[i]])
              for (const std::uint32_t b : mesh.triangles[rest[k]]) shared += a == b;
            if (shared >= 2)
              group.push_back(rest[k]), rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
            else
              ++k;
          }
        ++groups;
        if (group.size() > best.size()) best = group;
      }
      if (groups < 2) continue;
      any = true;
      for (const std::uint32_t t : fans[v])
        if (std::find(best.begin(), best.end(), t) == best.end()) drop[t] = 1;
    }
    if (!any) return;
    std::size_t kept = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (!drop[t]) mesh.triangles[kept++] = mesh.triangles[t];
    mesh.triangles.resize(kept);
  }
}

}  // namespace

std::optional<HeightField> triangulated_height_field(const PointCloud& cloud, const std::vector<View>& views,
                                                     const SamplingSummary& sampling, const HeightFieldOptions& options,
                                                     Context& context) {
  ensure(cloud.normals.size() == cloud.size(), "a height field needs normals");
  const Samples samples = usable(cloud);
  if (samples.points.size() < 30 || !(sampling.spacing > 0)) return std::nullopt;
  const auto projection = find_projection(samples, views, sampling.spacing, options.max_hidden, options.oriented);
  if (!projection) return std::nullopt;

  const double wanted = 3.3 * sampling.sigma / (options.noise_share * options.max_error);
  const auto count = static_cast<std::size_t>(std::clamp(std::ceil(wanted * wanted), 9.0, 60.0));
  const std::vector<Vec3> places = averaged(samples, *projection, count, sampling.spacing, context);
  std::vector<Vec3> picture(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) picture[i] = (*projection)(places[i]);
  const PictureDomain domain(picture, places, samples.normals, *projection, options, sampling.spacing);
  HeightField result;
  const auto covered = domain.covered();
  result.uncovered =
      1 - static_cast<double>(std::count(covered.begin(), covered.end(), 1)) / static_cast<double>(covered.size());
  if (result.uncovered > options.max_uncovered) return std::nullopt;
  result.mesh = Insertion(domain, picture, places, options.max_error).run(context);
  part_fans(result.mesh);
  result.mesh = welded(result.mesh, 0);
  if (result.mesh.empty()) return std::nullopt;
  result.towards_sensor = -projection->rotation.row(2).transpose();
  return result;
}

}  // namespace partscribe::fit
