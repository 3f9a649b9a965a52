#include "cli/report/report_faces.h"

#include <algorithm>

#include "cli/measure/face_words.h"
#include "cli/pictures/face_picture.h"
#include "cli/report/report_html.h"
#include "cli/report/report_sections.h"

namespace partscribe::cli {
namespace {

/// Empty text if there are no rows.
std::string html_of(const TableRows& rows, const std::string& caption) {
  if (rows.size() < 2) return {};
  std::vector<std::string> headings;
  for (const auto& heading : rows.front()) headings.push_back(typeset(heading));
  HtmlTable table(caption, headings);
  const std::size_t shown = std::min(rows.size() - 1, most_rows);
  for (std::size_t i = 1; i <= shown; ++i) table.row(rows[i]);
  const std::size_t left = rows.size() - 1 - shown;
  return table.done() + (left > 0 ? "<p class=\"remark\">" + std::to_string(left) +
                                        " more are in the files of 'partscribe measure'.</p>\n"
                                  : "");
}

std::string paragraphs(const std::string& text) {
  std::string html;
  for (std::size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1)
    html += "<p class=\"remark\">" + typeset(text.substr(begin, text.find('\n', begin) - begin)) + "</p>\n";
  return html;
}

}  // namespace

ReportPicture picture_of_faces(const Scan& scan, const Faces& faces, Context& context) {
  const Raster picture = draw_faces(scan, faces, context);
  return {"faces.png",
          "The faces of the scan, each with its number",
          "The scan from four sides, its " + std::to_string(faces.faces.size()) +
              " faces in colours of their own; the numbers are those of the tables.",
          picture.width,
          picture.height,
          write_png(picture)};
}

std::string faces_section(const MeasuredPart& part, const ReportPicture& picture) {
  return figure_of(picture) + html_of(feature_rows(part), "Features, as measured") +
         html_of(face_rows(part), "Faces, as measured") + html_of(relation_rows(part), "Relations between faces") +
         paragraphs(unclassified_text(part));
}

}  // namespace partscribe::cli
