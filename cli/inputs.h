/// What commands share before the work: names, folders, units, the tolerance nobody gave.
#pragma once

#include <string>
#include <vector>

#include "cli/session.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/point_cloud.h"
#include "model/check.h"
#include "scan/read.h"

namespace partscribe {

/// A part's name made from an input file: "Pump cover (2).ply" is pump_cover_2. Files whose own name says nothing
/// (cloud, scan, merged, model) take their folder's.
std::string part_name(const Path& input);

/// --out, or the folder of a file that an earlier stage wrote, or `<name>-partscribe` in the current folder.
Path output_folder(const SharedOptions& options, const Path& input, const std::string& name);

/// A usage error if the folder holds one of `files` and --force was not given; asked before the long work.
Result<Done> check_overwriting(const Path& folder, const std::vector<std::string>& files, bool force);

/// The same for a single file named by the user.
Result<Done> check_overwriting(const Path& file, bool force);

/// Made only when there is something to put in, so that a bad input leaves no empty folder.
Result<Done> make_folder(const Path& folder);

/// read_scan with the units that were asked for; its warnings are printed.
Result<Scan> read_scans(const std::vector<Path>& inputs, Session& session, ReadOptions options = {},
                        std::vector<RangeImage>* images = nullptr);

Result<CheckedModel> read_model(const Path& file);

/// The tolerance used when none was given.
struct ChosenTolerance {
  double tolerance = 0;  ///< mm
  double noise = 0;      ///< mm, measured on a sample of patches; 0 if the tolerance was given
  std::string reason;    ///< one line for the user
};

/// --tolerance, or five times the noise of the scan but at least a thousandth of its diagonal (stray points
/// aside), rounded up. Five, because a fit judged at twice the local noise is still an honest verdict.
ChosenTolerance tolerance_for(const Scan& scan, Session& session);

}  // namespace partscribe
