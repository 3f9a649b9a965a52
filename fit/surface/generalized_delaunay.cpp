#include "fit/surface/generalized_delaunay.h"

#include <algorithm>
#include <limits>
#include <queue>

#include "core/ensure.h"
#include "fit/surface/lattice_facets.h"

namespace partscribe::fit {
namespace {

using Pixel = LatticePicture::Pixel;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Which samples are how far from the triangulation, and what is done about it.
class DelaunayRefinement {
 public:
  DelaunayRefinement(const SampleLattice& lattice, const GeneralizedDelaunayOptions& options)
      : picture_(lattice, options.longest_chord), facets_(picture_), options_(options), tolerance_(options.tolerance) {
    used_.assign(picture_.size(), 0), queued_.assign(picture_.size(), 0), home_.assign(picture_.size(), nobody);
    looked_pixel_.assign(picture_.size(), 0), value_.assign(picture_.size(), 0);
  }

  GeneralizedDelaunay run(const Context& context) {
    GeneralizedDelaunay result;
    const SampleLattice& lattice = picture_.lattice();
    int stride = 1;
    while (2 * stride <= options_.coarsest && 2 * stride < std::max(lattice.columns, lattice.rows)) stride *= 2;
    for (bool go = start(stride); go && stride >= 1 && !context.cancelled; stride /= 2) {
      stride_ = stride;
      DelaunayLevel level{stride};
      queue_all();
      level.added = insert_worst(false, level);
      if (stride == 1) result.forced = force(level);
      level.removed = remove_needless();
      // A corner beside the surface may have lost what it was near to.
      if (stride == 1) result.forced += force(level), level.added += result.forced;
      result.levels.push_back(level);
      context.report("triangulation", 1.0 / stride);
    }
    conclude(result);
    return result;
  }

 private:
  static constexpr std::uint32_t nobody = LatticeFacet::nobody;

  /// Candidates of the resolution: rows and columns counted from the first sample, so that a mirrored picture has the
  /// same, and the outermost ones that were seen, or needles would run along these until the finest.
  bool active(Pixel p) const {
    const int c = picture_.column(p), r = picture_.row(p);
    return ((c - picture_.column(first_)) % stride_ == 0 || c == left_ || c == right_) &&
           ((r - picture_.row(first_)) % stride_ == 0 || r == top_ || r == bottom_);
  }
  bool on_surface(std::uint32_t t) const { return t != nobody && facets_[t].surface; }

  // ---- distances ------------------------------------------------------------------------------------------------

  /// The sample's distance depends on a facet: where it does not lie on that in the picture, the facet takes note.
  void depend(Pixel s, std::uint32_t t) {
    auto& guests = facets_.guests(t);
    if (t != home_[s] && (guests.empty() || guests.back() != s)) guests.push_back(s);
  }

  /// Along the normal; where that passes the border by, the nearest triangle's there. What the normal misses though
  /// there is surface on all sides of it counts as farther than the tolerance.
  double distance(Pixel s) {
    const Vec3 &p = picture_.place(s), &n = picture_.normal(s);
    const std::uint32_t home = home_[s];
    const bool on = on_surface(home);
    if (on)
      if (const auto d = distance_along_normal(facets_[home].edges, p, n); d && *d < tolerance_) return *d;

    // A leaning normal may meet another facet. All that come within the tolerance are looked at; beside the surface,
    // where a neighbour in the picture may lie on one, so far as that is.
    const double reach = on ? tolerance_ : std::max(tolerance_, 1.5 * picture_.pitch());
    ++look_;
    looked_.resize(facets_.size(), 0);
    around_.clear();
    const auto see = [&](std::uint32_t t) {
      if (t == nobody || looked_[t] == look_) return;
      looked_[t] = look_;
      around_.push_back(t);
    };
    see(home);
    if (home == nobody) {
      find_nearest_on_hull(p);
      for (const std::uint32_t t : nearest_) see(t);
    }
    for (int dr = -1; dr <= 1 && !on; ++dr)
      for (int dc = -1; dc <= 1; ++dc)
        if (picture_.holds(picture_.column(s) + dc, picture_.row(s) + dr))
          see(home_[picture_.pixel(picture_.column(s) + dc, picture_.row(s) + dr)]);
    const std::size_t seeds = around_.size();
    double met = infinity, nearest = infinity, beside = infinity;  // beside: to the border
    for (std::size_t i = 0; i < around_.size(); ++i) {
      const std::uint32_t t = around_[i];
      depend(s, t);
      const double away = facets_.distance(t, p);
      if (facets_[t].surface) {
        nearest = std::min(nearest, away);
        for (std::size_t k = 0; k < 3; ++k)
          if (!on_surface(facets_[t].n[k])) beside = std::min(beside, facets_.distance_to_edge(t, k, p));
        if (const auto d = distance_along_normal(facets_[t].edges, p, n)) met = std::min(met, *d);
      }
      if (i < seeds || away < reach)
        for (const std::uint32_t other : facets_[t].n) see(other);
    }
    if (met < tolerance_) return met;
    if (!(beside < tolerance_)) beside = tolerance_ + nearest;  // the normal passes far from what is near
    if (on) return followed_normal(s, beside, tolerance_ + nearest);
    if (met < infinity) return met;
    return beside < infinity ? beside : to_corners(around_.front(), p);
  }

