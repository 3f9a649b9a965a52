/// Recognises on an evaluated mesh the features that people name: faces, holes, bosses, fillets, cones, spheres, tori.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"
#include "geometry/segment/faces.h"

namespace partscribe::verify {

/// A connected patch of surface of one kind.
struct MeshFeature {
  std::string name;  ///< "hole 3", "face +z at 10"; unique
  std::string kind;  ///< "plane", "hole", "boss", "fillet", "round", "cylinder", "cone", "sphere", "torus",
                     ///< "free surface", "small faces"
  std::optional<Primitive> primitive;  ///< the surface through the corners; round ones of polygons too
  bool hollow = false;                 ///< of round kinds: the material lies outside
  bool tangent = false;                ///< runs smoothly into its neighbours
  double area = 0;                     ///< mm^2
  double arc = 0;                      ///< rad about the axis that it covers
  double low = 0, high = 0;            ///< mm, along the axis from the primitive's point
  double sagitta = 0;                  ///< mm, how far its flat facets lie inside the true surface
  Vec3 middle = Vec3::Zero();          ///< centre of area; of what has an axis or centre, the place on it
  std::vector<std::uint32_t> triangles;
};

struct MeshFeatures {
  std::vector<MeshFeature> features;      ///< planes first, then holes, bosses, ...; larger ones first
  std::vector<std::uint32_t> feature_of;  ///< of each triangle
};

/// Facets of a polygon are one round surface if at least eight would close the circle; four to seven equal walls are a
/// square to a heptagon unless `is_round` knows better. Corners must be shared. `tolerance` decides what is too small
/// to be named.
MeshFeatures recognise_features(const TriangleMesh& mesh, double tolerance, const IsRound& is_round = {});

/// How many flat sides the circle of a cylinder is drawn with; 0 if it has none to speak of, or is no cylinder.
int sides_of(const MeshFeature& feature);

}  // namespace partscribe::verify
