/// Damaged copies of a model, each off by twice the tolerance: what every verifier must refuse. And harmless ones.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/model.h"

namespace partscribe {

/// One damage. A verifier that compares it with a scan of the undamaged part must refuse it, unless it is harmless.
struct Mutation {
  enum class Kind {
    parameter,  ///< a named parameter is wrong
    number,     ///< a number or expression that is no parameter is wrong
    moved,      ///< the part or one of its objects stands in the wrong place
    missing,    ///< a loop, an element of a sketch, a face, an operand is left out
    mirrored,   ///< the wrong hand, or upside down
    scaled,     ///< too large
    harmless,   ///< a parameter is off by a tenth of the tolerance, or a number that no surface depends on by 2 T
  };
  Kind kind = Kind::parameter;
  std::string name;  ///< "radius + 0.2", "without loop 'left bore'", "mirrored in x"
  double moved = 0;  ///< mm; at least 1/200 of the true surface is so far from the damaged one
  Model model;       ///< passes check()
};

/// "parameter", "number", ...
const char* name_of(Mutation::Kind kind);

/// All damages that the model's parts allow, in a fixed order; the signs of changes alternate. Lengths change by
/// 2 T (T: the model's tolerance). Where that moves no surface by 1.5 T, and for angles, ratios, weights and knots, the
/// change is chosen so that the surface moves by 2 T; what cannot be made to move it so far is left out. Mirrors are
/// taken at the middle of the bounding box, scales about it: by 0.5 %, or, where that moves no surface by 1.5 T, by the
/// factor that moves it by 2 T.
std::vector<Mutation> mutations_of(const Model& model);

/// A place on the surface of a part.
struct SurfacePoint {
  Vec3 point;
  Vec3 normal;  ///< unit, outward
};

/// Points where random lines meet the model's surface: as many per area everywhere, inside bores too. In the frame
/// of ModelDistance; the same for the same seed.
std::vector<SurfacePoint> surface_points(const Model& model, std::size_t count, std::uint64_t seed);

}  // namespace partscribe
