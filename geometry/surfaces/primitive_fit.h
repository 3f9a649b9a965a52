/// Fits single primitives to points by orthogonal distance: the estimates that no unbiased estimator can beat.
#pragma once

#include <optional>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

enum class PrimitiveKind { plane, line, circle, sphere, cylinder, cone, torus };
const char* name_of(PrimitiveKind kind);  ///< "plane", ...

/// One primitive in the frame of its points. What a kind does not use is zero.
struct Primitive {
  PrimitiveKind kind = PrimitiveKind::plane;
  Vec3 point = Vec3::Zero();  ///< on the plane or line; centre; on the axis; of a cone: the place on its axis where the
                              ///< radius is `radius`
  Vec3 axis = Vec3::UnitZ();  ///< unit: normal of a plane or circle, direction of a line, axis; of a cone: towards
                              ///< growing radius
  double radius = 0;          ///< mm: circle, sphere, cylinder, cone (at `point`), torus (of the ring)
  double tube = 0;            ///< mm: torus
  double half_angle = 0;      ///< rad: cone, 0 .. pi/2
};

/// Signed (lines and circles: plain) orthogonal distance, mm: positive on the side of a plane's normal, outside of
/// closed kinds.
double distance(const Primitive& primitive, const Vec3& point);

/// What a fit found, with its uncertainty. The sigmas are those of the Cramer-Rao bound at the fit: if the noise is
/// independent from point to point, the truth lies within 1.96 of them in 95 of 100 scans. Errors that points have in
/// common are not included.
struct PrimitiveFit {
  Primitive primitive;
  double rms = 0;           ///< mm, weighted, of the distances that count
  double sigma_radius = 0;  ///< 1 sigma of each number; 0 where the kind has none. Of a cone: where `point` is now
  double sigma_tube = 0;
  double sigma_half_angle = 0;
  double sigma_point = 0;  ///< mm, largest over the directions that the kind fixes (along the normal, across the axis)
  double sigma_axis = 0;   ///< rad, largest tilt
  /// False: the data leave one of the kind's own numbers open, as a small patch of a huge sphere does: a radius or tube
  /// below three of its sigmas, a direction or half angle looser than 0.2 rad.
  bool determined = true;
  bool converged = false;
};

struct PrimitiveFitOptions {
  double sigma = 0;                             ///< mm, noise of a point; 0: estimated from the residuals
  double robust = 0;                            ///< Welsch constant in sigmas (2.5 is usual); 0: plain least squares
  const std::vector<double>* sigmas = nullptr;  ///< of every point, instead of `sigma`
  /// Else found from the points (and normals). A start is given up only where another explains the points clearly
  /// better.
  std::optional<Primitive> start;
};

/// `normals` may be empty; they serve the start, and the sense of a plane. Nothing if the points are not finite or
/// cannot fix the kind (2 for a line, 3 for a plane or circle, else one per unknown). Where the middle of the points
/// falls does not matter, nor does their order: numbers agree to 1e-8 of the noise. Noise is taken along the normal; of
/// lines and circles in all directions.
std::optional<PrimitiveFit> fit_primitive(PrimitiveKind kind, const std::vector<Vec3>& points,
                                          const std::vector<Vec3>& normals, const PrimitiveFitOptions& options);

}  // namespace partscribe::geometry
