/// What a backend is to the rest of the program: one record, made in the backend's own folder.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "model/artifact.h"
#include "model/check.h"

namespace partscribe::codegen {

struct SharedBrep;  // codegen/exchange/brep.h

struct EmitOptions {
  Path templates;             ///< a folder of packs that replaces the built-in ones; empty: built in
  std::string stem = "part";  ///< of the file names
  /// Given: calls for one and the same model build its boundary once for all.
  std::shared_ptr<SharedBrep> brep;
};

/// How the text of a script is told apart, for the report that colours it.
struct Language {
  std::vector<std::string_view> keywords;
  std::string_view line_comment;                ///< what begins a comment up to the end of its line
  std::string_view comment_begin, comment_end;  ///< of a comment over several lines; may be empty
};

struct Backend {
  std::string name;                     ///< "openscad"
  std::string suffix;                   ///< ".scad"
  std::vector<std::string> companions;  ///< files that may stand beside the artifact
  std::string description;              ///< one line for --help
  Language language;                    ///< no keywords: the file is no text to be shown
  Result<Artifact> (*emit)(const CheckedModel& model, const EmitOptions& options, Context& context);
};

}  // namespace partscribe::codegen
