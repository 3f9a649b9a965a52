#include "cli/report/report_html.h"

#include <cstdint>
#include <utility>

#include "core/files.h"
#include "core/number.h"

namespace partscribe::cli {

std::string escaped(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (const char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  return result;
}

std::string typeset(std::string text) {
  for (const auto& [plain, fine] :
       {std::pair{"+-", "\xc2\xb1"}, {"+/-", "\xc2\xb1"}, {"mm^2", "mm\xc2\xb2"}, {"mm2", "mm\xc2\xb2"}})
    for (std::size_t at = 0; (at = text.find(plain, at)) != std::string::npos;)
      text.replace(at, std::string(plain).size(), fine);
  return escaped(text);
}

std::string base64(std::string_view bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string policy_hash(const std::string& script) {
  const std::string hex = sha256(script);
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
    bytes += static_cast<char>(value(hex[i]) << 4 | value(hex[i + 1]));
  }
  return "'sha256-" + base64(bytes) + "'";
}

std::string percent(double part, double whole) {
  if (!(whole > 0)) return "-";
  const double share = 100 * part / whole;
  if (share > 0 && share < 0.05) return "under 0.1 %";
  if (share < 100 && share > 99.95) return "over 99.9 %";
  return print_number(snapped(share, 0.1)) + " %";
}

std::string grouped(std::size_t number) {
  std::string text = std::to_string(number);
  for (std::size_t k = text.size(); k > 3; k -= 3) text.insert(k - 3, ",");
  return text;
}

HtmlTable::HtmlTable(std::string_view caption, const std::vector<std::string>& headings, std::string_view css_class)
    : caption_(caption) {
  text_ = "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"" + escaped(caption) + "\"><table" +
          (css_class.empty() ? "" : " class=\"" + std::string(css_class) + "\"") + "><caption>" + escaped(caption) +
          "</caption>\n<thead><tr>";
  for (std::string heading : headings) {
    numeric_.push_back(heading.ends_with('#'));
    if (numeric_.back()) heading.pop_back();
    text_ +=
        std::string("<th scope=\"col\"") + (numeric_.back() ? " class=\"number\">" : ">") + escaped(heading) + "</th>";
  }
  text_ += "</tr></thead>\n<tbody>\n";
}

void HtmlTable::html_row(const std::vector<std::string>& cells, const std::string& attributes) {
  text_ += "<tr" + attributes + ">";
  for (std::size_t k = 0; k < cells.size(); ++k)
    text_ += (k == 0        ? "<th scope=\"row\">"
              : numeric_[k] ? "<td class=\"number\">"
                            : "<td>") +
             cells[k] + (k == 0 ? "</th>" : "</td>");
  text_ += "</tr>\n";
  ++rows_;
}

void HtmlTable::row(const std::vector<std::string>& cells) {
  std::vector<std::string> html;
  for (const auto& cell : cells) html.push_back(escaped(cell));
  html_row(html);
}

std::string HtmlTable::done() const { return text_ + "</tbody></table></div>\n"; }

std::string html_list(const std::vector<std::string>& lines) {
  std::string text = "<ul>\n";
  for (const auto& line : lines) text += "<li>" + escaped(line) + "</li>\n";
  return text + "</ul>\n";
}

}  // namespace partscribe::cli
