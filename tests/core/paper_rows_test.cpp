/// docs/paper.md keeps its word: every claim of the paper has its row, and every test that a row names exists.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/number.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

constexpr int claims = 141;

/// String literals that stand beside each other at `at`, as one; `at` moves behind them.
std::string joined_literals(const std::string& text, std::size_t& at) {
  std::string result;
  while (true) {
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    if (at >= text.size() || text[at] != '"') return result;
    for (++at; at < text.size() && text[at] != '"'; ++at) {
      if (text[at] == '\\') ++at;
      result += text[at];
    }
    ++at;
  }
}

/// The names of the test cases that a file declares at the beginning of a line and ctest runs: with tags like [.speed]
/// they wait for somebody to ask.
std::set<std::string> cases_declared_in(const std::string& source) {
  std::set<std::string> names;
  for (const std::string macro : {"TEST_CASE(", "SCENARIO(", "TEMPLATE_TEST_CASE("})
    for (std::size_t at = source.find(macro); at != std::string::npos; at = source.find(macro, at + 1)) {
      if (at > 0 && source[at - 1] != '\n') continue;
      std::size_t end = at + macro.size();
      const std::string name = joined_literals(source, end);
      std::string tags;
      if (end < source.size() && source[end] == ',') tags = joined_literals(source, ++end);
      const bool asked_for = tags.find("[.") != std::string::npos && tags.find("[.statistics]") == std::string::npos;
      if (!name.empty() && !asked_for) names.insert(name);
    }
  return names;
}

std::set<std::string> all_test_cases() {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(source_file("tests")))
    if (entry.path().extension() == ".cpp") names.merge(cases_declared_in(bytes_of(entry.path())));
  return names;
}

/// One line of a table, without the blanks around its cells.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  for (std::size_t from = 1; from < line.size();) {
    const std::size_t to = std::min(line.find('|', from), line.size());
    std::size_t begin = from, end = to;
    while (begin < end && line[begin] == ' ') ++begin;
    while (end > begin && line[end - 1] == ' ') --end;
    cells.push_back(line.substr(begin, end - begin));
    from = to + 1;
  }
  return cells;
}

/// What stands between single backquotes; nothing if one of them is open.
std::optional<std::vector<std::string>> quoted_in(const std::string& cell) {
  std::vector<std::string> result;
  for (std::size_t at = cell.find('`'); at != std::string::npos; at = cell.find('`', at + 1)) {
    const std::size_t end = cell.find('`', at + 1);
    if (end == std::string::npos) return std::nullopt;
    result.push_back(cell.substr(at + 1, end - at - 1));
    at = end;
  }
  return result;
}

/// Tests that the notes on the paper's own errors name: what is quoted there and has a colon. Lines are joined.
std::vector<std::string> names_in_notes(const std::string& text) {
  const auto begin = std::min(text.find("\n## "), text.size()), end = text.find("\n## ", begin + 1);
  std::istringstream words(text.substr(begin, end - begin));
  std::string joined;
  for (std::string word; words >> word;) joined += (joined.empty() ? "" : " ") + word;
  auto names = quoted_in(joined).value_or(std::vector<std::string>());
  std::erase_if(names, [](const std::string& name) { return name.find(": ") == std::string::npos; });
  return names;
}

/// How a row says that its claim is met, in the words of the head.
const std::array<std::string, 3> standings = {"proven", "open", "not possible"};

std::string standing_of(const std::string& proof) {
  if (proof.starts_with("`")) return standings[0];
  for (const std::string& word : {standings[1], standings[2]})
    if (proof.starts_with(word + ": ") && proof.size() > word.size() + 12) return word;
  return "";
}

/// What is wrong with a text like docs/paper.md, beside tests of these names.
std::vector<std::string> complaints_about_rows(const std::string& text, const std::set<std::string>& tests) {
  std::vector<std::string> complaints;
  std::map<int, int> seen;
  std::map<std::string, int> counted, stated;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("**"))  // the head: "**3 proven, 2 open, 1 not possible**"
      for (const std::string& word : standings)
        if (const auto at = line.find(" " + word); at != std::string::npos) {
          const auto begin = line.find_last_not_of("0123456789", at - 1) + 1;
          stated[word] = static_cast<int>(parse_number(line.substr(begin, at - begin)).value_or(-1));
        }
    if (line.size() < 3 || !line.starts_with("| ") || !std::isdigit(static_cast<unsigned char>(line[2]))) continue;
    const auto cells = cells_of(line);
    const int id = static_cast<int>(parse_number(cells[0]).value_or(0));
    const std::string row = "row " + cells[0] + ": ";
    if (id < 1 || id > claims) complaints.push_back(row + "the claims are 1 to " + std::to_string(claims));
    ++seen[id];
    if (cells.size() != 3) {
      complaints.push_back(row + "expected 3 cells, found " + std::to_string(cells.size()));
      continue;
    }
    if (cells[1].size() < 8) complaints.push_back(row + "says no claim");
    const std::string standing = standing_of(cells[2]);
    if (standing.empty())
      complaints.push_back(row + "names no test, and does not begin with 'open: ' or 'not possible: ' and a reason");
    else
      ++counted[standing];
    const auto names = quoted_in(cells[2]);
    if (!names) complaints.push_back(row + "a backquote is open");
    for (const auto& name : names.value_or(std::vector<std::string>()))
      if (!tests.count(name)) complaints.push_back(row + "no test is called '" + name + "'");
  }
  for (const auto& name : names_in_notes(text))
    if (!tests.count(name)) complaints.push_back("notes: no test is called '" + name + "'");
  for (int id = 1; id <= claims; ++id)
    if (seen[id] != 1)
      complaints.push_back("row " + std::to_string(id) + ": is there " + std::to_string(seen[id]) + " times");
  for (const std::string& word : standings)
    if (!stated.count(word) || stated[word] != counted[word])
      complaints.push_back("head: " + std::to_string(counted[word]) + " rows are " + word + ", it says " +
                           (stated.count(word) ? std::to_string(stated[word]) : "nothing"));
  return complaints;
}

