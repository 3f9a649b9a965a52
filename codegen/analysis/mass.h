/// Volume, surface, centroid and moments of inertia of a model's body, from its exact boundary.
#pragma once

#include "core/context.h"
#include "core/result.h"
#include "geometry/vec.h"
#include "model/check.h"

class TopoDS_Shape;

namespace partscribe::codegen {

/// Of a body of density 1, in the frame of the files that are written of it. Multiplied by a density in kg/mm^3 the
/// volume is a mass in kg and the inertia is in kg mm^2.
struct MassProperties {
  double volume = 0;             ///< mm^3
  double area = 0;               ///< mm^2, of the whole boundary
  Vec3 centroid = Vec3::Zero();  ///< mm
  Mat3 inertia = Mat3::Zero();   ///< mm^5, about the centroid; off the diagonal stand -integral(x y)
};

/// Of the boundary that STEP and IGES hold. An open surface is bad input: it has no volume.
Result<MassProperties> mass_properties(const CheckedModel& model, Context& context);

/// Of a closed boundary, or a compound of several.
MassProperties mass_properties(const TopoDS_Shape& solid);

/// About the axes in which no product of inertia is left.
struct PrincipalMoments {
  Vec3 moments;  ///< mm^5, smallest first
  Mat3 axes;     ///< columns, right-handed; where moments are equal the axes nearest to those of the frame
};

PrincipalMoments principal_moments(const Mat3& inertia);

}  // namespace partscribe::codegen
