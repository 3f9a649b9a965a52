#include "codegen/analysis/mass.h"

#include <BRepGProp.hxx>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <GProp_GProps.hxx>
#include <Standard_Failure.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Pnt.hxx>

#include "codegen/analysis/boundary_integral.h"
#include "codegen/exchange/brep.h"

namespace partscribe::codegen {
namespace {

/// Moments that differ by less than this share of the largest are equal: a turned part has two that only rounding
/// tells apart.
constexpr double equal_moments = 1e-7;

/// An orthonormal basis of the plane or space that `span` (orthonormal columns first .. first + count) covers, of
/// directions as near as possible to axes of the frame.
void align_with_frame(Mat3& axes, int first, int count) {
  Mat3 projector = Mat3::Zero();
  for (int k = first; k < first + count; ++k) projector += axes.col(k) * axes.col(k).transpose();
  for (int k = first; k < first + count; ++k) {
    int nearest = 0;
    // An axis of the frame that is as good as another, but for rounding, comes first.
    for (int a = 1; a < 3; ++a)
      if (projector(a, a) > projector(nearest, nearest) + 1e-9) nearest = a;
    const Vec3 axis = projector.col(nearest).normalized();
    axes.col(k) = axis;
    projector -= axis * axis.transpose();
  }
}

}  // namespace

MassProperties mass_properties(const TopoDS_Shape& solid) {
  // About a far origin the moments would be small differences of large numbers.
  GProp_GProps rough;
  BRepGProp::SurfaceProperties(solid, rough);
  const gp_Pnt middle = rough.CentreOfMass();
  const Vec3 origin(middle.X(), middle.Y(), middle.Z());
  const BodyIntegrals integrals = body_integrals(solid, origin);
  MassProperties mass;
  mass.volume = integrals.volume;
  mass.area = integrals.area;
  const Vec3 offset = integrals.first / integrals.volume;
  mass.centroid = origin + offset;
  const Mat3 second = integrals.second - integrals.volume * offset * offset.transpose();
  mass.inertia = second.trace() * Mat3::Identity() - second;
  return mass;
}

Result<MassProperties> mass_properties(const CheckedModel& model, Context& context) {
  const Object& last = model->objects.back();
  if (is_sheet(last.shape))
    return bad_input("object '" + last.name + "': expected a solid, found an open " + std::string(kind_of(last.shape)) +
                     ", which has a surface but no volume");
  const auto body = build_body(model, context);
  if (!body.ok()) return body.error();
  try {
    return mass_properties(*body->shape);
  } catch (const Standard_Failure& failure) {
    return bad_input("object '" + last.name +
                     "': expected a body that can be measured, OpenCASCADE says: " + failure.GetMessageString());
  }
}

PrincipalMoments principal_moments(const Mat3& inertia) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  PrincipalMoments principal{solver.eigenvalues(), solver.eigenvectors()};
  const double same = equal_moments * principal.moments.cwiseAbs().maxCoeff();
  const bool low = principal.moments[1] - principal.moments[0] <= same,
             high = principal.moments[2] - principal.moments[1] <= same;
  if (low && high)
    align_with_frame(principal.axes, 0, 3);
  else if (low || high)
    align_with_frame(principal.axes, low ? 0 : 1, 2);
  // The sense of an axis is arbitrary: towards the frame's axis to which it is nearest.
  for (int k = 0; k < 2; ++k) {
    Eigen::Index largest = 0;
    principal.axes.col(k).cwiseAbs().maxCoeff(&largest);
    if (principal.axes(largest, k) < 0) principal.axes.col(k) *= -1;
  }
  principal.axes.col(2) = principal.axes.col(0).cross(principal.axes.col(1));
  return principal;
}

}  // namespace partscribe::codegen