  /// From facet to facet until the normal meets one, leaves over the border, or runs past a ridge between two.
  double followed_normal(Pixel s, double over_border, double past_ridge) {
    std::uint32_t t = home_[s];
    for (int step = 0; step < 64; ++step) {
      depend(s, t);
      const LineFoot foot = line_foot(facets_[t].edges, picture_.place(s), picture_.normal(s));
      if (foot.inside()) return std::abs(foot.t);
      t = facets_[t].n[foot.edge];
      if (!on_surface(t)) return over_border;
    }
    return past_ridge;
  }

  double to_corners(std::uint32_t t, const Vec3& p) const {
    double nearest = infinity;
    for (const Pixel v : facets_[t].v) nearest = std::min(nearest, (picture_.place(v) - p).norm());
    return nearest;
  }

  /// Mostly two, that share a corner.
  void find_nearest_on_hull(const Vec3& p) {
    double least = infinity;
    for (const std::uint32_t t : facets_.hull()) {
      const double d = facets_[t].surface ? facets_.distance(t, p) : to_corners(t, p);
      if (d < least * (1 - 1e-12)) nearest_.clear(), least = d;
      if (d <= least * (1 + 1e-12)) nearest_.push_back(t);
    }
  }

  // ---- insertion ------------------------------------------------------------------------------------------------

  struct Entry {
    double value;
    Pixel sample;
    bool operator<(const Entry& b) const { return value != b.value ? value < b.value : sample > b.sample; }
  };

  void queue(Pixel s, double value) {
    if (queued_[s] != 0 && value == value_[s]) return;
    value_[s] = value;
    queued_[s] = !(value < tolerance_);
    if (queued_[s] != 0) queue_.push({value, s});
  }

  void queue_all() {
    for (Pixel s = 0; s < picture_.size(); ++s)
      if (picture_.seen(s) && !used_[s] && active(s)) queue(s, distance(s));
  }

  template <class Good>
  Pixel nearest_sample(const Vec3& to, const Good& good) const {
    Pixel best = nobody;
    double least = infinity;
    for (Pixel s = 0; s < picture_.size(); ++s) {
      if (!picture_.seen(s)) continue;
      const double sq = (picture_.place(s) - to).squaredNorm();
      if (sq < least && good(s)) least = sq, best = s;
    }
    return best;
  }

  /// One triangle on the sample nearest to the centre of gravity, with two others of as coarse a resolution as can be.
  bool start(int coarsest) {
    Vec3 centre = Vec3::Zero();
    double count = 0;
    left_ = picture_.lattice().columns, top_ = picture_.lattice().rows;
    for (Pixel s = 0; s < picture_.size(); ++s) {
      if (!picture_.seen(s)) continue;
      centre += picture_.place(s), ++count;
      left_ = std::min(left_, picture_.column(s)), right_ = std::max(right_, picture_.column(s));
      top_ = std::min(top_, picture_.row(s)), bottom_ = std::max(bottom_, picture_.row(s));
    }
    if (count < 3) return false;
    first_ = nearest_sample(centre / count, [](Pixel) { return true; });
    for (stride_ = coarsest; stride_ >= 1; stride_ /= 2) {
      const Vec3& a = picture_.place(first_);
      const Pixel second =
          nearest_sample(a, [&](Pixel s) { return s != first_ && active(s) && picture_.accompanied(first_, s); });
      if (second == nobody) continue;
      LatticePicture::Corners best{};
      double least = infinity;
      for (Pixel s = 0; s < picture_.size(); ++s) {
        if (!picture_.seen(s) || !active(s) || picture_.turn(first_, second, s) == 0) continue;
        const double size = minsphere(a, picture_.place(second), picture_.place(s)).sq_radius;
        if (!(size < least)) continue;
        LatticePicture::Corners v = {first_, second, s};
        if (picture_.turn(first_, second, s) < 0) std::swap(v[1], v[2]);
        if (picture_.is_surface(v)) least = size, best = v;
      }
      if (least == infinity) continue;
      facets_.begin();
      facets_.add_first(best);
      facets_.keep();
      for (const Pixel p : best) used_[p] = 1, order_.push_back(p);
      house();
      return true;
    }
    return false;
  }

