/// The small pieces of HTML that a report is made of.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace partscribe::cli {

/// `text` with the characters that HTML reserves replaced.
std::string escaped(std::string_view text);

/// The same for a sentence, with a real plus-minus and a raised 2 where plain text has "+-" and "mm2".
std::string typeset(std::string text);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

/// "'sha256-...'": a script of this text, as a Content-Security-Policy allows it.
std::string policy_hash(const std::string& script);

/// "12.5 %", with one decimal; "-" of nothing. A share that is not zero never reads "0 %".
std::string percent(double part, double whole);

/// A whole number with a comma after every three digits.
std::string grouped(std::size_t number);

/// A table with a caption. A heading that ends in "#" belongs to a column of numbers.
class HtmlTable {
 public:
  HtmlTable(std::string_view caption, const std::vector<std::string>& headings, std::string_view css_class = {});
  /// The first cell names the row. Cells are text.
  void row(const std::vector<std::string>& cells);
  /// The same with cells that are HTML already, and attributes of the row.
  void html_row(const std::vector<std::string>& cells, const std::string& attributes = {});
  std::size_t rows() const { return rows_; }
  std::string done() const;

 private:
  std::string caption_, text_;
  std::vector<bool> numeric_;
  std::size_t rows_ = 0;
};

std::string html_list(const std::vector<std::string>& lines);

}  // namespace partscribe::cli
