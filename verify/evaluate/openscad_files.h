/// Which files an OpenSCAD script may read.
#pragma once

#include <vector>

#include "core/files.h"

namespace partscribe::verify {

/// The script, and the files in its folder and below (core/lies_within.h) that it names: in use <...>, include <...>
/// and strings, relative to the file that names them, which are scripts that are read in turn, or to the script itself.
/// A name that is only put together while the script runs is not seen.
std::vector<Path> files_of_script(const Path& script);

}  // namespace partscribe::verify
