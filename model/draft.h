/// Outlines whose pieces all move into the material by the same way: sections of a body with leaning walls.
///
/// Material lies to the left of every loop. Lines stay parallel to themselves, arcs keep their centre and their angles,
/// corners are mitred; so every corner moves along a straight line, and the body between two sections is ruled.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/surfaces/curve2.h"
#include "model/shapes.h"

namespace partscribe::model {

/// How the ends of one curve move for each mm that the outline moves to its left.
struct EndMoves {
  Vec2 start, end;
};

/// For every curve of an outline of lines and arcs, whose arcs are joined tangentially.
std::vector<EndMoves> end_moves(const Outline2& outline);

/// By how much an arc's radius grows for each mm: -1 if it runs counter-clockwise, else 1.
double radius_growth(const Arc2& arc);

/// The outline moved to its left by `by` mm: as many pieces with the same names.
Outline2 moved_inwards(const Outline2& outline, double by);

/// Why an outline cannot be moved by every way between the two (mm, 0 lies between them); nothing if it can. Whether
/// loops meet then is not asked.
std::optional<std::string> fault_of_draft(const Outline2& outline, double at_bottom, double at_top);

}  // namespace partscribe::model
