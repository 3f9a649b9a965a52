/// What holds between the faces of a part within their uncertainty: parallel, orthogonal, coaxial, equal, ...
#pragma once

#include <string>
#include <vector>

#include "geometry/segment/faces.h"

namespace partscribe::fit {

enum class RelationKind { parallel, orthogonal, coaxial, coplanar, equal_radius, tangent };
const char* name_of(RelationKind kind);  ///< "parallel", ..., "equal_radius"

/// Its value is an angle between directions.
inline bool is_angle(RelationKind kind) { return kind == RelationKind::parallel || kind == RelationKind::orthogonal; }

struct FaceRelation {
  RelationKind kind = RelationKind::parallel;
  std::uint32_t first = 0, second = 0;  ///< faces
  double value = 0;                     ///< what is zero if it holds: rad of directions, mm of all else
  double sigma = 0;                     ///< of the value, along each direction that it is free in
  double z = 0;                         ///< value / sigma
  /// z lies within what chance exceeds once in a hundred (2.58; 3.03 of values free in two directions), and no face
  /// has to move by more than a quarter of the tolerance for the relation to hold.
  bool accepted = false;
};

/// By kind. Not of all pairs: a face stands beside the largest of those that it is parallel to, coaxial, coplanar or
/// equal with, and is orthogonal through that one; tangent are neighbours only. What comes near and is refused is in
/// the list, not accepted, of each face up to three of a kind. Sigmas are at least 1/200 of the tolerance, so that
/// exact meshes are tested as well.
std::vector<FaceRelation> relations_between(const Faces& faces, double tolerance);

}  // namespace partscribe::fit
