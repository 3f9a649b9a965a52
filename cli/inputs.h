/// What commands share before the work: names, folders, units, the tolerance nobody gave.
#pragma once

#include <string>
#include <vector>

#include "cli/session.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/points/point_cloud.h"
#include "model/check.h"
#include "scan/read/read.h"

namespace partscribe::cli {

/// What may not be looked at, or whose name cannot be one, is neither.
bool is_file(const Path& path);
bool is_folder(const Path& path);

/// --out, or the folder of a file that an earlier stage wrote, or `<name>-partscribe` in the current folder, named
/// after the second file.
Path output_folder(const SharedOptions& options, const Path& input, const Path& named_after);

/// A usage error if a folder that only the name of `inputs` led to holds a model made from other files: --force
/// replaces older results of the same part, and no other's.
Result<Done> check_same_part(const SharedOptions& options, const Path& folder, const std::vector<Path>& inputs);

/// A usage error if the folder holds one of `files` and --force was not given; asked before the long work.
Result<Done> check_overwriting(const Path& folder, const std::vector<std::string>& files, bool force);

/// The same for a single file named by the user. One of `inputs` is not overwritten, not even by force.
Result<Done> check_overwriting(const Path& file, bool force, const std::vector<Path>& inputs);

/// Made only when there is something to put in, so that a bad input leaves no empty folder.
Result<Done> make_folder(const Path& folder);

/// read_scan with the units that were asked for; its warnings are printed.
Result<Scan> read_scans(const std::vector<Path>& inputs, Session& session, ReadOptions options = {},
                        std::vector<RangeImage>* images = nullptr);

/// Of a model.json, or of the folder that holds one.
Result<CheckedModel> read_model(const Path& given);

/// The tolerance used when none was given.
struct ChosenTolerance {
  double tolerance = 0;  ///< mm
  double noise = 0;      ///< mm, measured on a sample of patches; 0 if the tolerance was given
  std::string reason;    ///< one line for the user
};

/// --tolerance, or five times the noise of the scan but at least a thousandth of its diagonal (outliers
/// aside), rounded up. Five, because a fit judged at twice the local noise is still an honest verdict.
ChosenTolerance tolerance_for(const Scan& scan, Session& session);

}  // namespace partscribe::cli
