/// A triangulation of pixels that changes one point at a time, and can take the last change back.
#pragma once

#include <utility>
#include <vector>

#include "fit/surface/minsphere.h"
#include "fit/surface/sample_lattice.h"

namespace partscribe::fit {

/// A triangle in the picture and in space.
struct LatticeFacet {
  using Pixel = LatticePicture::Pixel;
  static constexpr std::uint32_t nobody = ~0u;

  LatticePicture::Corners v{nobody, nobody, nobody};       ///< of positive turn
  std::array<std::uint32_t, 3> n{nobody, nobody, nobody};  ///< the facet across the edge without that corner
  bool surface = false;                                    ///< belongs to the part; others lie over its background
  EdgeFunctions edges;
  Minsphere sphere;
  std::vector<Pixel> guests;  ///< pixels beside it that depend on it; kept for the user, gone with the facet

  bool alive() const { return v[0] != nobody; }
  std::size_t index_of_corner(Pixel p) const { return v[0] == p ? 0 : v[1] == p ? 1 : v[2] == p ? 2 : 3; }
  std::size_t index_across(std::uint32_t t) const { return n[0] == t ? 0 : n[1] == t ? 1 : n[2] == t ? 2 : 3; }
};

/// Facets cover the convex hull of their corners in the picture. Changes are made between begin() and keep() or
/// roll_back().
class LatticeFacets {
 public:
  using Pixel = LatticePicture::Pixel;
  static constexpr std::uint32_t nobody = LatticeFacet::nobody;

  explicit LatticeFacets(const LatticePicture& picture) : picture_(picture) {}

  std::size_t size() const { return facets_.size(); }  ///< with those that are not alive
  const LatticeFacet& operator[](std::uint32_t t) const { return facets_[t]; }
  std::vector<Pixel>& guests(std::uint32_t t) { return facets_[t].guests; }
  double distance(std::uint32_t t, const Vec3& p) const;  ///< d(p, T)
  double distance_to_edge(std::uint32_t t, std::size_t k, const Vec3& p) const;

  void begin();
  void keep();
  void roll_back();

  void add_first(const LatticePicture::Corners& v);
  /// Puts a point in by where it lies: in facet `home` or on an edge of it (1 facet becomes 3, 2 become 4, or 1 at the
  /// border 2), or with nobody outside, where it is joined to the edges of the border that it sees.
  void insert(Pixel p, std::uint32_t home);
  /// Takes a corner of facet `home` out and cuts its star into ears, at each time the one whose minsphere is emptiest
  /// of the ring's other corners. False if that does not work: at corners of the border something would be bared.
  bool remove(Pixel p, std::uint32_t home);
  /// Flips the edges of what was changed, and those that this concerns, while it brings more of the surface to light,
  /// or minspheres become emptier; facets stay valid in the picture.
  void flip_edges();

  /// Facets that changed their shape since begin(), dead ones too.
  const std::vector<std::uint32_t>& reshaped() const { return reshaped_; }
  /// What they were before.
  std::vector<const LatticeFacet*> replaced() const;
  /// Facets on the border of the hull, ascending.
  const std::vector<std::uint32_t>& hull();

  /// Does a minsphere of the two surface facets at edge k hold the corner across?
  bool broken(std::uint32_t t, std::size_t k) const;
  /// Broken edges of the reshaped facets, less those of what they replaced.
  int newly_broken() const;

 private:
  struct RingEdge {
    Pixel from, to;
    std::uint32_t outer;  // the facet on the far side
  };
  struct Flip {
    std::uint32_t facet = nobody;
    std::pair<Pixel, Pixel> edge, other;  // what is there, and what would be
    double gain = 0;                      // not positive: none
    double length = 0;                    // mm of the other
    bool operator<(const Flip& b) const {
      return gain != b.gain ? gain < b.gain : length != b.length ? length > b.length : edge > b.edge;
    }
  };

  const Vec3& place(Pixel p) const { return picture_.place(p); }
  template <class Facets>
  bool broken(const LatticeFacet& f, std::size_t k, const Facets& facets) const;
  void touch(std::uint32_t t);
  void reshape(std::uint32_t t);
  std::uint32_t new_slot();
  void make(std::uint32_t t, const LatticePicture::Corners& v);
  void join(std::uint32_t t, std::size_t k, std::uint32_t outer);
  void fan(Pixel p, const std::vector<RingEdge>& ring, std::vector<std::uint32_t> slots);
  bool cut_ears(std::vector<RingEdge> ring, std::vector<std::uint32_t> slots);
  std::vector<RingEdge> star(Pixel p, std::uint32_t home, std::vector<std::uint32_t>& facets) const;
  Flip flip_across(std::uint32_t t, std::size_t k) const;
  void flip(std::uint32_t t, std::size_t k);

  const LatticePicture& picture_;
  std::vector<LatticeFacet> facets_;
  std::vector<std::uint32_t> free_, reshaped_, hull_;
  std::vector<std::pair<std::uint32_t, LatticeFacet>> journal_;  // what was touched, as it was
  std::vector<std::uint32_t> touched_, entry_, made_;            // of each facet: since when, and where in the journal
  std::uint32_t epoch_ = 0;
  bool hull_known_ = false;
};

}  // namespace partscribe::fit
