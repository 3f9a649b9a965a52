/// The pictures of a report: the scan, the evaluated model and the deviation between them, each from two sides.
#pragma once

#include <string>
#include <vector>

#include "cli/raster.h"
#include "geometry/point_cloud.h"
#include "model/model.h"
#include "verify/verify.h"

namespace partscribe {

struct ReportPicture {
  std::string name;         ///< of the file: "deviation-front.png"
  std::string title;        ///< "Deviation, from the front"
  std::string description;  ///< what a person who cannot see it should know
  int width = 0, height = 0;
  std::string png;
};

/// The colour of a deviation: grey at 0, blue behind the surface, orange in front, magenta beyond the tolerance.
Color deviation_color(double deviation, double tolerance);

/// The artifact whose geometry is drawn: the first that has a mesh; null if none ran.
const ArtifactVerdict* drawn_artifact(const Verdict& verdict);

/// Signed local deviations of all points of the cloud; NaN for rejected points; empty if nothing was judged.
std::vector<float> deviations_of(const PointCloud& cloud, const ArtifactVerdict* artifact);

/// The part stands upright as its procedure has it. Left out: the model and the deviation if no artifact ran.
std::vector<ReportPicture> draw_report(const Model& model, const Verdict& verdict, const PointCloud& cloud);

}  // namespace partscribe
