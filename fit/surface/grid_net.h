/// The least-squares net of a grid over two knot vectors, and what moving or removing one knot does to its distances.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fit/surface/grid_fit.h"
#include "fit/surface/line_basis.h"

namespace partscribe::fit {

/// Means over `window` lines in turn, from each of `begins` on.
struct GridSamples {
  std::vector<std::size_t> begins;  ///< ascending
  std::size_t window = 1;
  std::size_t count() const { return begins.size(); }
};

/// What one knot adds to the surface, at the samples: along[s - begin] times across[t], t first for each component.
struct GridChange {
  std::size_t begin = 0;
  std::vector<float> along, across;
  double sign = 1;    ///< -1: it is put in, and taken from the distances
  double size = 0;    ///< mm, the largest of it
  double energy = 0;  ///< mm^2, the sum of its squares at the samples across
  std::size_t end() const { return begin + along.size(); }
};

/// Of distances over what is allowed: the largest, and a sum that all large ones count in (of their eighth powers).
struct GridNorm {
  double worst = 0, sum = 0;
};

using GridKnots = std::array<KnotVector, 2>;  ///< along u, along v

/// Distances are those of means of neighbouring points along the net's normals, over the tolerance, looked at in a few
/// places of each span. Directions: 0 along u, 1 along v.
class GridNet {
 public:
  /// `grid` must outlive this.
  GridNet(const SplineGrid& grid, const GridFitOptions& options);

  /// Takes knots over, and looks what their net leaves.
  void set(GridKnots knots);
  GridKnots knots() const { return {basis_[0]->knots(), basis_[1]->knots()}; }
  const KnotVector& knots(std::size_t d) const { return basis_[d]->knots(); }
  double controls() const { return double(basis_[0]->count()) * double(basis_[1]->count()); }
  NurbsSurface surface();

  const GridNorm& norm() const { return norm_; }
  const std::vector<float>& distances() const { return off_; }  ///< at the samples, u fastest
  const GridSamples& samples(std::size_t d) const { return samples_[d]; }
  const std::vector<double>& lines(std::size_t d) const { return *lines_[d]; }
  /// Does a line lie in a span?
  bool held(std::size_t d, double low, double high) const;

  /// Looks at the samples again: changes add up rounding.
  void look();
  /// mm, the largest mean that begins at any line. Lines with the largest of those that are not allowed are samples
  /// from the next set() on.
  double look_at_all();

  /// What the knot at t adds.
  GridChange change_of(std::size_t d, double t) { return change_of(d, *basis_[d], t); }
  /// The same where the knots of this direction are others.
  GridChange change_of(std::size_t d, const KnotVector& knots, double t);
  /// Takes the knot out if no distance is larger than `most` then, over what is allowed.
  bool take_out(std::size_t d, double t, double most);
  /// Moves the knot at t by `by` of the gap to the next one, to either side, if the norm's sum falls.
  bool move(std::size_t d, double t, double by);

  struct State {
    GridKnots knots;
    std::vector<float> off;
    GridNorm norm;
  };
  State state() const { return {knots(), off_, norm_}; }
  void restore(const State& state);  ///< of the same samples

 private:
  GridChange change_of(std::size_t d, const LineBasis& basis, double t);
  void split_components();
  Vec3 linear(double u, double v) const;
  const std::vector<double>& flat(std::size_t d);
  std::vector<double> net();
  std::vector<float> distances_at(const std::array<GridSamples, 2>& at, double allowed, std::vector<float>& weight);
  template <class Visit>
  void through(std::size_t d, std::span<const GridChange> changes, const Visit& visit) const;
  double sum_after(std::size_t d, std::span<const GridChange> changes) const;
  std::vector<float> after(std::size_t d, std::span<const GridChange> changes) const;
  void take_over(std::size_t d, LineBasis&& basis, std::vector<float>&& off, const GridNorm& norm);

  const SplineGrid& grid_;
  const GridFitOptions options_;
  const std::array<const std::vector<double>*, 2> lines_;
  std::array<std::size_t, 2> window_;
  std::array<GridSamples, 2> samples_;
  std::array<std::vector<std::size_t>, 2> missed_;  // lines that are samples because something was missed there
  Vec3 origin_, slope_[2];                          // of the components that are linear in the parameters
  std::vector<int> bent_;                           // the others
  std::size_t width_ = 0;                           // how many these are
  std::array<std::vector<double>, 2> data_;         // off the linear ones, [u][v][component] and [v][u][component]
  std::array<std::optional<LineBasis>, 2> basis_;
  std::array<std::vector<double>, 2> flat_;
  std::vector<float> off_, weight_;  // at the samples: distances over what is allowed, and what a change does to them
  GridNorm norm_;
};

}  // namespace partscribe::fit
