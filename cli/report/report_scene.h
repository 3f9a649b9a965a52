/// What a report draws, worked out once: where to look from, the coloured surface, the judged points.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/report/report_surface.h"
#include "model/model.h"

namespace partscribe::cli {

/// A direction to look from, in the scan's frame.
struct ReportView {
  std::string name;   ///< "front"
  std::string words;  ///< "from the front"
  Vec3 to_eye = Vec3(0, 0, 1), up = Vec3(0, 1, 0);
};

/// Refers to the cloud and the verdict it was made from, which must outlive it.
struct ReportScene {
  const PointCloud* cloud = nullptr;
  /// whose geometry is drawn: the first that has some, then `others`; null if none ran
  const ArtifactVerdict* artifact = nullptr;
  double tolerance = 0.1;
  double spacing = 0;                  ///< mm, median distance between scanned points
  std::vector<float> deviations;       ///< per point of the cloud; NaN: set aside; empty: nothing was judged
  std::vector<std::int32_t> features;  ///< per point of the cloud; empty as deviations
  DeviationSurface surface;
  std::vector<ReportView> views;    ///< the most telling one first, then the six sides
  double detail = 1;                ///< share of the vertices and points that a map may show
  std::vector<ReportScene> others;  ///< of the other artifacts that were judged, in their order and with less detail
};

/// With a model the part stands upright as its procedure has it.
ReportScene report_scene(const std::optional<Model>& model, const Verdict& verdict, const PointCloud& cloud,
                         Context& context);

/// Of geometry that nothing was compared with, and of the points of a scan, either of which may be empty.
ReportScene plain_scene(const ArtifactVerdict& geometry, const PointCloud& cloud, const std::optional<Model>& model,
                        Context& context);

/// "iso" (from the front, right and above at equal angles) and the six sides.
const std::vector<std::string>& view_words();

/// The unit vector of "1,-2,0.5"; nothing if the text is none.
std::optional<Vec3> direction_in(const std::string& text);

/// From where one of view_words() says, or from where a direction in the scan's frame points.
ReportView view_named(const std::string& word, const ReportScene& scene);

/// The artifact whose geometry is drawn: the first with a mesh of those that decide the verdict, else of all; null if
/// none ran.
const ArtifactVerdict* drawn_artifact(const Verdict& verdict);

/// Signed local deviations of all points of the cloud; NaN for points that were set aside by a filter or found to be
/// outliers by the verifier; empty if nothing was judged.
std::vector<float> deviations_of(const PointCloud& cloud, const ArtifactVerdict* artifact);

}  // namespace partscribe::cli
