/// The still pictures of a report: the deviation from all sides, the scan, the model, and each finding from near by.
#pragma once

#include <string>
#include <vector>

#include "cli/pictures/raster.h"
#include "cli/report/report_scene.h"

namespace partscribe::cli {

struct ReportPicture {
  std::string name;         ///< of the file: "deviation.png", "front.png", "finding-1.png"
  std::string title;        ///< "Deviation, from the front"
  std::string description;  ///< what a person who cannot see it should know
  int width = 0, height = 0;
  std::string png;
};

enum class Drawn { deviation, model, scan };

/// One picture of a scene: `deviation` and `model` need the geometry of an artifact. Its name is the view's.
ReportPicture draw_view(const ReportScene& scene, Drawn what, const ReportView& view, int width_px, int height_px,
                        int threads);

/// The first `most` findings get pictures of their own; they are in the order of importance.
inline constexpr std::size_t most_finding_pictures = 6;

/// Overview, scan, model, six sides, findings. Left out: what needs the geometry of an artifact, if none ran.
std::vector<ReportPicture> draw_report(const ReportScene& scene, Context& context);

}  // namespace partscribe::cli