std::string paper_text() { return bytes_of(source_file("docs/paper.md")); }

/// The text with the first `from` behind `after` replaced.
std::string replaced_behind(std::string text, const std::string& after, const std::string& from,
                            const std::string& to) {
  const auto begin = text.find(after);
  REQUIRE(begin != std::string::npos);
  const auto at = text.find(from, begin);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("paper: every claim has one row, and every test that it names is there") {
  for (const auto& complaint : complaints_about_rows(paper_text(), all_test_cases())) FAIL_CHECK(complaint);
}

TEST_CASE("paper: names of tests are read from all their lines, and those that nobody runs do not count") {
  const std::string source =
      "TEST_CASE(\"one: plain\") {\nTEST_CASE(\n    \"two: in \"\n    \"pieces, with \\\"quotes\\\"\", \"[tag]\") {\n"
      "// TEST_CASE(\"three: no code\")\nSCENARIO(\"four: told\") {\nTEST_CASE(\"five: slow\", \"[.speed]\") {\n"
      "TEST_CASE(\"six: many\", \"[.statistics]\") {\nTEMPLATE_TEST_CASE(\"seven: of types\", \"\", int, float) {\n";
  CHECK(cases_declared_in(source) == std::set<std::string>{"one: plain", "two: in pieces, with \"quotes\"",
                                                           "four: told", "six: many", "seven: of types"});
  CHECK(all_test_cases().size() > 900);
}

TEST_CASE("paper: a spoiled copy of the rows is found out") {
  const std::string text = paper_text();
  const auto tests = all_test_cases();
  const auto complained = [&](const std::string& bad_text, const std::string& words) {
    const auto complaints = complaints_about_rows(bad_text, tests);
    for (const auto& c : complaints) UNSCOPED_INFO(c);
    UNSCOPED_INFO("expected: " << words);
    CHECK(std::any_of(complaints.begin(), complaints.end(),
                      [&](const std::string& c) { return c.find(words) != std::string::npos; }));
  };
  const auto row = [&](int id) {
    const auto begin = text.find("\n| " + std::to_string(id) + " |") + 1, end = text.find('\n', begin);
    REQUIRE(begin != 0);
    return text.substr(begin, end + 1 - begin);
  };
  // Two rows that name tests: the first such, and another.
  std::vector<int> proven;
  for (int id = 1; id <= claims; ++id)
    if (standing_of(cells_of(row(id)).at(2)) == standings[0]) proven.push_back(id);
  REQUIRE(proven.size() > 2);
  const int first = proven.front(), other = proven[proven.size() / 2];
  const std::string number = std::to_string(first), another = std::to_string(other);
  complained(replaced_behind(text, "", row(other), ""), "row " + another + ": is there 0 times");
  complained(replaced_behind(text, "", row(other), row(other) + row(other)), "row " + another + ": is there 2 times");
  complained(replaced_behind(text, "", row(other), ""), "rows are proven, it says");
  const std::string name = quoted_in(cells_of(row(first))[2])->front();
  std::string misspelt = name;
  std::swap(misspelt[misspelt.size() / 2], misspelt[misspelt.size() / 2 + 1]);
  misspelt += 's';
  complained(replaced_behind(text, "\n| " + number + " |", name, misspelt),
             "row " + number + ": no test is called '" + misspelt + "'");
  complained(replaced_behind(text, "\n| " + number + " |", "`" + name + "`", name),
             "row " + number + ": names no test");
  complained(replaced_behind(text, "\n| " + number + " |", "`" + name + "`", "`" + name), "row " + number + ": ");
  complained(replaced_behind(text, "\n| " + number + " |", "`" + name + "`", "open: `" + name + "`"),
             "rows are open, it says");
  complained(replaced_behind(text, "", row(other), "| " + another + " | something is claimed | open: |\n"),
             "row " + another + ": names no test, and does not begin");
  complained(replaced_behind(text, "", row(other), "| " + another + " | `a test` |\n"),
             "row " + another + ": expected 3 cells");
  complained(text + "| 142 | what nobody claimed | open: there is no such claim |\n",
             "row 142: the claims are 1 to 141");
  complained(replaced_behind(text, "", "**", "* *"), "it says nothing");
  REQUIRE_FALSE(names_in_notes(text).empty());
  complained(replaced_behind(text, "\n## ", "`superellipsoid: ", "`superellipsoids: "), "notes: no test is called");
}

}  // namespace partscribe::testing
