#include "model/tri_faces.h"

namespace partscribe::model {
namespace {

constexpr PrimitiveKind kinds[] = {PrimitiveKind::plane, PrimitiveKind::cylinder, PrimitiveKind::cone,
                                   PrimitiveKind::sphere, PrimitiveKind::torus};

std::size_t sizes_of(PrimitiveKind kind) {
  return kind == PrimitiveKind::plane ? 0 : kind == PrimitiveKind::cone || kind == PrimitiveKind::torus ? 2 : 1;
}

std::vector<double> list(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::optional<Primitive> surface_of(const TriFace& face) {
  for (const auto kind : kinds) {
    if (face.surface != name_of(kind)) continue;
    const bool axis = kind != PrimitiveKind::sphere;
    if (face.point.size() != 3 || face.axis.size() != (axis ? 3 : 0) || face.sizes.size() != sizes_of(kind))
      return std::nullopt;
    Primitive surface;
    surface.kind = kind, surface.point = Vec3(face.point.data());
    if (axis) surface.axis = Vec3(face.axis.data());
    if (!face.sizes.empty()) surface.radius = face.sizes[0];
    if (kind == PrimitiveKind::cone) surface.half_angle = face.sizes[1];
    if (kind == PrimitiveKind::torus) surface.tube = face.sizes[1];
    return surface;
  }
  return std::nullopt;
}

TriFace tri_face(const Face& face, std::string name, std::size_t triangles) {
  TriFace result;
  result.name = std::move(name), result.triangles = static_cast<int>(triangles);
  if (face.kind == FaceKind::free_form) return result;
  const Primitive& p = face.surface();
  result.surface = name_of(p.kind), result.hollow = face.hollow, result.point = list(p.point);
  if (p.kind != PrimitiveKind::sphere) result.axis = list(p.axis);
  if (p.kind != PrimitiveKind::plane) result.sizes.push_back(p.radius);
  if (p.kind == PrimitiveKind::cone) result.sizes.push_back(p.half_angle);
  if (p.kind == PrimitiveKind::torus) result.sizes.push_back(p.tube);
  return result;
}

std::vector<std::uint32_t> faces_of_triangles(const TriSurfaceOf<double>& surface) {
  std::vector<std::uint32_t> result;
  for (std::uint32_t f = 0; f < surface.faces.size(); ++f)
    result.insert(result.end(), static_cast<std::size_t>(surface.faces[f].triangles), f);
  return result;
}

double facet_depth(const TriSurfaceOf<double>& surface) {
  double most = 0;
  std::size_t next = 0;
  for (const auto& face : surface.faces) {
    const auto exact = surface_of(face);
    for (int i = 0; i < face.triangles; ++i, ++next) {
      if (!exact || exact->kind == PrimitiveKind::plane) continue;
      Vec3 corner[3];
      for (int k = 0; k < 3; ++k) corner[k] = Vec3(surface.vertices[surface.triangles[next][k]].data());
      most = std::max(most, std::abs(distance(*exact, (corner[0] + corner[1] + corner[2]) / 3)));
      for (int k = 0; k < 3; ++k)
        most = std::max(most, std::abs(distance(*exact, 0.5 * (corner[k] + corner[(k + 1) % 3]))));
    }
  }
  return most;
}

}  // namespace partscribe::model