  /// Pixels learn which of the reshaped facets they lie on; those on an edge belong to the surface if either side does,
  /// else to the smaller: not to the one that happens to come last.
  void house() {
    for (const std::uint32_t t : facets_.reshaped()) {
      const LatticeFacet& f = facets_[t];
      if (!f.alive()) continue;
      picture_.all_pixels(f.v, [&](Pixel p) {
        home_[p] = t;
        for (std::size_t k = 0; k < 3; ++k) {
          if (f.n[k] == nobody || picture_.turn(f.v[(k + 1) % 3], f.v[(k + 2) % 3], p) != 0) continue;
          const LatticeFacet &g = facets_[f.n[k]], &best = facets_[home_[p]];
          if (g.surface != best.surface ? g.surface : g.sphere.sq_radius < best.sphere.sq_radius) home_[p] = f.n[k];
        }
        return true;
      });
    }
  }

  /// Candidates whose distance the change may have altered.
  void find_concerned() {
    concerned_.clear();
    ++look_at_pixel_;
    const auto concern = [&](Pixel p) {
      if (looked_pixel_[p] != look_at_pixel_ && picture_.seen(p) && !used_[p] && active(p)) {
        looked_pixel_[p] = look_at_pixel_;
        concerned_.push_back(p);
      }
      return true;
    };
    for (const std::uint32_t t : facets_.reshaped())
      if (facets_[t].alive()) picture_.all_pixels(facets_[t].v, concern);
    for (const LatticeFacet* before : facets_.replaced())
      for (const Pixel p : before->guests) concern(p);
  }

  /// False, and nothing is changed, if more edges would be broken than before; unless it is `forced`. Outside it may
  /// be joined to by needles along the border, whose spheres say nothing before its neighbours are in as well.
  bool insert(Pixel s, bool forced) {
    forced = forced || home_[s] == nobody;
    facets_.begin();
    facets_.insert(s, home_[s]);
    facets_.flip_edges();
    if (!forced && facets_.newly_broken() > 0) {
      facets_.roll_back();
      return false;
    }
    facets_.keep();
    used_[s] = 1;
    order_.push_back(s);
    house();
    find_concerned();
    for (const Pixel p : concerned_) queue(p, distance(p));
    return true;
  }

  std::size_t insert_worst(bool forced, DelaunayLevel& level) {
    std::size_t added = 0;
    while (!queue_.empty()) {
      const auto [value, s] = queue_.top();
      queue_.pop();
      if (queued_[s] == 0 || value != value_[s]) continue;
      queued_[s] = 0;
      if (const double now = distance(s); now != value) {
        queue(s, now);
        continue;
      }
      (insert(s, forced) ? added : level.held_back) += 1;
    }
    return added;
  }

  /// The tolerance has the last word.
  std::size_t force(DelaunayLevel& level) {
    std::size_t added = 0;
    for (;;) {
      queue_all();
      const std::size_t now = queue_.empty() ? bring_surface_to_corners() : insert_worst(true, level);
      if (now == 0) break;
      added += now;
    }
    return added;
  }

  /// Corners from which no edge follows the surface get their neighbours for company.
  std::size_t bring_surface_to_corners() {
    std::vector<Pixel> company;
    for (const Pixel v : order_) {
      if (distance(v) < tolerance_) continue;
      for (int dr = -1; dr <= 1; ++dr)
        for (int dc = -1; dc <= 1; ++dc) {
          const int c = picture_.column(v) + dc, r = picture_.row(v) + dr;
          if (picture_.holds(c, r) && !used_[picture_.pixel(c, r)] && picture_.linked(v, dc, dr))
            company.push_back(picture_.pixel(c, r));
        }
    }
    std::size_t added = 0;
    for (const Pixel s : company)
      if (!used_[s]) added += insert(s, true);
    return added;
  }

  // ---- removal --------------------------------------------------------------------------------------------------

