/// Sketches as OpenSCAD polygons and circles.
#pragma once

#include <string>

#include "codegen/openscad/openscad_text.h"
#include "codegen/template.h"

namespace partscribe::codegen {

/// What a script's text calls for: helper functions and the library beside it.
struct OpenscadNeeds {
  bool facets = false, arc = false, on_axis = false, disc = false, bore = false, ball = false, library = false;
};

/// A sketch as script text.
struct OpenscadSketch {
  std::string text;            ///< the module that draws it, after the control points of its NURBS curves
  std::string largest_radius;  ///< an expression for the largest first coordinate of its outline
};

/// A module `name` that draws the sketch; `about_axis`: the first coordinate is a radius.
Result<OpenscadSketch> openscad_sketch(const Sketch& sketch, const std::string& name, bool about_axis,
                                       const OpenscadText& text, const TemplatePack& pack, OpenscadNeeds& needs);

/// The circle that is the whole sketch, if it is one.
const SketchArc* only_circle(const Sketch& sketch, const OpenscadText& text);

/// All loops of a sketch of points and arcs as lists: corners [x, y] and arcs [center, radius, from, to].
std::string openscad_loops(const Sketch& sketch, const OpenscadText& text);

}  // namespace partscribe::codegen
