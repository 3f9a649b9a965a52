/// Surface sets as tables of an OpenSCAD script: control points to edit, and where the corners of triangles lie.
#pragma once

#include <functional>
#include <string>

#include "codegen/template.h"
#include "model/shapes.h"

namespace partscribe::codegen {

struct OpenscadSurfaces {
  std::string surfaces, corners;  ///< the names of their tables, as lists
  std::string towards;            ///< ", towards = [...]" where a sheet is thickened along one direction
  TemplateList tables;            ///< records of part.scad's `data`
};

/// `fresh` makes a wanted name one that nothing else has; `thickness`, mm, is that of an open sheet.
OpenscadSurfaces openscad_surfaces(const SurfaceSet& set, const std::string& name, double thickness, double tolerance,
                                   const std::function<std::string(std::string)>& fresh);

}  // namespace partscribe::codegen
