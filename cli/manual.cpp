#include "cli/manual.h"

#include <functional>
#include <sstream>

namespace partscribe::cli {
namespace {

/// Text that man(7) prints as it is.
std::string man_text(const std::string& text) {
  std::string result;
  if (text.starts_with('.') || text.starts_with('\'')) result = "\\&";
  for (const char c : text) result += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
  return result;
}

/// Each line as it is `shown`; those that begin with two spaces are examples, and stand between `begin` and `end`.
std::string with_examples(const std::string& text, const std::string& begin, const std::string& end,
                          const std::function<std::string(const std::string& line, bool example)>& shown) {
  std::string result;
  std::istringstream lines(text);
  bool example = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  ") != example) {
      example = !example;
      result += example ? begin : end;
    }
    result += shown(example ? line.substr(2) : line, example) + "\n";
  }
  return result + (example ? end : "");
}

std::string man_paragraphs(const std::string& text) {
  return with_examples(text, ".PP\n.in +2n\n.nf\n", ".fi\n.in\n", [](const std::string& line, bool) {
    return line.empty() ? std::string(".PP") : man_text(line);
  });
}

std::string man_list(const std::vector<Declared>& declared) {
  std::string result;
  for (const auto& d : declared) {
    result += ".TP\n";
    result += d.is_option() ? "\\fB" + man_text(d.name) + "\\fR" : "\\fI" + man_text(d.name) + "\\fR";
    if (!d.letter.empty()) result += ", \\fB" + man_text(d.letter) + "\\fR";
    if (!d.value_name.empty()) result += " \\fI" + man_text(d.value_name) + "\\fR";
    result += "\n" + man_text(d.help) + "\n";
  }
  return result;
}

std::string operands_of(const CommandManual& command) {
  std::string result;
  for (const auto& d : command.own)
    if (!d.is_option()) result += " \\fI" + man_text(d.name) + "\\fR" + (d.repeated ? " ..." : "");
  return result;
}

/// Text that Markdown prints as it is, also in the cell of a table.
std::string markdown_text(const std::string& text) {
  std::string result;
  for (const char c : text)
    result += (std::string("\\`*_[]<|").find(c) == std::string::npos ? "" : "\\") + std::string(1, c);
  return result;
}

std::string markdown_paragraphs(const std::string& text) {
  return with_examples(text, "\n```\n", "```\n\n",
                       [](const std::string& line, bool example) { return example ? line : markdown_text(line); });
}

std::string markdown_table(const std::vector<Declared>& declared) {
  std::string result = "| | |\n|---|---|\n";
  for (const auto& d : declared) {
    std::string words = d.name + (d.value_name.empty() ? "" : " " + d.value_name) + (d.repeated ? " ..." : "");
    for (auto bar = words.find('|'); bar != std::string::npos; bar = words.find('|', bar + 2)) words.insert(bar, "\\");
    result += "| `" + words + (d.letter.empty() ? "` | " : "`, `" + d.letter + "` | ") + markdown_text(d.help) + " |\n";
  }
  return result;
}

}  // namespace

std::string command_markdown(const CommandManual& command) {
  std::string usage = "partscribe " + command.name + " [options]";
  for (const auto& d : command.own)
    if (!d.is_option()) usage += " " + d.name + (d.repeated ? "..." : "");
  return "```\n" + usage + "\n```\n\n" + markdown_paragraphs(command.help) + "\n" + markdown_table(command.own);
}

std::string manual_page(const Manual& manual) {
  const std::string first = manual.about.substr(0, manual.about.find(".\n"));
  std::string page = ".\\\" Made by 'partscribe help --man'.\n.TH PARTSCRIBE 1 \"\" \"partscribe " + manual.version +
                     "\" \"User Commands\"\n.nh\n.ad l\n.SH NAME\npartscribe \\- " +
                     man_text(first.substr(first.find(' ') + 1)) + "\n.SH SYNOPSIS\n";
  for (const auto& command : manual.commands)
    page += "\\fBpartscribe " + man_text(command.name) + "\\fR [\\fIoptions\\fR]" + operands_of(command) + "\n.br\n";
  page += "\\fBpartscribe help\\fR [\\fIcommand\\fR]\n.br\n\\fBpartscribe \\-\\-version\\fR\n.SH DESCRIPTION\n" +
          man_paragraphs(manual.about) + ".SH OPTIONS OF EVERY COMMAND\n" + man_list(manual.shared);
  page += ".TP\n\\fB\\-h\\fR, \\fB\\-\\-help\\fR\nexplain the command\n";
  for (const auto& command : manual.commands)
    page += ".SH \"PARTSCRIBE " + man_text(command.name) + "\"\n" + man_text(command.summary) + "\n.PP\n" +
            man_paragraphs(command.help) + man_list(command.own);
  return page + ".SH EXIT STATUS AND HELP\n" + man_paragraphs(manual.ending) + ".SH SEE ALSO\n\\fBopenscad\\fR(1)\n";
}

}  // namespace partscribe::cli
