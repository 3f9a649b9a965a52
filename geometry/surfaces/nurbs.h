/// Rational and polynomial B-spline curves and surfaces of any degree: values, derivatives, knots.
///
/// A point of a curve is C(t) = sum_i w_i P_i N_ip(t) / sum_i w_i N_ip(t), with the basis functions N_ip of degree p
/// over a knot vector (Cox and de Boor's recursion; Piegl and Tiller, The NURBS Book, equations 2.5 and 4.1). Spans are
/// half open, [t_i, t_i+1), but for the last one of the domain, which is closed; 0 / 0 counts as 0. Outside of the
/// domain the first and the last span go on as polynomials. Places in mm, or in the units of a parameter plane.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

inline constexpr int most_spline_degree = 25;

/// Degree and knots of one parameter; every knot is repeated by its multiplicity.
struct KnotVector {
  int degree = 3;
  std::vector<double> knots;  ///< ascending; periodic ones unrolled

  int count() const { return static_cast<int>(knots.size()) - degree - 1; }  ///< control points
  double low() const { return knots[static_cast<std::size_t>(degree)]; }     ///< where the domain begins
  double high() const { return knots[knots.size() - static_cast<std::size_t>(degree) - 1]; }
  /// The span that holds t, as the index of the knot before it; its basis functions are span - degree .. span.
  int span(double t) const;
  /// The different knots, and how often each is there.
  std::vector<std::pair<double, int>> multiplicities() const;
  std::vector<double> breaks() const;  ///< the different knots of the domain, its ends included
  bool operator==(const KnotVector&) const = default;
};

/// Clamped at both ends: these count degree + 1 times, the breaks between them once.
KnotVector clamped(int degree, const std::vector<double>& breaks);

/// The degree + 1 basis functions that live at one place, with two derivatives.
struct BasisValues {
  int first = 0;  ///< control point of the first of them
  double value[3][most_spline_degree + 1];
};
/// `derivatives`: 0, 1 or 2; what is beyond is left undefined.
void basis(const KnotVector& knots, double t, int derivatives, BasisValues& result);

template <int D>
struct NurbsCurve {
  using Point = Eigen::Matrix<double, D, 1>;
  KnotVector t;
  std::vector<Point> points;    ///< control points
  std::vector<double> weights;  ///< as many, all positive; empty: polynomial
  Point at(double u) const;
  /// Point, first and second derivative.
  void derivatives(double u, Point& point, Point& first, Point& second) const;
  bool operator==(const NurbsCurve&) const = default;
};

/// Place and derivatives of a surface.
struct SurfacePoint {
  Vec3 p, du, dv, duu, duv, dvv;
  Vec3 normal() const;  ///< unit, along du x dv; zero where these are parallel
};

struct NurbsSurface {
  KnotVector u, v;
  std::vector<Vec3> points;     ///< u.count() times v.count() control points, v running fastest
  std::vector<double> weights;  ///< as many, all positive; empty: polynomial
  Vec3 at(double s, double t) const;
  SurfacePoint derivatives(double s, double t) const;
  bool operator==(const NurbsSurface&) const = default;
};

/// A unit normal along du x dv; where that vanishes, on an edge that is one point or in a corner whose sides are
/// parallel, its limit from within the domain at the same u and v. Zero where there is none.
Vec3 normal_at(const NurbsSurface& surface, double u, double v);

/// One more knot at t: control point i of the refined line is the mean of i - 1 and i with these shares of i (Boehm).
std::vector<double> insertion_shares(const KnotVector& knots, double t);
KnotVector with_knot(const KnotVector& knots, double t);

/// The same curve or surface with `times` more knots at t, inside of the domain.
template <int D>
NurbsCurve<D> with_knot(const NurbsCurve<D>& curve, double t, int times = 1);
NurbsSurface with_knot(const NurbsSurface& surface, bool along_u, double t, int times = 1);

/// Where a surface comes nearest to a point.
struct SplineFoot {
  double u = 0, v = 0;  ///< inside of the domain
  double distance = 0;  ///< mm, >= 0
  Vec3 point = Vec3::Zero();
};
/// The foot that Newton's steps reach from a start near it; on the border of the domain if they lead out of it.
SplineFoot foot_near(const NurbsSurface& surface, const Vec3& p, double u, double v);

extern template struct NurbsCurve<2>;
extern template struct NurbsCurve<3>;

}  // namespace partscribe::geometry
