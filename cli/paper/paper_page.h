/// The figures of the 1993 paper as one HTML and one Markdown page.
#pragma once

#include <string>
#include <vector>

#include "cli/paper/paper_figure.h"

namespace partscribe::cli {

/// Self-contained, pictures inside.
std::string paper_html(const std::vector<PaperFigure>& figures, const std::string& version);

/// Refers to the pictures as files beside it.
std::string paper_markdown(const std::vector<PaperFigure>& figures, const std::string& version);

}  // namespace partscribe::cli
