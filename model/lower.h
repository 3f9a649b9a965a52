/// Shapes said in terms of simpler ones, exactly, for whoever does not know them.
#pragma once

#include <cmath>

#include "core/number.h"
#include "model/shapes.h"

namespace partscribe::model {

/// A fillet as an extrusion: its concave side is an arc where both legs are equal, a quarter of an ellipse otherwise.
template <class N>
ExtrudeOf<N> lowered(const FilletOf<N>& s) {
  LoopOf<N> loop{"outline", {SketchPointOf<N>{N(0), N(0), "base"}}};
  if (s.width == s.height) {
    loop.elements.push_back(SketchArcOf<N>{s.width, s.width, s.width, N(-pi / 2), N(-pi), "fillet", "wall"});
  } else {
    SketchNurbsOf<N> curve;
    curve.degree = 2;
    curve.knots = {0, 0, 0, 1, 1, 1};
    curve.weights = {1, std::sqrt(0.5), 1};
    curve.control = {{{s.width, N(0)}}, {{N(0), N(0)}}, {{N(0), s.height}}};
    curve.name = "fillet", curve.edge = "wall";
    loop.elements.push_back(curve);
  }
  return {{{loop}}, s.length};
}

}  // namespace partscribe::model
