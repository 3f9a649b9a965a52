/// One self-contained HTML page that says what was found, how well it fits and why.
#pragma once

#include <string>
#include <vector>

#include "cli/pictures.h"

namespace partscribe {

struct ReportInput {
  const Model& model;
  const Verdict& verdict;
  const PointCloud& cloud;
  const std::vector<ReportPicture>& pictures;
  std::string script_name;  ///< of the procedure shown at the end; empty: none
  std::string script;
  std::vector<std::string> warnings;  ///< of the reader
};

/// Needs no network, prints well, stays readable without pictures. The same input gives the same bytes.
std::string report_page(const ReportInput& input);

/// `text` with the characters that HTML reserves replaced.
std::string escaped(const std::string& text);

/// RFC 4648, with padding.
std::string base64(const std::string& bytes);

}  // namespace partscribe
