/// Runs a .scad file by OpenSCAD.
#pragma once

#include "verify/evaluate/evaluate.h"

namespace partscribe::verify {

/// Binary STL out, warnings are faults, and the result must bound a solid. The script reads
/// nothing but the files of openscad_files.h and the program's own libraries.
Result<Evaluation> evaluate_openscad(const Path& path, const EvaluateOptions& options, Context& context);

/// Where OpenSCAD looks for libraries and fonts beside the system's own places.
std::vector<Path> openscad_folders();

/// "2021.01". Errors: as run_process.
Result<std::string> openscad_version(const EvaluateOptions& options, Context& context);

/// How to draw the circles of a script with `sides` sides.
std::string finer_openscad(int sides);

}  // namespace partscribe::verify
