/// Turns the pieces of a profile into a sketch whose numbers are named parameters and relations.
#pragma once

#include <string>
#include <vector>

#include "fit/sketch/profile.h"
#include "model/model.h"

namespace partscribe::fit {

struct SketchOptions {
  double tolerance = 0.1;  ///< mm; relations may move an edge by a quarter of it
  bool revolve = false;    ///< x is a radius; x = 0 the axis
};

/// One closed loop to be: its pieces in order, solid on the left.
struct LoopPieces {
  std::vector<ProfileSegment> segments;
  bool axis_to_axis = false;  ///< revolve: starts and ends on the axis
  std::string name;
};

struct BuiltSketch {
  Sketch sketch;
  std::vector<Parameter> parameters;
  Vec2 origin = Vec2::Zero();  ///< of the sketch, in the coordinates of the pieces
};

/// Straight edges within tolerance of a coordinate direction get one level, equal levels are one parameter; arcs
/// tangent to such edges or to the axis get their centre from them (fillets keep just a radius).
BuiltSketch build_sketch(std::vector<LoopPieces> loops, const SketchOptions& options);

}  // namespace partscribe::fit
