#include "fit/surface/lattice_facets.h"

#include <algorithm>
#include <limits>

namespace partscribe::fit {

double LatticeFacets::distance(std::uint32_t t, const Vec3& p) const {
  const auto& v = facets_[t].v;
  return distance_to_triangle(p, place(v[0]), place(v[1]), place(v[2]));
}

double LatticeFacets::distance_to_edge(std::uint32_t t, std::size_t k, const Vec3& p) const {
  const Vec3 &a = place(facets_[t].v[(k + 1) % 3]), &b = place(facets_[t].v[(k + 2) % 3]);
  return distance_to_triangle(p, a, a, b);
}

// ---- changes that can be taken back ---------------------------------------------------------------------------

void LatticeFacets::begin() { ++epoch_, journal_.clear(), reshaped_.clear(); }

void LatticeFacets::keep() {
  for (const std::uint32_t t : reshaped_)
    if (!facets_[t].alive()) free_.push_back(t);
}

void LatticeFacets::roll_back() {
  for (auto& [t, before] : journal_) {
    if (!before.alive()) free_.push_back(t);
    facets_[t] = std::move(before);
  }
  journal_.clear();
  hull_known_ = false;
}

const std::vector<std::uint32_t>& LatticeFacets::hull() {
  if (hull_known_) return hull_;
  hull_.clear();
  for (std::uint32_t t = 0; t < facets_.size(); ++t)
    if (facets_[t].alive() && facets_[t].index_across(nobody) < 3) hull_.push_back(t);
  hull_known_ = true;
  return hull_;
}

std::vector<const LatticeFacet*> LatticeFacets::replaced() const {
  std::vector<const LatticeFacet*> result;
  for (const auto& [t, before] : journal_)
    if (made_[t] == epoch_ && before.alive()) result.push_back(&before);
  return result;
}

void LatticeFacets::touch(std::uint32_t t) {
  if (touched_[t] == epoch_) return;
  touched_[t] = epoch_;
  entry_[t] = static_cast<std::uint32_t>(journal_.size());
  journal_.emplace_back(t, facets_[t]);
}

void LatticeFacets::reshape(std::uint32_t t) {
  touch(t);
  hull_known_ = false;
  if (made_[t] != epoch_) made_[t] = epoch_, reshaped_.push_back(t);
}

std::uint32_t LatticeFacets::new_slot() {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(facets_.size()));
    facets_.emplace_back();
    touched_.push_back(0), entry_.push_back(0), made_.push_back(0);
  }
  const std::uint32_t t = free_.back();
  free_.pop_back();
  return t;
}

void LatticeFacets::make(std::uint32_t t, const LatticePicture::Corners& v) {
  reshape(t);
  LatticeFacet& f = facets_[t];
  f.v = v;
  f.n.fill(nobody);
  f.surface = picture_.is_surface(v);
  f.edges = edge_functions(place(v[0]), place(v[1]), place(v[2]));
  f.sphere = minsphere(place(v[0]), place(v[1]), place(v[2]));
  f.guests.clear();
}

/// Makes `outer` the neighbour of t across its edge k, and the other way round.
void LatticeFacets::join(std::uint32_t t, std::size_t k, std::uint32_t outer) {
  facets_[t].n[k] = outer;
  if (outer == nobody) return;
  touch(outer);
  LatticeFacet& o = facets_[outer];
  const Pixel from = facets_[t].v[(k + 1) % 3], to = facets_[t].v[(k + 2) % 3];
  for (std::size_t i = 0; i < 3; ++i)
    if (o.v[(i + 1) % 3] == to && o.v[(i + 2) % 3] == from) o.n[i] = t;
}

// ---- operations -----------------------------------------------------------------------------------------------

void LatticeFacets::add_first(const LatticePicture::Corners& v) { make(new_slot(), v); }

/// Facets from a pixel to the edges of a ring, or of a chain; `slots` are used up first.
void LatticeFacets::fan(Pixel p, const std::vector<RingEdge>& ring, std::vector<std::uint32_t> slots) {
  while (slots.size() < ring.size()) slots.push_back(new_slot());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    make(slots[i], {ring[i].from, ring[i].to, p});
    join(slots[i], 2, ring[i].outer);
  }
  for (std::size_t i = 0; i < ring.size(); ++i)
    for (std::size_t j = 0; j < ring.size(); ++j)
      if (ring[i].to == ring[j].from) facets_[slots[i]].n[0] = slots[j], facets_[slots[j]].n[1] = slots[i];
}