  bool remove(Pixel p) {
    facets_.begin();
    if (!facets_.remove(p, home_[p])) {
      facets_.roll_back();
      return false;
    }
    facets_.flip_edges();
    bool good = facets_.newly_broken() <= 0;
    if (good) {
      house();
      used_[p] = 0;
      find_concerned();
      good = distance(p) < tolerance_;  // the likeliest to be too far
      values_.clear();
      for (std::size_t i = 0; i < concerned_.size() && good; ++i) {
        values_.push_back(distance(concerned_[i]));
        good = values_.back() < tolerance_ || values_.back() <= value_[concerned_[i]];
      }
      for (const LatticeFacet* before : facets_.replaced())
        for (std::size_t k = 0; k < 3 && good && before->surface; ++k) good = distance(before->v[k]) < tolerance_;
    }
    if (good) {
      facets_.keep();
      for (std::size_t i = 0; i < concerned_.size(); ++i) value_[concerned_[i]] = values_[i];
      return true;
    }
    facets_.roll_back();
    house();
    used_[p] = 1;
    return false;
  }

  std::size_t remove_needless() {
    const std::size_t before = order_.size();
    std::erase_if(order_, [&](Pixel p) { return remove(p); });
    return before - order_.size();
  }

  // ---- the end --------------------------------------------------------------------------------------------------

  void conclude(GeneralizedDelaunay& result) {
    stride_ = 1;
    for (Pixel s = 0; s < picture_.size(); ++s) {
      if (!picture_.seen(s)) continue;
      ++result.samples;
      const double d = facets_.size() == 0 ? infinity : distance(s);
      if (d < tolerance_)
        result.max_distance = std::max(result.max_distance, d);
      else
        result.uncovered.push_back(s);
    }
    std::vector<std::pair<LatticePicture::Corners, std::uint32_t>> triangles;
    double facing = 0;
    for (std::uint32_t t = 0; t < facets_.size(); ++t) {
      const LatticeFacet& f = facets_[t];
      if (!f.alive() || !f.surface) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        facing += f.edges.normal.dot(picture_.normal(f.v[k]));
        if (f.n[k] < t && facets_.broken(t, k)) ++result.broken_edges;
      }
      LatticePicture::Corners v = f.v;
      std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
      triangles.emplace_back(v, t);
    }
    std::sort(triangles.begin(), triangles.end());
    std::vector<std::array<std::uint32_t, 3>> number(facets_.size(), {nobody, nobody, nobody});
    for (const auto& [v, t] : triangles) {
      std::array<std::uint32_t, 3> corners{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = facets_[t].index_of_corner(v[k]);
        if (number[t][i] == nobody) {
          number_fan(t, i, static_cast<std::uint32_t>(result.pixels.size()), number);
          result.mesh.vertices.push_back(picture_.place(v[k]));
          result.pixels.push_back(v[k]);
        }
        corners[k] = number[t][i];
      }
      // The normals know on which side the sensor is.
      if (facing < 0) std::swap(corners[1], corners[2]);
      result.mesh.triangles.push_back(corners);
    }
  }

  /// Surfaces that touch in one pixel get a vertex each: a number for the facets that hang together through edges.
  void number_fan(std::uint32_t t, std::size_t i, std::uint32_t vertex,
                  std::vector<std::array<std::uint32_t, 3>>& number) const {
    std::vector<std::uint32_t> fan = {t};
    number[t][i] = vertex;
    for (std::size_t done = 0; done < fan.size(); ++done)
      for (const std::uint32_t u : facets_[fan[done]].n) {
        if (!on_surface(u)) continue;
        const std::size_t k = facets_[u].index_of_corner(facets_[t].v[i]);
        if (k < 3 && number[u][k] == nobody) number[u][k] = vertex, fan.push_back(u);
      }
  }

  LatticePicture picture_;
  LatticeFacets facets_;
  const GeneralizedDelaunayOptions& options_;
  const double tolerance_;
  int stride_ = 1;
  Pixel first_ = 0;
  int left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;
  std::vector<std::uint8_t> queued_;  // with the value it has
  std::vector<std::uint8_t> used_;    // is a corner
  std::vector<std::uint32_t> home_;   // the facet of the picture each pixel lies on
  std::vector<double> value_;         // the distance last found
  std::priority_queue<Entry> queue_;  // with outdated ones
  std::vector<Pixel> order_;          // corners as they were inserted
  std::vector<std::uint32_t> looked_, looked_pixel_, around_, nearest_;
  std::vector<Pixel> concerned_;
  std::vector<double> values_;
  std::uint32_t look_ = 0, look_at_pixel_ = 0;
};

}  // namespace

GeneralizedDelaunay generalized_delaunay(const SampleLattice& lattice, const GeneralizedDelaunayOptions& options,
                                         const Context& context) {
  ensure(options.tolerance > 0, "a triangulation needs a tolerance");
  return DelaunayRefinement(lattice, options).run(context);
}

}  // namespace partscribe::fit
