/// Outlines of extrusions of which walls were hidden: lines and circles cut the plane into cells, and what is seen of
/// walls and end faces tells which cells are solid.
#pragma once

#include <vector>

#include "fit/sketch/plane_chain.h"
#include "fit/sketch/sketch_builder.h"

namespace partscribe::fit {

/// What is seen along the direction of a sweep, mm.
struct OutlineData {
  std::vector<PlanePoint> walls;
  std::vector<PlanePoint> rims;  ///< of end faces, where no wall was seen
  std::vector<Vec2> ends;        ///< points of both end faces
  double band = 0;               ///< half the thickness that noise gives a wall
  double spacing = 0;            ///< between neighbouring points of an end face
  bool outward = false;          ///< the walls' normals point out of the part; else nobody knows their sign
};

/// The outer loop first; empty if no closed outline is found.
///
/// Lines and circles are drawn at random from pairs of wall points (RANSAC), then from what is left of the rims. They
/// divide the plane into cells, and each cell is labelled solid or empty, so that the total cost is least. These cost:
/// points of end faces in an empty cell, their absence in a solid one, a border between solid and empty without a wall,
/// and a wall with the same label on both sides. Two primitives that touch are joined in one point.
std::vector<LoopPieces> outline_by_cells(const OutlineData& data);

}  // namespace partscribe::fit
