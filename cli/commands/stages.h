/// The stages that `build` runs one after the other and that other commands run alone.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/measure/measured_part.h"
#include "cli/pictures/pictures.h"
#include "cli/session.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/points/point_cloud.h"
#include "model/artifact.h"
#include "model/check.h"
#include "verify/verify.h"

namespace partscribe::cli {

/// What the user may say about the fit.
struct FitArguments {
  std::string name;  ///< of the part; empty: from the input file
  bool no_nominal = false;
  std::string procedure;  ///< only this one; empty: the best
};

/// --procedure, which takes the names of procedures only.
void declare_procedure(FitArguments& arguments, Arguments& options);

/// Says why a model is none, or nothing (BuildOptions::refusal).
using Refusal = std::function<Result<std::string>(const CheckedModel&)>;

/// build_model with the program's version and options in the provenance.
Result<CheckedModel> fit_stage(Scan& scan, double tolerance, const std::string& name, const FitArguments& arguments,
                               Session& session, const Refusal& refusal = {});

/// The faces of a scan with what follows from them; its cloud gets normals, noise and flags.
Result<MeasuredPart> measure_stage(Scan& scan, double tolerance, Session& session);

/// --to, a list of backends.
void declare_backends(std::vector<std::string>& names, Arguments& options);

/// The backends of --to in the program's order; empty names all. An unknown one is a usage error.
Result<std::vector<std::string>> chosen_backends(const std::vector<std::string>& names);

/// The names of all files that emitting may write.
std::vector<std::string> artifact_names();

/// What was said of artifacts and does not hold of others.
inline const std::vector<std::string> judgement_names = {"verdict.json", "report.html"};

/// A file that could not be written, because its format has no such body.
struct Unwritten {
  std::string file, backend, reason;
};

/// What became of a model in the formats that were asked for.
struct Emitted {
  std::vector<Artifact> artifacts;  ///< in the order of the backends
  std::vector<Unwritten> failures;
};

/// Writes a model for each backend, in memory. An error is the world's (cancelled, templates that cannot be read); that
/// a format has no such body is a failure.
Result<Emitted> emit_all(const CheckedModel& model, const std::vector<std::string>& backends, const Path& templates,
                         Session& session);

/// Writes the artifacts into `folder`; returns the files to run, in the same order. Files that an earlier run left for
/// other backends, and what was said of them, are removed, so that all files of a folder belong together.
Result<std::vector<Path>> write_artifacts(const std::vector<Artifact>& artifacts, const Path& folder);

/// The share of its points that the fit of a model set aside as outliers: so many the verifier may set aside too.
double outlier_rate_of(const Model& model);

/// Warns of each artifact that was not run, because its program is missing or did not finish.
void warn_of_missing(const Verdict& verdict, Session& session);

/// Where each stage's seconds went, in one line.
std::string seconds_line(const Session& session);

/// --pictures, a folder for the pictures of the report.
void declare_pictures(Path& folder, Arguments& options);

/// The files that were written into `folder`, or which of them was there before.
Result<std::vector<Path>> write_pictures(const std::vector<ReportPicture>& pictures, const Path& folder, bool force);

/// {"files": [...], ...}: what commands without a verdict print with --json.
std::string summary_json(const std::string& command, const std::vector<Path>& files,
                         const std::vector<std::string>& warnings);

}  // namespace partscribe::cli
