/// Round surfaces through the corners of a group of facets.
#pragma once

#include <optional>
#include <vector>

#include "geometry/segment/facets.h"
#include "geometry/surfaces/primitive_fit.h"

namespace partscribe::geometry {

/// A group of facets of one mesh, seen as samples of one smooth surface.
class FacetGroup {
 public:
  FacetGroup(const TriangleMesh& mesh, const Facets& facets, const std::vector<std::uint32_t>& members);

  /// The surface of this kind that all corners lie on within `corner_error` mm and that no facet leaves by more than
  /// its own bend; nothing if there is none. `largest_bend`: rad, between neighbours in the group.
  std::optional<Primitive> fit(PrimitiveKind kind, double corner_error, double largest_bend) const;

  const std::vector<Vec3>& corners() const { return corners_; }  ///< that several facets share; all if they are few
  const std::vector<Vec3>& corner_normals() const { return corner_normals_; }
  double turning() const { return turning_; }  ///< rad, largest angle between the first and another facet's normal

 private:
  const TriangleMesh& mesh_;
  const Facets& facets_;
  std::vector<std::uint32_t> members_;
  std::vector<Vec3> corners_, corner_normals_;  // where several of the facets meet, else all
  std::vector<Vec3> all_corners_, all_normals_;
  double turning_ = 0;

  bool is_bent_along(const Primitive& torus) const;
  std::optional<Primitive> guess(PrimitiveKind kind, const std::vector<Vec3>& corners,
                                 const std::vector<Vec3>& normals) const;
  bool passes(const Primitive& primitive, double corner_error, double largest_bend) const;
};

/// Whether one facet may be part of the surface.
bool facet_fits(const Primitive& primitive, const TriangleMesh& mesh, const Facet& facet, double corner_error,
                double largest_bend);

}  // namespace partscribe::geometry
