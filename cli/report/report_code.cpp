#include "cli/report/report_code.h"

#include <algorithm>

#include "cli/report/report_html.h"

namespace partscribe::cli {
namespace {

bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '$'; }
bool digit(char c) { return c >= '0' && c <= '9'; }

bool keyword(std::string_view word, const Language& language) {
  return std::ranges::find(language.keywords, word) != language.keywords.end();
}

/// Where the comment that begins at `at` ends; `at` itself if none does.
std::size_t comment_end(std::string_view code, std::size_t at, const Language& language) {
  const auto begins = [&](std::string_view mark) { return !mark.empty() && code.substr(at, mark.size()) == mark; };
  if (begins(language.line_comment)) return std::min(code.find('\n', at), code.size());
  if (!begins(language.comment_begin)) return at;
  const auto end = code.find(language.comment_end, at + language.comment_begin.size());
  return end == std::string_view::npos ? code.size() : end + language.comment_end.size();
}

}  // namespace

std::string highlighted(std::string_view code, const Language& language) {
  std::string html;
  html.reserve(code.size() * 2);
  auto span = [&](char kind, std::size_t from, std::size_t to) {
    html += std::string("<span class=\"") + kind + "\">" + escaped(code.substr(from, to - from)) + "</span>";
    return to;
  };
  for (std::size_t i = 0; i < code.size();) {
    const char c = code[i];
    if (const auto comment = comment_end(code, i, language); comment > i) {
      i = span('c', i, comment);
    } else if (c == '"') {
      std::size_t end = i + 1;
      while (end < code.size() && code[end] != '"' && code[end] != '\n') end += code[end] == '\\' ? 2 : 1;
      i = span('s', i, std::min(end + 1, code.size()));
    } else if (digit(c) || (c == '.' && i + 1 < code.size() && digit(code[i + 1]))) {
      std::size_t end = i;
      while (end < code.size() && (digit(code[end]) || code[end] == '.' || code[end] == 'e' ||
                                   ((code[end] == '-' || code[end] == '+') && code[end - 1] == 'e')))
        ++end;
      i = span('n', i, end);
    } else if (letter(c)) {
      std::size_t end = i;
      while (end < code.size() && (letter(code[end]) || digit(code[end]))) ++end;
      std::size_t after = end;
      while (after < code.size() && code[after] == ' ') ++after;
      if (keyword(code.substr(i, end - i), language))
        i = span('k', i, end);
      else if (after < code.size() && code[after] == '(')
        i = span('f', i, end);
      else
        html += escaped(code.substr(i, end - i)), i = end;
    } else {
      html += escaped(code.substr(i, 1)), ++i;
    }
  }
  return html;
}

}  // namespace partscribe::cli
