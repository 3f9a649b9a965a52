/// The flat pieces of a mesh, and how they meet.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// Connected triangles in one plane.
struct Facet {
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  Vec3 middle = Vec3::Zero();  ///< centre of area
  double area = 0;
  std::vector<std::uint32_t> triangles, vertices;  ///< each in ascending order
};

/// Two facets that share edges.
struct FacetLink {
  std::uint32_t first = 0, second = 0;
  double angle = 0;                          ///< rad, between the normals
  bool convex = true;                        ///< the material is on the inner side of the bend
  double length = 0;                         ///< mm, of all shared edges
  double first_width = 0, second_width = 0;  ///< mm, extent of either facet across the longest shared edge
};

struct Facets {
  std::vector<Facet> facets;            ///< by their largest triangle, largest first
  std::vector<std::uint32_t> facet_of;  ///< of each triangle
  std::vector<FacetLink> links;         ///< by first, then second
};

/// `flatness`: mm, how far a corner may lie off the plane of its facet's largest triangle. Corners must be shared.
Facets flat_pieces(const TriangleMesh& mesh, double flatness);

}  // namespace partscribe::geometry
