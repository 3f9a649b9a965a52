/// The inner loops of the primitive fits: distances, their derivatives and the sums of their products over many points.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// Points seen about their centre and divided by a power of two near their size.
struct ScaledPoints {
  const std::vector<Vec3>* points = nullptr;  ///< kept alive by the caller
  Vec3 center = Vec3::Zero();
  double factor = 1;
  std::vector<double> weight;  ///< of every point; empty: all 1
  std::size_t size() const { return points->size(); }
  Vec3 operator[](std::size_t i) const { return ((*points)[i] - center) * factor; }
};

/// Which distance a chart measures.
enum class ChartKind { sphere, cylinder, cone, circle, torus };

/// One place in the space of a kind's parameters. All but the torus stand on the surface (Lukacs, Marshall and Martin
/// 1998): `origin` is a surface point, the first axis of the frame its normal (across the axis), the third the axis,
/// and size is the curvature kappa across the axis, which may pass through zero: a plane is an ordinary member.
/// Of a torus `origin` is the centre. Rows of `frame` are the axes.
struct PrimitiveChart {
  ChartKind kind = ChartKind::sphere;
  Vec3 origin = Vec3::Zero();
  Mat3 frame = Mat3::Identity();
  double kappa = 0;           ///< 1 / radius at the origin
  double psi = 0;             ///< half angle of a cone, negative where it narrows along the axis
  double ring = 0, tube = 0;  ///< torus
};

/// Unknowns of a chart, in the order of its columns:
/// sphere   shift along the normal, tilt of the normal to the second and third axis, kappa
/// cylinder shift, roll about the axis, tilt about the first and second axis, kappa
/// cone     shift along the normal of the surface, roll, two tilts, kappa, psi
/// circle   shift along the first axis, roll, two tilts, kappa, shift along the third axis
/// torus    three shifts, two tilts, ring, tube
inline constexpr int max_unknowns = 7;
int unknowns_of(ChartKind kind);

/// Sums over points of products of derivatives and distances.
struct KernelEquations {
  Eigen::Matrix<double, max_unknowns, max_unknowns> H = Eigen::Matrix<double, max_unknowns, max_unknowns>::Zero();
  Eigen::Matrix<double, max_unknowns, 1> g = Eigen::Matrix<double, max_unknowns, 1>::Zero();
  double cost = 0;     ///< sum w d^2, or of the robust loss in the same units
  double squares = 0;  ///< sum of w d^2 with robust weights
  double weight = 0;   ///< sum of weights, robust ones included
  double count = 0;    ///< sum of the robust weights alone; the number of points for plain least squares
};

/// Sums at `chart` over all points, in the same order on every processor. `reach` > 0 weighs points by Welsch's
/// exp(-u^2 / 2) with u = sqrt(w) d / reach; 0 is plain least squares.
KernelEquations normal_equations(const ScaledPoints& points, const PrimitiveChart& chart, double reach);

/// Sums of w, w q and w q q^T with q = p - origin; one pass.
struct Moments {
  double weight = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
};
Moments moments(const std::vector<Vec3>& points, const double* weights, const Vec3& origin);

}  // namespace partscribe::geometry
