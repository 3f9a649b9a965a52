// GeometricTools' Appr* fits: closed forms and searches without a start, and its minimizers from the given start.
#include "peers.h"

#if __has_include(<Mathematics/ApprTorus3.h>)
#include <Mathematics/ApprCone3.h>
#include <Mathematics/ApprCylinder3.h>
#include <Mathematics/ApprOrthogonalLine3.h>
#include <Mathematics/ApprOrthogonalPlane3.h>
#include <Mathematics/ApprSphere3.h>
#include <Mathematics/ApprTorus3.h>

#include <cmath>

namespace peers {
namespace {

using partscribe::geometry::Primitive;
using partscribe::geometry::PrimitiveKind;
using partscribe::geometry::Vec3;
using Vector = gte::Vector3<double>;

Vec3 vec(const Vector& v) { return {v[0], v[1], v[2]}; }
Vector vec(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

std::shared_ptr<std::vector<Vector>> copy(const std::vector<Vec3>& points) {
  auto result = std::make_shared<std::vector<Vector>>();
  for (const Vec3& q : points) result->push_back(vec(q));
  return result;
}

Fit prepare_closed(const Question& question) {
  const PrimitiveKind kind = question.kind;
  if (kind == PrimitiveKind::circle || kind == PrimitiveKind::cone) return {};
  const auto points = copy(question.points);
  const Primitive start = question.start;
  return [points, start, kind]() -> std::optional<Primitive> {
    const int n = static_cast<int>(points->size());
    Primitive p;
    p.kind = kind;
    if (kind == PrimitiveKind::plane) {
      gte::ApprOrthogonalPlane3<double> fit;
      fit.Fit(n, points->data());
      p.point = vec(fit.GetParameters().first), p.axis = vec(fit.GetParameters().second);
    } else if (kind == PrimitiveKind::line) {
      gte::ApprOrthogonalLine3<double> fit;
      fit.Fit(n, points->data());
      p.point = vec(fit.GetParameters().origin), p.axis = vec(fit.GetParameters().direction);
    } else if (kind == PrimitiveKind::sphere) {
      gte::Sphere3<double> sphere;
      gte::ApprSphere3<double>().FitUsingSquaredLengths(n, points->data(), sphere);
      p.point = vec(sphere.center), p.radius = sphere.radius;
    } else if (kind == PrimitiveKind::cylinder) {
      gte::Cylinder3<double> cylinder;
      gte::ApprCylinder3<double> fit(0, 64, 32);
      fit(points->size(), points->data(), cylinder);
      p.point = vec(cylinder.axis.origin), p.axis = vec(cylinder.axis.direction), p.radius = cylinder.radius;
    } else {
      Vector C = vec(start.point), N = vec(start.axis);
      if (!gte::ApprTorus3<double>()(n, points->data(), C, N, p.radius, p.tube).first) return {};
      p.point = vec(C), p.axis = vec(N);
    }
    return p;
  };
}

Fit prepare_minimizer(const Question& question) {
  const PrimitiveKind kind = question.kind;
  if (kind != PrimitiveKind::sphere && kind != PrimitiveKind::cone && kind != PrimitiveKind::torus) return {};
  const auto points = copy(question.points);
  const Primitive start = question.start;
  return [points, start, kind]() -> std::optional<Primitive> {
    const int n = static_cast<int>(points->size());
    Primitive p = start;
    if (kind == PrimitiveKind::sphere) {
      gte::Sphere3<double> sphere;
      sphere.center = vec(start.point), sphere.radius = start.radius;
      gte::ApprSphere3<double>().FitUsingLengths(n, points->data(), 1024, false, sphere);
      p.point = vec(sphere.center), p.radius = sphere.radius;
    } else if (kind == PrimitiveKind::cone) {
      Vector apex = vec(Vec3(start.point - start.axis * (start.radius / std::tan(start.half_angle)))),
             axis = vec(start.axis);
      double angle = start.half_angle;
      gte::ApprCone3<double>()(n, points->data(), 100, 1e-10, 1e-12, 1e-3, 10, 10, true, apex, axis, angle);
      const double height = (start.point - vec(apex)).dot(vec(axis));
      p.axis = vec(axis), p.half_angle = angle;
      p.point = vec(apex) + height * p.axis, p.radius = height * std::tan(angle);
    } else {
      Vector C = vec(start.point), N = vec(start.axis);
      double ring = start.radius, tube = start.tube;
      gte::ApprTorus3<double>()(n, points->data(), 100, 1e-10, 1e-12, 1e-3, 10, 10, true, C, N, ring, tube);
      p.point = vec(C), p.axis = vec(N), p.radius = ring, p.tube = tube;
    }
    return p;
  };
}

}  // namespace

Prepare gte_fits() { return prepare_closed; }
Prepare gte_minimizer_fits() { return prepare_minimizer; }

}  // namespace peers
#else
namespace peers {
Prepare gte_fits() { return {}; }
Prepare gte_minimizer_fits() { return {}; }
}  // namespace peers
#endif
