#include "cli/paper/paper_page.h"

#include "cli/report/report_html.h"

namespace partscribe::cli {
namespace {

constexpr const char* paper_introduction =
    "Figures 2 to 14 and tables 1 and 2 of Koivunen, Vezien and Bajcsy, Multiple representation approach to geometric "
    "model construction from range data (1993), made by this program. The range images of the face mask and of the "
    "hand are lost: sculpted reliefs stand in for them, and their figures are not to be compared with the printed "
    "ones.";

constexpr const char* paper_style =
    "body{font:16px/1.5 sans-serif;max-width:66rem;margin:2rem auto;padding:0 1rem;color:#141820}"
    "img{max-width:100%;margin:.4rem .4rem 0 0}table{border-collapse:collapse;margin:.6rem 0}"
    "td,th{border-bottom:1px solid #d7dae0;padding:.2rem .8rem .2rem 0;text-align:left}"
    "pre{background:#f4f5f8;padding:1rem;overflow-x:auto;font-size:13px}caption{text-align:left;color:#5a606c}";

}  // namespace

std::string paper_html(const std::vector<PaperFigure>& figures, const std::string& version) {
  std::string text =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>The 1993 paper, by "
      "partscribe</title><style>" +
      std::string(paper_style) + "</style></head><body>\n<h1>The 1993 paper, made by partscribe " + escaped(version) +
      "</h1>\n<p>" + escaped(paper_introduction) + "</p>\n";
  for (const auto& figure : figures) {
    text += "<section><h2>" + escaped(figure.title) + "</h2>\n<p>" + typeset(figure.text) + "</p>\n";
    if (figure.table.size() > 1) {
      HtmlTable table("", figure.table.front());
      for (std::size_t row = 1; row < figure.table.size(); ++row) table.row(figure.table[row]);
      text += table.done();
    }
    for (const auto& picture : figure.pictures)
      text += "<img alt=\"" + escaped(picture.description) + "\" src=\"data:image/png;base64," + base64(picture.png) +
              "\">\n";
    if (!figure.listing.empty()) text += "<pre>" + escaped(figure.listing) + "</pre>\n";
    text += "</section>\n";
  }
  return text + "</body></html>\n";
}

std::string paper_markdown(const std::vector<PaperFigure>& figures, const std::string& version) {
  std::string text = "# The 1993 paper, made by partscribe " + version + "\n\n" + paper_introduction + "\n";
  const auto row_of = [](const std::vector<std::string>& cells) {
    std::string row = "|";
    for (const auto& cell : cells) row += " " + cell + " |";
    return row + "\n";
  };
  for (const auto& figure : figures) {
    text += "\n## " + figure.title + "\n\n" + figure.text + "\n";
    if (figure.table.size() > 1) {
      text +=
          "\n" + row_of(figure.table.front()) + row_of(std::vector<std::string>(figure.table.front().size(), "---"));
      for (std::size_t row = 1; row < figure.table.size(); ++row) text += row_of(figure.table[row]);
    }
    if (!figure.pictures.empty()) text += "\n";
    for (const auto& picture : figure.pictures) text += "![" + picture.description + "](" + picture.file + ")\n";
    if (!figure.listing.empty()) text += "\n```\n" + figure.listing + "```\n";
  }
  return text;
}

}  // namespace partscribe::cli
