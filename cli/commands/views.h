/// Reads several views of a part, filters range images and brings all views into one frame.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/session.h"
#include "core/files.h"
#include "core/result.h"
#include "scan/filter/filter.h"
#include "scan/register/register.h"

namespace partscribe::cli {

/// What the user says of the poses of the views.
struct PoseArguments {
  std::string poses = "given";       ///< given, guess, none, turntable
  std::string method = "symmetric";  ///< symmetric, paper, paper-triangles
  Path fiducials;                    ///< table of reference points; empty: none
  bool correct_depth = false;        ///< of turntables
};

void declare(PoseArguments& poses, Arguments& arguments);

struct PlacedViews {
  Scan scan;
  FilterSummary filter;
  std::optional<Registration> registration;  ///< unless the poses were taken as given
};

/// What the range-image filter does with points, where there are range images.
enum class Points {
  measured,  ///< nothing
  flagged,   ///< marks outliers; places stay as measured, for fits and verdicts
  filtered,
};

/// `form`: of the filter that flags. Views that registration refuses are left out and named. Fails if no two views can
/// be brought together.
Result<PlacedViews> read_views(const std::vector<Path>& inputs, const PoseArguments& poses, Points points,
                               Session& session, RltsForm form = RltsForm::combined);

/// poses.json: where each view stood and how sure that is. `cloud_sha256`: of the cloud.ply that holds their points.
std::string poses_json(const PlacedViews& views, const std::string& cloud_sha256);

}  // namespace partscribe::cli
