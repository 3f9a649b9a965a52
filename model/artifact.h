/// What a backend delivers: files as bytes, not yet written.
#pragma once

#include <string>
#include <vector>

#include "core/layers.h"

namespace partscribe::model {

struct ArtifactFile {
  std::string name;  ///< "part.scad"
  std::string bytes;
};

/// The first file is the one to run; the others stand beside it (a prelude, a library).
struct Artifact {
  std::string backend;  ///< "openscad"
  std::vector<ArtifactFile> files;
};

}  // namespace partscribe::model
