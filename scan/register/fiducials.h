/// Poses of views from known reference points that several of them show (section 2.1.1 of the 1993 paper).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "scan/register/register.h"

namespace partscribe::scan {

/// A reference point as one view shows it.
struct Fiducial {
  std::size_t view = 0;
  std::string name;           ///< the same in all views that show the point
  Vec3 place = Vec3::Zero();  ///< in the frame of the view, mm
};

/// Rows "view file,name,x,y,z": the file as it is named in `views` (the end of its path is enough), the point, its
/// coordinates in the frame of that view, times `unit` in mm. A first row of words is a heading; lines that are empty
/// or begin with # are left out. Fails on a row that says something else, a file that is none or several of the views,
/// and a point that a view shows twice.
Result<std::vector<Fiducial>> parse_fiducials(std::string_view text, const std::vector<View>& views, double unit);

/// The first view that shows three points is where the others' frame is, at its guess if it has one. Then one view
/// after the other, that which shares most points with those placed before it, is laid over the means of where these
/// show them (best_state). A view that does not share three points that are on no line is refused. Covariances come
/// from how far apart the points are left, and are zero where nothing is left over to tell.
Result<Registration> register_by_fiducials(const std::vector<RegisterView>& views,
                                           const std::vector<Fiducial>& fiducials);

}  // namespace partscribe::scan
