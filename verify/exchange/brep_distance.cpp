#include "verify/exchange/brep_distance.h"

#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Standard_Failure.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Circ.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Lin.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>
#include <limits>

#include "core/ensure.h"
#include "core/parallel.h"
#include "geometry/points/spatial_order.h"
#include "verify/exchange/brep_parts.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t chunk_size = std::size_t(1) << 20;  // queries sorted together
constexpr std::size_t block_size = 512;                   // queries of one thread in a row

/// One query after another with the same lists.
class Search {
 public:
  explicit Search(const BrepDistance::Parts& parts) : parts_(parts) {}

  BrepHit closest(const Vec3& query) {
    query_ = query, best_ = std::numeric_limits<double>::infinity();
    faces_.clear(), edges_.clear(), segments_.clear(), triangles_.clear();
    // The triangles where the last query ended bound this one from the start.
    slot_ = start_from(parts_.tree, query, slot_);
    search_nearest(parts_.tree, query, slot_);
    ensure(slot_.triangle != no_triangle, "a query is not finite");
    const double nearest = std::sqrt(slot_.sq_distance);
    try_triangle(slot_.triangle);
    // Whatever can hold a nearer place lies within this reach of the mesh.
    double reach = std::min(best_, nearest + parts_.most_slack) + parts_.most_slack;
    for (;;) {
      reach *= 1 + 1e-12;
      near_.clear();
      triangles_within(parts_.tree, query, reach, near_);
      std::sort(near_.begin(), near_.end(), [](const NearSlot& a, const NearSlot& b) {
        return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.triangle < b.triangle;
      });
      for (const auto& near : near_)
        if (std::sqrt(near.sq_distance) - parts_.triangles[near.triangle].slack <= best_) try_triangle(near.triangle);
      if (best_ + parts_.most_slack <= reach) break;
      reach =
          best_ < std::numeric_limits<double>::infinity() ? best_ + parts_.most_slack : 2 * reach + parts_.most_slack;
    }
    hit_.distance = (query_ - hit_.point).dot(normal_) < 0 ? -best_ : best_;
    return hit_;
  }

 private:
  const BrepDistance::Parts& parts_;
  Vec3 query_ = Vec3::Zero(), normal_ = Vec3::Zero();
  double best_ = 0;
  BrepHit hit_;
  NearestSlot slot_;
  std::vector<NearSlot> near_;
  std::vector<std::uint32_t> faces_, edges_, segments_, triangles_;  // tried already; short

  /// True the first time.
  static bool enter(std::vector<std::uint32_t>& list, std::uint32_t item) {
    if (std::find(list.begin(), list.end(), item) != list.end()) return false;
    list.push_back(item);
    return true;
  }

  void offer(const Vec3& point, const Vec3& normal, std::uint32_t face) {
    const double distance = (query_ - point).norm();
    if (!(distance < best_)) return;
    best_ = distance, normal_ = normal, hit_.point = point, hit_.face = face;
  }

  void try_triangle(std::uint32_t t) {
    const BrepTriangle& triangle = parts_.triangles[t];
    const BrepFace& face = parts_.faces[triangle.face];
    if (face.closed_form() ? enter(faces_, triangle.face) : enter(triangles_, t)) {
      Vec2 start = triangle.uv[0];
      if (!face.closed_form()) {
        const Vec3 w =
            nearest_in_triangle(parts_.mesh.corner(t, 0), parts_.mesh.corner(t, 1), parts_.mesh.corner(t, 2), query_)
                .weights;
        start = w[0] * triangle.uv[0] + w[1] * triangle.uv[1] + w[2] * triangle.uv[2];
      }
      if (const auto foot = foot_on_face(face, query_, start)) offer(foot->point, foot->normal, triangle.face);
    }
    for (const std::uint32_t s : triangle.segment)
      if (s != no_segment) try_segment(s);
  }

  void try_segment(std::uint32_t s) {
    const BrepSegment& segment = parts_.segments[s];
    const Vec3 ab = segment.b - segment.a;
    const double l = ab.squaredNorm();
    const double share = l > 0 ? std::clamp(ab.dot(query_ - segment.a) / l, 0.0, 1.0) : 0;
    if ((query_ - segment.a - share * ab).norm() - segment.slack > best_) return;
    const BrepEdge& edge = parts_.edges[segment.edge];
    if (!(edge.closed_form() ? enter(edges_, segment.edge) : enter(segments_, s))) return;
    const CurveFoot foot = foot_on_edge(edge, query_, segment.t0 + share * (segment.t1 - segment.t0));
    offer(foot.point,
          foot.end < 0   ? edge.start_normal
          : foot.end > 0 ? edge.end_normal
                         : normal_at(edge, foot.t),
          edge.face);
  }

  /// Between the chords' ends, where it is known.
  Vec3 normal_at(const BrepEdge& edge, double t) const {
    const auto begin = parts_.segments.begin() + edge.first_segment, end = begin + edge.segments;
    auto at = std::upper_bound(begin, end, t, [](double x, const BrepSegment& segment) { return x < segment.t1; });
    if (at == end) --at;
    const double share = std::clamp((t - at->t0) / (at->t1 - at->t0), 0.0, 1.0);
    return (1 - share) * at->normal_a + share * at->normal_b;
  }
};

}  // namespace

BrepDistance::BrepDistance(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
BrepDistance::~BrepDistance() = default;

std::shared_ptr<const BrepDistance> BrepDistance::make(const TopoDS_Shape& shape) {
  try {
    auto parts = collect_brep_parts(shape);
    if (!parts) return nullptr;
    std::shared_ptr<const BrepDistance> exact(new BrepDistance(std::move(parts)));
    if (!exact->knows_its_faces()) return nullptr;
    return exact;
  } catch (const Standard_Failure&) {
    return nullptr;  // as much as a face without a mesh: what OpenCASCADE cannot handle is left to the mesh
  }
}

bool BrepDistance::knows_its_faces() const {
  Search search(*parts_);
  for (std::size_t t = 0; t < parts_->triangles.size(); ++t) {
    const BrepTriangle& triangle = parts_->triangles[t];
    const Vec2 middle = (triangle.uv[0] + triangle.uv[1] + triangle.uv[2]) / 3;
    const Vec3 place = surface_point(parts_->faces[triangle.face], middle.x(), middle.y()).p;
    if (!place.allFinite() || !(std::abs(search.closest(place).distance) <= triangle.slack)) return false;
  }
  return true;
}

std::size_t BrepDistance::faces() const { return parts_->faces.size(); }

BrepHit BrepDistance::closest(const Vec3& query) const { return Search(*parts_).closest(query); }

std::vector<BrepHit> BrepDistance::closest(std::span<const Vec3> queries, int threads) const {
  std::vector<BrepHit> hits(queries.size());
  for_each_closest(queries, threads, [&](std::size_t index, const BrepHit& hit) { hits[index] = hit; });
  return hits;
}

void BrepDistance::for_each_closest(std::span<const Vec3> queries, int threads,
                                    const std::function<void(std::size_t, const BrepHit&)>& take) const {
  for (std::size_t start = 0; start < queries.size(); start += chunk_size) {
    const auto chunk = queries.subspan(start, std::min(chunk_size, queries.size() - start));
    const std::vector<std::uint32_t> order = spatial_order(chunk, threads);
    parallel_for(
        order.size(), threads,
        [&](std::size_t begin, std::size_t end) {
          Search search(*parts_);
          for (std::size_t i = begin; i < end; ++i) take(start + order[i], search.closest(chunk[order[i]]));
        },
        block_size);
  }
}

}  // namespace partscribe::verify
