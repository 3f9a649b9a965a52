/// From a scan to a verified model, in memory and in a folder: `build` without its words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/commands/stages.h"
#include "cli/commands/views.h"
#include "cli/commands/wider.h"
#include "cli/pictures/pictures.h"
#include "cli/result_folder.h"

namespace partscribe::cli {

/// What a build is to make of its scan.
struct BuildRequest {
  std::string name;                   ///< of the part, as models call it
  double tolerance = 0;               ///< mm
  std::vector<std::string> backends;  ///< in the program's order
  Path templates;                     ///< empty: the built-in ones
  FitArguments fit;
};

/// A model, written and judged.
struct Trial {
  std::string model;  ///< its model.json
  std::string procedure;
  Emitted emitted;
  Verdict verdict;
};

struct BuiltPart {
  CheckedModel model;
  std::vector<Trial> tried;  ///< all models that the fit offered
  std::size_t answer = 0;    ///< which of them is `model`

  const Trial& trial() const { return tried[answer]; }
};

/// Fits, writes and judges. Every model that the fit offers is written, run and judged before it becomes the answer.
/// The scan's cloud gets normals, noise and outlier flags.
Result<BuiltPart> build_part(Scan& scan, const BuildRequest& request, Session& session);

/// A procedure and the tolerance at which this very build would verify it, where nothing is verified now or all that is
/// is a triangulation. `as_read`: the scan's points as they were before the fit.
Result<std::optional<Wider>> wider_procedure(const BuiltPart& built, const Scan& scan, const PointCloud& as_read,
                                             const BuildRequest& request, Session& session);

/// The folder of a build.
struct BuildFolder {
  ResultFolder results;
  bool reads_cloud = false;  ///< its cloud.ply is an input and stays
  bool registers = false;    ///< a poses.json is written
};

/// The folder with all that a build of these scans may write; `registers`: their poses are looked for.
BuildFolder build_folder(const Path& folder, const std::vector<Path>& scans, bool registers);

/// Writes the files of a build into a folder that was checked before the work; returns the pictures of its report.
Result<std::vector<ReportPicture>> write_built(const BuiltPart& built, const PlacedViews& placed, BuildFolder& folder,
                                               Session& session);

/// What a build wrote into a folder, the artifacts first.
std::vector<Path> built_files(const Path& folder);

}  // namespace partscribe::cli
