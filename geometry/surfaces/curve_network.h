/// A network of cubic curves with four-sided meshes, filled by Gregory patches that have one tangent plane at each
/// joint.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/result.h"
#include "geometry/surfaces/gregory_patch.h"
#include "geometry/surfaces/trimmed_surface.h"

namespace partscribe::geometry {

/// A cubic Bezier curve between two nodes.
struct NetworkCurve {
  std::uint32_t from = 0, to = 0;
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();  ///< its inner control points, the first next to `from`; mm
};

struct CurveNetwork {
  std::vector<Vec3> nodes;           ///< mm
  std::vector<Vec3> normals;         ///< unit: all curves of a node run out in the plane across it
  std::vector<NetworkCurve> curves;  ///< one between two nodes
  std::vector<std::array<std::uint32_t, 4>>
      faces;  ///< nodes, counter-clockwise seen from outside; any number at a node
};

/// With curves that leave each node in the direction of the other, as far as its tangent plane lets them, as arcs of
/// circles where both ends allow it. Nodes of a face must differ.
CurveNetwork network_through(const std::vector<Vec3>& nodes, const std::vector<Vec3>& normals,
                             const std::vector<std::array<std::uint32_t, 4>>& faces);

/// A patch for each face: u runs from its node 0 to 1, v from 0 to 3; its borders are the curves.
///
/// Along a curve C(t) each patch has tangents k(t) D(t) + h(t) C'(t) across it, with a field D that belongs to the
/// curve (in the planes across the normals at its ends, square to it there, and linear between) and with linear k and h
/// that its neighbouring curves fix (Chiyokura and Kimura 1983). So the patches at both sides have the plane of D and
/// C' in common. Fails where a face has no curve, a curve no length at an end, or leaves the plane of a node.
Result<std::vector<GregoryPatch>> gregory_patches(const CurveNetwork& network);

/// The patches of a network as NURBS that are joined along its curves, which are their edges: what exact boundaries and
/// IGES are written from. `corner_weight` as for rational_bezier(), but larger: no place moves by more than about a
/// millionth of the patch's size, and with 1e-7 to 1e-9, or 1e-13, OpenCASCADE's check refuses the body.
std::vector<TrimmedSurface> trimmed_faces(const CurveNetwork& network, const std::vector<GregoryPatch>& patches,
                                          double corner_weight = 1e-6);

}  // namespace partscribe::geometry
