/// Damaged copies of a model, each off by twice the tolerance: what every verifier must refuse. And harmless ones.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/model.h"

namespace partscribe::verify {

/// One damage. A verifier that compares it with a scan of the undamaged part must refuse it, unless it is harmless.
struct Mutation {
  enum class Kind {
    parameter,        ///< a named parameter is wrong
    number,           ///< a number or expression that is no parameter is wrong
    dented,           ///< a corner of a triangulation is elsewhere
    hole_size,        ///< one hole of several that share a diameter has another one
    part_moved,       ///< the part stands elsewhere
    part_turned,      ///< the part stands askew
    feature_moved,    ///< one of the objects it is combined from stands elsewhere
    feature_turned,   ///< the axis of such an object is tilted
    feature_missing,  ///< a hole, a boss, an operand is left out
    edge_missing,     ///< a fillet, a chamfer, an element of a sketch is left out
    face_missing,     ///< a cut, a triangle is left out
    hole_added,       ///< a hole that the part does not have
    hole_doubled,     ///< a hole stands twice, side by side
    hole_depth,       ///< a through hole is blind, a blind hole goes through
    boss_added,       ///< a boss that the part does not have
    rounded,          ///< a sharp edge of a sketch is round
    tapered,          ///< walls that are parallel run together
    reordered,        ///< two elements of a sketch have changed places
    combined,         ///< added where it should be cut away, or the other way round
    sheet_added,      ///< a thin sheet, lying over the surface or standing on it
    body_doubled,     ///< the part together with a shifted copy of itself
    body_added,       ///< a separate body beside the part
    mirrored,         ///< the wrong hand, or upside down
    scaled,           ///< too large
    harmless,         ///< a parameter is off by a tenth of the tolerance, or a number that no surface depends on by 2 T
  };
  Kind kind = Kind::parameter;
  std::string name;  ///< "radius + 0.2", "without loop 'left bore'", "mirrored in x"
  /// mm; at least 1/200 of the true surface is so far from the damaged one, or added surface from it
  double moved = 0;
  Model model;  ///< passes check()
};

/// "parameter off by 2 T", "hole missing", ...: a row of a table.
const char* name_of(Mutation::Kind kind);

/// True for damages of the part as a whole: its place, hand, size.
bool of_whole_part(Mutation::Kind kind);

/// All damages that the model's parts allow, in a fixed order; the signs of changes alternate. Lengths change by
/// 2 T (T: the model's tolerance). Where that moves no surface by 1.5 T, and for angles, ratios, weights and knots, the
/// change is chosen so that the surface moves by 2 T; what cannot be made to move it so far is left out. Mirrors are
/// taken at the middle of the bounding box, scales about it: by 0.5 %, or, where that moves no surface by 1.5 T, by the
/// factor that moves it by 2 T.
std::vector<Mutation> mutations_of(const Model& model);

/// A place on the surface of a part.
struct PlaceOnPart {
  Vec3 point;
  Vec3 normal;  ///< unit, outward
};

/// Points where random lines meet the model's surface: as many per area everywhere, inside bores too. In the frame
/// of ModelDistance; the same for the same seed.
std::vector<PlaceOnPart> surface_points(const Model& model, std::size_t count, std::uint64_t seed);

/// Where a damaged model differs from the true one.
struct Harm {
  std::vector<std::string> faces;  ///< names as in ModelDistance of the true model; the largest area first
  std::vector<Vec3> places;        ///< on the true surface, then on the damaged one
};

/// Even places of either surface that are farther than `beyond` from the other, and the faces of the true model that
/// are nearest to them; a face with less than a fifth of the places of the first one is a neighbour and left out.
Harm harm_of(const Model& truth, const Model& damaged, double beyond);

}  // namespace partscribe::verify
