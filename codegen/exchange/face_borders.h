/// The curves along which the faces of a triangulated body meet.
#pragma once

#include <cstdint>
#include <vector>

#include "codegen/exchange/brep_faces.h"

namespace partscribe::codegen {

/// A piece of border between two faces, from one corner of the body to the next; a closed one begins and ends at the
/// same corner.
struct BorderCurve {
  std::vector<std::uint32_t> vertices;  ///< at least two
  std::uint32_t left = 0, right = 0;    ///< faces: the left one sees the border counter-clockwise from outside
};

/// A curve as a loop runs along it.
struct BorderUse {
  std::uint32_t curve = 0;
  bool forward = true;
};

struct FaceBorders {
  std::vector<BorderCurve> curves;
  std::vector<std::vector<std::vector<BorderUse>>> loops;  ///< of each face: closed loops, the face on their left
};

/// The mesh must be closed. Each triangle belongs to a face.
FaceBorders face_borders(const FacedBody& body);

}  // namespace partscribe::codegen
