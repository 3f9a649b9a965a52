#include "geometry/mesh/decimate.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "core/ensure.h"
#include "geometry/mesh/bounded_mesh.h"

namespace partscribe::geometry {
namespace {

struct Collapse {
  std::uint32_t a, b, stamp_a, stamp_b;
};

/// Delivers the cheapest first, to an eighth of a power of two, and equal ones in the order in which they came: a heap
/// spends its time waiting for memory.
class CollapseQueue {
 public:
  void clear() { levels_.assign(levels_.size(), {}), lowest_ = levels_.size(); }
  void push(double cost, const Collapse& collapse) {
    // Bits of positive numbers are in the order of the numbers.
    const std::size_t level = std::bit_cast<std::uint64_t>(cost) >> 49;
    levels_[level].waiting.push_back(collapse);
    lowest_ = std::min(lowest_, level);
  }
  std::optional<Collapse> pop() {
    for (; lowest_ < levels_.size(); ++lowest_) {
      Level& level = levels_[lowest_];
      if (level.next < level.waiting.size()) return level.waiting[level.next++];
      level = {};
    }
    return std::nullopt;
  }

 private:
  struct Level {
    std::vector<Collapse> waiting;
    std::size_t next = 0;
  };
  std::vector<Level> levels_ = std::vector<Level>(std::size_t{1} << 15);
  std::size_t lowest_ = 0;
};

class Decimator {
 public:
  Decimator(const TriangleMesh& source, const DecimateOptions& options, Context& context)
      : options_(options),
        context_(context),
        mesh_(source, options.max_error, context),
        start_(source.triangles.size()) {
    stamps_.assign(mesh_.vertices(), 0);
  }

  TriangleMesh run() {
    for (int round = 0; round < options_.rounds && !done(); ++round) {
      const std::size_t before = mesh_.triangles_left();
      if (round > 0) relax();
      collapse_all();
      if (context_.cancelled || before - mesh_.triangles_left() < before / 50 + 1) break;
    }
    return mesh_.result();
  }

 private:
  bool done() const {
    return context_.cancelled || (options_.target_triangles > 0 && mesh_.triangles_left() <= options_.target_triangles);
  }
  bool frozen(std::uint32_t v) const { return !options_.frozen.empty() && options_.frozen[v]; }

  /// Collapses edges, those first that cost least by the planes of the original, until no more can go.
  void collapse_all() {
    quadrics_ = mesh_.quadrics();
    queue_.clear();
    for (std::uint32_t v = 0; v < mesh_.vertices(); ++v) {
      if (mesh_.fan(v).empty()) continue;
      mesh_.neighbours(v, around_a_);
      for (const std::uint32_t w : around_a_)
        if (v < w) push(v, w);
    }
    for (std::size_t step = 0; !done(); ++step) {
      const auto next = queue_.pop();
      if (!next) break;
      if (stamps_[next->a] != next->stamp_a || stamps_[next->b] != next->stamp_b) continue;
      try_collapse(next->a, next->b);
      if (step % 4096 == 0)
        context_.report("decimate", 1 - static_cast<double>(mesh_.triangles_left()) /
                                            static_cast<double>(std::max<std::size_t>(1, start_)));
    }
  }

  /// The best place for the union of two vertices and what it costs.
  double best_place(std::uint32_t a, std::uint32_t b, Vec3& place) const {
    Quadric q = quadrics_[a];
    q.add(quadrics_[b], 1);
    const Vec3 pa = mesh_.point(a) - mesh_.origin(), pb = mesh_.point(b) - mesh_.origin(), middle = 0.5 * (pa + pb);
    // Where planes leave a direction free, the middle of the edge is as good as any.
    const double weight = 1e-5 * q.a.trace() + 1e-300;
    const Mat3 system = q.a + weight * Mat3::Identity();
    place = system.inverse() * (weight * middle - q.b);
    const double sq_length = (pa - pb).squaredNorm();
    if (!place.allFinite() || (place - middle).squaredNorm() > 4 * sq_length) place = q.at(pa) <= q.at(pb) ? pa : pb;
    // Among equally flat edges short ones go first: they leave better triangles.
    const double cost = q.at(place) + 1e-7 * sq_length * sq_length;
    place += mesh_.origin();
    return cost;
  }

