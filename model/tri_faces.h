/// The faces of a triangulated body as geometry knows them.
#pragma once

#include <optional>

#include "geometry/segment/faces.h"
#include "model/shapes.h"

namespace partscribe::model {

/// The surface that a face lies on; nothing of free form, or where its numbers are not those of its kind.
std::optional<Primitive> surface_of(const TriFace& face);

/// The face of a body with this name, of so many triangles.
TriFace tri_face(const Face& face, std::string name, std::size_t triangles);

/// Which face each triangle belongs to; empty if the body has no faces.
std::vector<std::uint32_t> faces_of_triangles(const TriSurfaceOf<double>& surface);

/// mm: how far the triangles lie off the surfaces that they stand for, at their middles and along their edges.
double facet_depth(const TriSurfaceOf<double>& surface);

}  // namespace partscribe::model
