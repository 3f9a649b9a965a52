#include "geometry/segment/faces.h"

#include <Eigen/Geometry>
#include <cmath>

namespace partscribe::geometry {

const char* name_of(FaceKind kind) {
  switch (kind) {
    case FaceKind::plane:
      return "plane";
    case FaceKind::cylinder:
      return "cylinder";
    case FaceKind::cone:
      return "cone";
    case FaceKind::sphere:
      return "sphere";
    case FaceKind::torus:
      return "torus";
    case FaceKind::free_form:
      break;
  }
  return "free_form";
}

FaceKind face_kind(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::cylinder:
      return FaceKind::cylinder;
    case PrimitiveKind::cone:
      return FaceKind::cone;
    case PrimitiveKind::sphere:
      return FaceKind::sphere;
    case PrimitiveKind::torus:
      return FaceKind::torus;
    default:
      return FaceKind::plane;
  }
}

const char* name_of(EdgeKind kind) {
  return kind == EdgeKind::convex ? "convex" : kind == EdgeKind::concave ? "concave" : "tangent";
}

void place_half_way(Face& face, double low, double high) {
  Primitive& p = face.fit.primitive;
  const double middle = p.kind == PrimitiveKind::torus ? 0 : 0.5 * (low + high);  // a torus has a place of its own
  face.low = low - middle, face.high = high - middle;
  p.point += middle * p.axis;
  if (p.kind != PrimitiveKind::cone) return;
  p.radius += middle * std::tan(p.half_angle);
  const double slope = face.fit.sigma_half_angle / std::pow(std::cos(p.half_angle), 2);
  face.fit.sigma_radius = std::hypot(face.fit.sigma_radius, middle * slope);
}

double area_of(const Faces& faces) {
  double sum = 0;
  for (const auto& face : faces.faces) sum += face.area;
  return sum;
}

bool mostly_known(const Faces& faces, const TriangleMesh& mesh) {
  double known = 0;
  for (const auto& face : faces.faces)
    if (face.kind != FaceKind::free_form) known += face.area;
  return known > 0.5 * area(mesh);
}

bool is_drawn(const TriangleMesh& mesh) {
  Context silent;
  return mostly_known(faces_of_mesh(mesh, {}, silent), mesh);
}

Faces faces_of(const Scan& scan, const FaceOptions& options, Context& context) {
  if (!scan.mesh.empty())
    if (Faces faces = faces_of_mesh(scan.mesh, options, context); mostly_known(faces, scan.mesh)) return faces;
  return faces_of_cloud(scan.cloud, options, context);
}

Vec3 outward_normal(const Face& face, const Vec3& point) {
  return (face.hollow ? -1 : 1) * surface_normal(face.surface(), point);
}

Vec3 surface_normal(const Primitive& primitive, const Vec3& point) {
  const Vec3 d = point - primitive.point;
  const double along = d.dot(primitive.axis);
  const Vec3 across = d - along * primitive.axis;
  const double radius = across.norm();
  const Vec3 outward = radius > 0 ? Vec3(across / radius) : Vec3(rotation_onto_axis(primitive.axis).col(0));
  switch (primitive.kind) {
    case PrimitiveKind::plane:
      return primitive.axis;
    case PrimitiveKind::sphere:
      return d.norm() > 0 ? Vec3(d.normalized()) : primitive.axis;
    case PrimitiveKind::cone:
      return std::cos(primitive.half_angle) * outward - std::sin(primitive.half_angle) * primitive.axis;
    case PrimitiveKind::torus: {
      const Vec3 from_ring = d - primitive.radius * outward;
      return from_ring.norm() > 0 ? Vec3(from_ring.normalized()) : outward;
    }
    default:
      return outward;
  }
}

}  // namespace partscribe::geometry