  void push(std::uint32_t a, std::uint32_t b) {
    if (frozen(a) || frozen(b)) return;
    if (a > b) std::swap(a, b);
    Vec3 place;
    const double cost = best_place(a, b, place), weight = quadrics_[a].a.trace() + quadrics_[b].a.trace();
    // Planes so far away on average leave no hope.
    if (cost > 5 * options_.max_error * options_.max_error * weight) return;
    queue_.push(cost, {a, b, stamps_[a], stamps_[b]});
  }

  bool topology_allows(std::uint32_t a, std::uint32_t b) {
    const std::size_t shared = mesh_.edge_triangles(a, b);
    if (shared == 0 || shared > 2) return false;
    if (shared == 2 && mesh_.on_border(a) && mesh_.on_border(b)) return false;
    mesh_.neighbours(a, around_a_);
    mesh_.neighbours(b, around_b_);
    common_.clear();
    std::set_intersection(around_a_.begin(), around_a_.end(), around_b_.begin(), around_b_.end(),
                          std::back_inserter(common_));
    if (common_.size() != shared) return false;
    for (const std::uint32_t v : common_)
      if (mesh_.fan(v).size() <= (mesh_.on_border(v) ? 1u : 3u)) return false;
    // Two triangles on the same three vertices would be left.
    return mesh_.fan(a).size() + mesh_.fan(b).size() - 2 * shared > 2 || mesh_.on_border(a) || mesh_.on_border(b);
  }

  /// Prepares the edit that unites b with a at a place.
  bool prepare_collapse(std::uint32_t a, std::uint32_t b, const Vec3& place) {
    edit_.clear();
    edit_.moved = a, edit_.place = place;
    for (const std::uint32_t v : {a, b})
      for (const std::uint32_t t : mesh_.fan(v)) {
        auto vertices = mesh_.triangle(t);
        const bool has_a = std::find(vertices.begin(), vertices.end(), a) != vertices.end();
        const bool has_b = std::find(vertices.begin(), vertices.end(), b) != vertices.end();
        if (has_a && has_b && v == b) continue;
        edit_.removed.push_back(t);
        if (has_a && has_b) continue;
        std::replace(vertices.begin(), vertices.end(), b, a);
        if (!mesh_.add(edit_, t, vertices)) return false;
      }
    return true;
  }

  /// Tries the place that the planes say, then better ones by the samples, then one of the ends.
  bool can_collapse(std::uint32_t a, std::uint32_t b) {
    Vec3 place;
    best_place(a, b, place);
    for (int step = 0; prepare_collapse(a, b, place); ++step) {
      if (mesh_.allows(edit_)) return true;
      if (step == options_.steps) break;
      place = mesh_.better_place(edit_);
    }
    const Quadric &qa = quadrics_[a], &qb = quadrics_[b];
    const double cost_a = qb.at(mesh_.point(a) - mesh_.origin()), cost_b = qa.at(mesh_.point(b) - mesh_.origin());
    const bool at_a = mesh_.on_border(a) != mesh_.on_border(b) ? mesh_.on_border(a) : cost_a <= cost_b;
    return prepare_collapse(a, b, mesh_.point(at_a ? a : b)) && mesh_.allows(edit_);
  }

  void try_collapse(std::uint32_t a, std::uint32_t b) {
    if (!topology_allows(a, b) || !can_collapse(a, b)) return;
    mesh_.make(edit_);
    quadrics_[a].add(quadrics_[b], 1);
    ++stamps_[a], ++stamps_[b];
    mesh_.neighbours(a, around_a_);
    for (const std::uint32_t v : around_a_) push(a, v);
  }

