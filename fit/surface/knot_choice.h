/// Few knots in good places.
#pragma once

#include <utility>
#include <vector>

#include "fit/surface/net_equations.h"

namespace partscribe::fit {

struct KnotChoiceOptions {
  double allowed = 0.1;  ///< mm, of the mean distances that the equations leave
  double averaged = 1;   ///< means of fewer points than that are not looked at
  double fairness = 1e-6;
};

/// The largest mean distance that a surface leaves, mm; means of fewer points than `averaged` are not looked at.
double left_over(const NetEquations& equations, const NurbsSurface& surface, double averaged);

/// A knot inside of a bicubic surface's domain.
struct KnotJump {
  bool along_u;
  double at;
  double jump;  ///< mm, how far the third derivative jumps there, over the shorter span beside it
};
/// Those first that are needed least: where the third derivative does not jump a knot can go.
std::vector<KnotJump> knots_by_jump(const NurbsSurface& surface);

/// Knots of `start`, a surface that keeps what is allowed, in fewer and other places, as the equations' fine knots
/// offer them. First they are dealt out evenly by the fourth root of the fourth derivative, which makes the error the
/// same everywhere (de Boor 1978, chapter XII: newknot), as few as will do; then single ones are taken out as long as
/// the others can be moved so that it is kept.
std::pair<KnotVector, KnotVector> fewest_knots(const NetEquations& equations, const NurbsSurface& start,
                                               const KnotChoiceOptions& options);

}  // namespace partscribe::fit
