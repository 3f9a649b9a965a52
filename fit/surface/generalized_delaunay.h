/// Triangulates one view by Generalized Delaunay insertion, coarse to fine, up to a bound along the surface's normals.
#pragma once

#include <cstdint>
#include <vector>

#include "core/context.h"
#include "fit/surface/sample_lattice.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::fit {

// The procedure as a paper of 1993 on CAD models from range images prints it (section 3.1), after the Generalized
// Delaunay Triangulation of k-simplices in n-space with k = 2 and n = 3. height_field.h does the same job faster, and
// for scattered points; this is the yardstick for it, and gives figures that compare with those in print.

struct GeneralizedDelaunayOptions {
  double tolerance = 0.5;    ///< mm along the normal, between every sample and the triangulation
  double longest_chord = 5;  ///< of LatticePicture: what is a step of depth
  int coarsest = 32;         ///< pixels between the first candidates; halved until every pixel is one
};

/// What happened at one resolution.
struct DelaunayLevel {
  int stride = 1;             ///< pixels between candidates
  std::size_t added = 0;      ///< points, without the three of the start
  std::size_t removed = 0;    ///< afterwards, for later ones had made them needless
  std::size_t held_back = 0;  ///< times that a point could not go in without breaking the empty minsphere
};

struct GeneralizedDelaunay {
  TriangleMesh mesh;                     ///< manifold, open, facing the sensor
  std::vector<std::uint32_t> pixels;     ///< of each vertex: row * columns + column
  std::vector<DelaunayLevel> levels;     ///< coarse to fine
  std::size_t forced = 0;                ///< of those added last: points the tolerance needed although they broke edges
  std::size_t broken_edges = 0;          ///< inner edges where a minsphere holds the corner across all the same
  std::size_t samples = 0;               ///< that were seen
  double max_distance = 0;               ///< mm; the largest of covered samples, less than the tolerance
  std::vector<std::uint32_t> uncovered;  ///< pixels of the others: specks and threads that no triangle fits on
};

/// Starts with a triangle at the sample nearest to the centre of gravity; inserts the worst sample among those of a
/// resolution that are as far from the triangulation as the tolerance, or farther. The distance is that along the
/// sample's normal; where the normal passes the triangulation's border by, d(p, T) of the nearest triangle there. A
/// point goes in by where it lies in the picture: 1 triangle becomes 3, the 2 at an edge 4, the one at the border 2,
/// and a point outside is joined to the edges that it sees. Then edges are flipped while that makes minspheres emptier
/// and the picture stays valid. A point that breaks the rule all the same is held back; those that the tolerance cannot
/// do without go in at the very end. After each resolution a point is taken away if its star, cut anew into ears by the
/// same rule, keeps it and all samples of the star within the tolerance and breaks no more edges.
/// The whole convex hull in the picture is triangulated, but only triangles of the surface (LatticePicture::is_surface)
/// count, and make the result: holes and silhouettes' bays stay open, and steps of depth apart.
/// A view without three linked samples gives an empty mesh; so may a cancelled one. Same bytes for the same input.
GeneralizedDelaunay generalized_delaunay(const SampleLattice& lattice, const GeneralizedDelaunayOptions& options,
                                         const Context& context);

}  // namespace partscribe::fit
