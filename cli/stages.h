/// The stages that `build` runs one after the other and that other commands run alone.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/session.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/point_cloud.h"
#include "model/check.h"
#include "verify/verify.h"

namespace partscribe {

/// What the user may say about the fit.
struct FitArguments {
  std::string name;  ///< of the part; empty: from the input file
  bool no_nominal = false;
  std::string procedure;  ///< only this one; empty: the best
};

/// build_model with the program's version and options in the provenance.
Result<CheckedModel> fit_stage(Scan& scan, double tolerance, const std::string& name, const FitArguments& arguments,
                               Session& session);

/// The backends of --to in the program's order; empty names all. An unknown one is a usage error.
Result<std::vector<std::string>> chosen_backends(const std::vector<std::string>& names);

/// The names of all files that emitting may write: what must not be overwritten, and what --force removes.
std::vector<std::string> artifact_names();

/// Writes the artifacts into `folder`; returns the files to run, in the order of the backends. Files that an earlier
/// run left for other backends are removed, so that all files of a folder belong together.
Result<std::vector<Path>> emit_stage(const CheckedModel& model, const std::vector<std::string>& backends,
                                     const Path& templates, const Path& folder, Session& session);

/// Where each stage's seconds went, in one line.
std::string seconds_line(const Session& session);

/// {"files": [...], ...}: what commands without a verdict print with --json.
std::string summary_json(const std::string& command, const std::vector<Path>& files,
                         const std::vector<std::string>& warnings);

}  // namespace partscribe
