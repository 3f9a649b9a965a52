#include "verify/features/features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "geometry/segment/faces.h"
#include "verify/features/feature_names.h"

namespace partscribe::verify {
namespace {

MeshFeature feature_of(const Face& face) {
  MeshFeature feature;
  feature.hollow = face.hollow, feature.area = face.area, feature.arc = face.arc;
  feature.low = face.low, feature.high = face.high, feature.middle = face.middle;
  feature.triangles = face.members;
  feature.kind = "free surface";
  if (face.kind == FaceKind::free_form) return feature;
  const Primitive& p = face.surface();
  feature.primitive = p;
  feature.kind = name_of(face.kind);
  if (face.kind == FaceKind::plane) return feature;
  double border = 0, smooth = 0;
  for (const auto& n : face.neighbours) {
    border += n.length;
    if (n.edge == EdgeKind::tangent) smooth += n.length;
  }
  feature.tangent = smooth > 0.5 * border;
  feature.sagitta = face.sagitta;
  feature.middle = p.kind == PrimitiveKind::torus ? Vec3(p.point + 0.5 * (face.low + face.high) * p.axis) : p.point;
  if (p.kind == PrimitiveKind::sphere) feature.arc = 2 * pi;
  const bool full = feature.arc > radians(240);
  if (p.kind == PrimitiveKind::torus && feature.tangent) feature.kind = feature.hollow ? "fillet" : "round";
  if (p.kind != PrimitiveKind::cylinder) return feature;
  if (full)
    feature.kind = feature.hollow ? "hole" : "boss";
  else if (feature.tangent && feature.arc < radians(150))
    feature.kind = feature.hollow ? "fillet" : "round";
  return feature;
}

/// What is too small to be a face, from all over the mesh.
MeshFeature too_small(const Faces& faces, const TriangleMesh& mesh) {
  MeshFeature rest;
  rest.kind = "small faces";
  for (std::uint32_t t = 0; t < faces.face_of.size(); ++t) {
    if (faces.face_of[t] != no_face) continue;
    const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    const double area = 0.5 * (b - a).cross(c - a).norm();
    rest.triangles.push_back(t);
    rest.area += area, rest.middle += area / 3 * (a + b + c);
  }
  if (rest.area > 0) rest.middle /= rest.area;
  return rest;
}

}  // namespace

MeshFeatures recognise_features(const TriangleMesh& mesh, double tolerance, const IsRound& is_round) {
  FaceOptions options;
  options.tolerance = tolerance, options.is_round = is_round, options.join_pieces = true;
  Context context;
  const Faces faces = faces_of_mesh(mesh, options, context);
  MeshFeatures result;
  for (const auto& face : faces.faces) result.features.push_back(feature_of(face));
  if (const MeshFeature rest = too_small(faces, mesh); !rest.triangles.empty()) result.features.push_back(rest);
  name_features(result.features);
  result.feature_of.assign(mesh.triangles.size(), 0);
  for (std::uint32_t i = 0; i < result.features.size(); ++i)
    for (const auto t : result.features[i].triangles) result.feature_of[t] = i;
  return result;
}

int sides_of(const MeshFeature& feature) {
  if (!feature.primitive || feature.primitive->kind != PrimitiveKind::cylinder) return 0;
  const double radius = feature.primitive->radius;
  if (!(feature.sagitta > 1e-6 * radius) || !(feature.sagitta < radius)) return 0;
  return static_cast<int>(std::lround(pi / std::acos(1 - feature.sagitta / radius)));
}

}  // namespace partscribe::verify