void LatticeFacets::insert(Pixel p, std::uint32_t home) {
  std::vector<RingEdge> ring;
  std::vector<std::uint32_t> slots;
  if (home == nobody) {
    for (const std::uint32_t t : hull())
      for (std::size_t k = 0; k < 3; ++k) {
        const Pixel a = facets_[t].v[(k + 1) % 3], b = facets_[t].v[(k + 2) % 3];
        if (facets_[t].n[k] == nobody && picture_.turn(a, b, p) < 0) ring.push_back({b, a, t});
      }
  } else {
    const auto add = [&](std::uint32_t t, std::size_t but) {
      const LatticeFacet& f = facets_[t];
      for (std::size_t k = 0; k < 3; ++k)
        if (k != but) ring.push_back({f.v[(k + 1) % 3], f.v[(k + 2) % 3], f.n[k]});
      slots.push_back(t);
    };
    const LatticeFacet& f = facets_[home];
    std::size_t on = 3;
    for (std::size_t k = 0; k < 3; ++k)
      if (picture_.turn(f.v[(k + 1) % 3], f.v[(k + 2) % 3], p) == 0) on = k;
    add(home, on);
    if (on < 3 && f.n[on] != nobody) add(f.n[on], facets_[f.n[on]].index_across(home));
  }
  fan(p, ring, std::move(slots));
}

/// The edges around the facets at a corner, in order, and these facets; an open chain at the border.
std::vector<LatticeFacets::RingEdge> LatticeFacets::star(Pixel p, std::uint32_t home,
                                                         std::vector<std::uint32_t>& facets) const {
  std::uint32_t begin = home;
  for (;;) {  // back to the border, or once around
    const LatticeFacet& f = facets_[begin];
    const std::uint32_t before = f.n[(f.index_of_corner(p) + 2) % 3];
    if (before == nobody || before == home) break;
    begin = before;
  }
  std::vector<RingEdge> ring;
  std::uint32_t t = begin;
  do {
    const LatticeFacet& f = facets_[t];
    const std::size_t i = f.index_of_corner(p);
    facets.push_back(t);
    ring.push_back({f.v[(i + 1) % 3], f.v[(i + 2) % 3], f.n[i]});
    t = f.n[(i + 1) % 3];
  } while (t != nobody && t != begin);
  return ring;
}

bool LatticeFacets::remove(Pixel p, std::uint32_t home) {
  std::vector<std::uint32_t> facets;
  std::vector<RingEdge> ring = star(p, home, facets);
  if (ring.back().to != ring.front().from) {
    if (picture_.turn(ring.back().to, p, ring.front().from) != 0) return false;
    ring.push_back({ring.back().to, ring.front().from, nobody});
  }
  return cut_ears(std::move(ring), std::move(facets));
}

bool LatticeFacets::cut_ears(std::vector<RingEdge> ring, std::vector<std::uint32_t> slots) {
  while (ring.size() >= 3) {
    std::size_t best = ring.size();
    std::pair<double, double> least(std::numeric_limits<double>::infinity(), 0);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Pixel a = ring[i].from, b = ring[i].to, c = ring[(i + 1) % ring.size()].to;
      if (picture_.turn(a, b, c) <= 0) continue;
      const Minsphere sphere = minsphere(place(a), place(b), place(c));
      double depth = 0;
      bool clear = true;
      for (const RingEdge& e : ring) {
        const Pixel q = e.from;
        if (q == a || q == b || q == c) continue;
        clear = clear && (picture_.turn(a, b, q) < 0 || picture_.turn(b, c, q) < 0 || picture_.turn(c, a, q) < 0);
        depth = std::max(depth, sphere.depth(place(q)));
      }
      const std::pair<double, double> rank(depth, sphere.sq_radius);
      if (clear && rank < least) least = rank, best = i;
    }
    if (best == ring.size()) return false;
    const std::size_t next = (best + 1) % ring.size();
    const std::uint32_t t = slots.back();
    slots.pop_back();
    make(t, {ring[best].from, ring[best].to, ring[next].to});
    join(t, 2, ring[best].outer), join(t, 0, ring[next].outer);
    if (ring.size() == 3) {
      join(t, 1, ring[(best + 2) % 3].outer);
      break;
    }
    ring[best] = {ring[best].from, ring[next].to, t};
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(next));
  }
  for (const std::uint32_t t : slots) {
    reshape(t);
    facets_[t] = LatticeFacet();
  }
  return true;
}

// ---- the empty minsphere --------------------------------------------------------------------------------------

template <class Facets>
bool LatticeFacets::broken(const LatticeFacet& f, std::size_t k, const Facets& facets) const {
  if (!f.surface || f.n[k] == nobody || !facets[f.n[k]].surface) return false;
  const LatticeFacet& g = facets[f.n[k]];
  const Pixel from = f.v[(k + 1) % 3], to = f.v[(k + 2) % 3];
  std::size_t i = 0;
  while (g.v[i] == from || g.v[i] == to) ++i;
  return f.sphere.holds(place(g.v[i])) || g.sphere.holds(place(f.v[k]));
}

