/// The sections of a report as HTML: tables and lists, readable without pictures and without a program.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/pictures/pictures.h"
#include "core/files.h"
#include "model/model.h"
#include "verify/verify.h"

namespace partscribe::cli {

/// A file of the procedure as it was written.
struct ReportScript {
  std::string name, text;
};

/// The texts of those files that are scripts (.scad, .scl).
std::vector<ReportScript> read_scripts(const std::vector<Path>& files);

std::string key_figures(const Verdict& verdict, const std::optional<Model>& model);
/// Faults first, each with its picture if it has one; empty text if there is none.
std::string findings_section(const Verdict& verdict, const std::vector<ReportPicture>& pictures);
std::string features_section(const Verdict& verdict);
std::string artifacts_section(const Verdict& verdict);
std::string parameters_section(const Model& model);
std::string reasons_section(const Model& model);
std::string scripts_section(const std::vector<ReportScript>& scripts);
/// Where the numbers come from: files, options, programs. Without a model only what `sources` says of the scan.
std::string provenance_section(const Verdict& verdict, const std::optional<Model>& model,
                               const std::vector<SourceFile>& sources, const std::vector<std::string>& warnings);

/// A picture with its caption.
std::string figure_of(const ReportPicture& picture, const std::string& css_class = {});

}  // namespace partscribe::cli
