/// One self-contained HTML page that says what was found, how well it fits and why.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/pictures/pictures.h"
#include "cli/report/report_html.h"
#include "cli/report/report_scene.h"
#include "cli/report/report_sections.h"

namespace partscribe::cli {

struct ReportInput {
  std::string name;                   ///< of the part
  const std::optional<Model>& model;  ///< none: an artifact of unknown origin
  const Verdict& verdict;
  const ReportScene& scene;
  const std::vector<ReportPicture>& pictures;
  std::vector<ReportScript> scripts;  ///< shown at the end, in this order
  std::vector<SourceFile> sources;    ///< of the scan, where no model tells them
  std::vector<std::string> warnings;  ///< of the reader
  std::string version;                ///< of the program
  std::string faces = {};             ///< of the scan (faces_section); empty: nobody measured it
};

/// Needs no network, prints well, stays readable without pictures and scripts. The same input gives the same bytes.
std::string report_page(const ReportInput& input);

}  // namespace partscribe::cli