bool LatticeFacets::broken(std::uint32_t t, std::size_t k) const { return broken(facets_[t], k, facets_); }

int LatticeFacets::newly_broken() const {
  struct Before {
    const LatticeFacets& all;
    const LatticeFacet& operator[](std::uint32_t t) const {
      return all.touched_[t] == all.epoch_ ? all.journal_[all.entry_[t]].second : all.facets_[t];
    }
  } const before{*this};
  int twice = 0;
  for (const std::uint32_t t : reshaped_)
    for (std::size_t k = 0; k < 3; ++k) {
      // Edges between two of them are seen from both sides.
      const auto weight = [&](const LatticeFacet& f) { return made_[f.n[k]] == epoch_ ? 1 : 2; };
      if (const LatticeFacet& f = facets_[t]; f.alive() && broken(f, k, facets_)) twice += weight(f);
      if (const LatticeFacet& f = before[t]; f.alive() && broken(f, k, before)) twice -= weight(f);
    }
  return twice / 2;
}

/// What flipping an edge is worth. Coverage of the surface comes first, for what lies over the background is no part of
/// the triangulation; then emptier minspheres; beside the background, where spheres mean nothing, circles in the
/// picture.
LatticeFacets::Flip LatticeFacets::flip_across(std::uint32_t t, std::size_t k) const {
  const LatticeFacet& f = facets_[t];
  const Pixel p = f.v[k], a = f.v[(k + 1) % 3], b = f.v[(k + 2) % 3];
  Flip flip{t, std::minmax(a, b), {}, 0, 0};
  if (f.n[k] == nobody) return flip;
  const LatticeFacet& g = facets_[f.n[k]];
  const Pixel q = g.v[g.index_across(t)];
  if (picture_.turn(p, a, q) <= 0 || picture_.turn(p, q, b) <= 0) return flip;  // not strictly convex
  const bool both = f.surface && g.surface;
  const double depth = std::max(f.sphere.depth(place(q)), g.sphere.depth(place(p)));
  if (both && !(depth > 1e-9)) return flip;
  flip.other = std::minmax(p, q);
  flip.length = (place(p) - place(q)).norm();
  const int covered = picture_.is_surface({p, a, q}) + picture_.is_surface({p, q, b}) - f.surface - g.surface;
  if (covered > 0) flip.gain = 10 * covered;
  if (covered != 0) return flip;
  if (both) {
    const double depth_after = std::max(minsphere(place(p), place(a), place(q)).depth(place(b)),
                                        minsphere(place(p), place(q), place(b)).depth(place(a)));
    if (depth - depth_after > 1e-9) flip.gain = depth - depth_after;
  } else if (picture_.in_circle(p, a, b, q)) {
    flip.gain = 1e-12;
  }
  return flip;
}

void LatticeFacets::flip(std::uint32_t t, std::size_t k) {
  const std::uint32_t u = facets_[t].n[k];
  const LatticeFacet f = facets_[t], g = facets_[u];
  const std::size_t i = g.index_across(t);
  const Pixel p = f.v[k], a = f.v[(k + 1) % 3], b = f.v[(k + 2) % 3], q = g.v[i];
  make(t, {p, a, q});
  make(u, {p, q, b});
  join(t, 0, g.n[(i + 1) % 3]), join(t, 2, f.n[(k + 2) % 3]);
  join(u, 0, g.n[(i + 2) % 3]), join(u, 1, f.n[(k + 1) % 3]);
  facets_[t].n[1] = u, facets_[u].n[2] = t;
}

void LatticeFacets::flip_edges() {
  // The most rewarding first, so that the order does not depend on the sense in which facets run. Emptier spheres here
  // may be fuller ones there, and flips could go round for ever: an edge that was flipped away stays away.
  std::vector<Flip> flips;
  std::vector<std::pair<Pixel, Pixel>> gone;
  const auto look_at = [&](std::uint32_t t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Flip flip = flip_across(t, k);
      std::erase_if(flips, [&](const Flip& other) { return other.edge == flip.edge; });
      if (flip.gain > 0) flips.push_back(flip);
    }
  };
  for (std::size_t i = 0; i < reshaped_.size(); ++i)
    if (facets_[reshaped_[i]].alive()) look_at(reshaped_[i]);
  while (!flips.empty()) {
    const auto best = std::max_element(flips.begin(), flips.end());
    const Flip done = *best;
    flips.erase(best);
    if (std::find(gone.begin(), gone.end(), done.other) != gone.end()) continue;
    gone.push_back(done.edge);
    const LatticeFacet& f = facets_[done.facet];
    std::size_t k = 0;
    while (f.v[k] == done.edge.first || f.v[k] == done.edge.second) ++k;
    const std::uint32_t across = f.n[k];
    flip(done.facet, k);
    look_at(done.facet), look_at(across);
  }
}

}  // namespace partscribe::fit
