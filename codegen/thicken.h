/// What an open triangulated sheet needs to become a solid: where its boundary runs, which way each corner moves.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::codegen {

/// Per vertex the direction by which all adjoining triangles move outward by about 1 when the vertex moves by it
/// (the miter of their planes; at sharp corners no longer than 2). A sheet too rough for that, whose back would fold at
/// this thickness, or too strongly bent, so that its back would come to lie in front of it, moves in one common unit
/// direction that nearly all triangles face, if there is one: its back is then its front once more, and cannot cross
/// anything.
std::vector<Vec3> sheet_normals(const std::vector<std::array<double, 3>>& vertices,
                                const std::vector<std::array<std::uint32_t, 3>>& triangles, double thickness);

/// Directed edges with one triangle, as the triangle runs through them, in order of the triangles.
std::vector<std::pair<std::uint32_t, std::uint32_t>> sheet_rim(
    const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace partscribe::codegen
