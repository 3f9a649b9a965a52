/// The data of the interactive map: surface, points and findings as small integers, packed for a page.
#pragma once

#include <string>

#include "cli/report/report_scene.h"

namespace partscribe::cli {

struct MapOptions {
  std::size_t most_points = 45000;  ///< times the scene's detail; more show finer detail and make the page larger
};

/// What the map's program reads, and what has to be said about it.
struct MapData {
  std::string json;               ///< one JSON object; empty if there is nothing to show
  std::size_t shown = 0, of = 0;  ///< judged points in the map, and in the scan
  double value_error = 0;         ///< mm by which a left-out point may differ from the shown one that stands for it
  double surface_error = 0;       ///< mm that the drawn surface may lie from the evaluated one
};

MapData map_data(const ReportScene& scene, const MapOptions& options);

}  // namespace partscribe::cli