  /// Moves vertices and turns edges so that samples come nearer, which makes room for further collapses.
  void relax() {
    for (int turn = 0; turn < options_.turns; ++turn) {
      for (std::uint32_t v = 0; v < mesh_.vertices(); ++v)
        if (!mesh_.fan(v).empty() && !frozen(v)) relocate(v);
      for (std::uint32_t v = 0; v < mesh_.vertices(); ++v) {
        if (mesh_.fan(v).empty() || frozen(v)) continue;
        mesh_.neighbours(v, around_a_);
        for (const std::uint32_t w : around_a_)
          if (v < w && !frozen(w)) flip(v, w);
      }
      if (context_.cancelled) return;
    }
  }

  void relocate(std::uint32_t v) {
    const double before = mesh_.unrest(mesh_.fan(v));
    if (!(before > 0)) return;
    edit_.clear();
    edit_.moved = v, edit_.place = mesh_.point(v);
    edit_.removed = mesh_.fan(v);
    for (const std::uint32_t t : edit_.removed)
      if (!mesh_.add(edit_, t, mesh_.triangle(t))) return;
    Vec3 step = mesh_.better_place(edit_) - edit_.place;
    for (int half = 0; half < 2; ++half, step *= 0.4) {
      edit_.added.clear();
      edit_.place = mesh_.point(v) + step;
      bool fits = true;
      for (const std::uint32_t t : edit_.removed) fits = fits && mesh_.add(edit_, t, mesh_.triangle(t));
      if (fits && mesh_.allows(edit_, 0.99 * before)) return mesh_.make(edit_);
    }
  }

  /// The other diagonal of the two triangles at an edge.
  void flip(std::uint32_t a, std::uint32_t b) {
    edit_.clear();
    std::uint32_t across[2];
    for (const std::uint32_t t : mesh_.fan(a)) {
      const auto& v = mesh_.triangle(t);
      for (int k = 0; k < 3; ++k)
        if ((v[k] == a && v[(k + 1) % 3] == b) || (v[k] == b && v[(k + 1) % 3] == a)) {
          if (edit_.removed.size() == 2) return;
          across[v[k] == a ? 0 : 1] = v[(k + 2) % 3];
          edit_.removed.push_back(t);
        }
    }
    if (edit_.removed.size() != 2 || mesh_.edge_triangles(across[0], across[1]) > 0) return;
    if (mesh_.fan(a).size() <= 3 || mesh_.fan(b).size() <= 3) return;
    const double before = mesh_.unrest(edit_.removed);
    if (!(before > 0)) return;
    Vec3 area = Vec3::Zero();
    for (const std::uint32_t t : edit_.removed) {
      const auto c = mesh_.corners(t);
      area += (c[1] - c[0]).cross(c[2] - c[0]);
    }
    if (!mesh_.add_across(edit_, edit_.removed[0], {a, across[1], across[0]}, area)) return;
    if (!mesh_.add_across(edit_, edit_.removed[1], {b, across[0], across[1]}, area)) return;
    if (mesh_.allows(edit_, 0.99 * before)) mesh_.make(edit_);
  }

  const DecimateOptions& options_;
  Context& context_;
  BoundedMesh mesh_;
  std::size_t start_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> stamps_;
  CollapseQueue queue_;
  std::vector<std::uint32_t> around_a_, around_b_, common_;
  MeshEdit edit_;
};

}  // namespace

TriangleMesh decimated(const TriangleMesh& mesh, const DecimateOptions& options, Context& context) {
  ensure(options.max_error >= 0, "an error bound is not negative");
  ensure(options.frozen.empty() || options.frozen.size() == mesh.vertices.size(), "one flag per vertex, or none");
  if (mesh.empty()) return mesh;
  return Decimator(mesh, options, context).run();
}

}  // namespace partscribe::geometry
