/// The least-squares equations of points over a fine net, solved for any coarser one without going through the points
/// again.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// One direction of a coarse net in terms of a fine one: control point p of the fine net is the sum of four of the
/// coarse one, from `first[p]` on, with these shares (discrete B-splines; Cohen, Lyche & Riesenfeld 1980).
struct Restriction {
  std::vector<int> first;
  std::vector<double> share;  ///< four for each fine control point
  int coarse = 0;             ///< control points of the coarse net
};
/// Both cubic and clamped to the same ends; each knot of `coarse` must be one of `fine`, as often at least. From one
/// control point to the next `first` goes up by one at most.
Restriction restriction(const KnotVector& fine, const KnotVector& coarse);

/// Bicubic, clamped nets only. For B with a row of basis functions for each point: A = B^T W B and b = B^T W S of the
/// fine net. A net whose knots are some of the fine ones has R^T A R and R^T b, where R is its refinement.
class NetEquations {
 public:
  NetEquations(KnotVector u, KnotVector v);

  /// Adds points at places in the domain; `weights` may be empty for 1 each.
  void add(std::span<const Vec3> points, std::span<const Vec2> places, std::span<const double> weights);

  const KnotVector& u() const { return u_; }
  const KnotVector& v() const { return v_; }

  /// The net with these knots that is nearest to the points, with `fairness` times its bending energy in units of its
  /// cells added to the mean squared distance, so that there is one where there are no points.
  std::optional<NurbsSurface> solve(const KnotVector& u, const KnotVector& v, double fairness) const;

  /// What a surface leaves, for each basis function of the fine net: the mean of the points' signed distances along the
  /// normal, weighted by the function. v fastest.
  struct Left {
    std::vector<double> mean;    ///< mm
    std::vector<double> points;  ///< how many points with equal weights would average as well
  };
  Left left(const NurbsSurface& surface) const;

  /// mm^2, by how much a least-squares surface with the fine knots lowers the weighted sum of squares of the points.
  double explained(const NurbsSurface& surface) const;

 private:
  static constexpr int degree = 3, width = 4, reach = 7;
  /// R^T A R for one direction alone, [p][r - p][j][l - j]: along v with p in the rows of the fine net, or along u.
  struct Half {
    std::optional<KnotVector> knots;
    std::vector<double> entries;
  };
  const Half& half(bool along_u, const KnotVector& knots) const;
  std::vector<double> restricted_both(const KnotVector& u, const KnotVector& v) const;
  std::size_t rows() const { return std::size_t(u_.count()) * std::size_t(v_.count()); }

  KnotVector u_, v_;
  std::vector<double> a_;  // a row for each control point: entries for those up to three away, both ways
  std::vector<Vec3> b_;
  double weight_ = 0;  // of all points
  // Nets asked for in turn often share their knots in one direction.
  mutable Half half_u_, half_v_;
  mutable KnotVector last_u_;
};

}  // namespace partscribe::fit
