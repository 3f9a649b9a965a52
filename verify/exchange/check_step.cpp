#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <vector>

#include "verify/exchange/check_exchange.h"

namespace partscribe::verify {
namespace {

using Id = std::uint64_t;

struct Instance {
  Id id = 0;
  std::vector<Id> refers;
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '!'; }
bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v'; }
std::string name(Id id) { return "#" + std::to_string(id); }

/// Reads what stands between the first word and the last, token by token.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  std::optional<std::string> run(std::vector<Instance>& instances) {
    skip();
    if (!word("ISO-10303-21;")) return "the file does not begin with ISO-10303-21;";
    while (true) {
      skip();
      if (at_ >= text_.size()) return where("the file ends before END-ISO-10303-21;");
      if (word("END-ISO-10303-21;")) return std::nullopt;
      const bool instance = text_[at_] == '#';
      Instance found;
      if (instance) {
        ++at_;
        found.id = digits();
        current_ = found.id;
        skip();
        if (at_ < text_.size() && text_[at_] == '=')
          ++at_;
        else if (at_ < text_.size())
          return where("'=' was expected after " + name(found.id));
      }
      if (auto fault = statement(found)) return fault;
      if (instance) instances.push_back(std::move(found));
    }
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  Id current_ = 0;

  std::string where(const std::string& what) const { return current_ ? what + ", after " + name(current_) : what; }

  void skip() {
    while (at_ < text_.size()) {
      if (is_space(text_[at_])) {
        ++at_;
      } else if (text_.substr(at_, 2) == "/*") {
        const auto end = text_.find("*/", at_ + 2);
        at_ = end == std::string_view::npos ? text_.size() : end + 2;
      } else {
        return;
      }
    }
  }

  bool word(std::string_view expected) {
    if (text_.substr(at_, expected.size()) != expected) return false;
    at_ += expected.size();
    return true;
  }

  Id digits() {
    Id value = 0;
    for (; at_ < text_.size() && is_digit(text_[at_]); ++at_) value = value * 10 + Id(text_[at_] - '0');
    return value;
  }

  /// Up to the semicolon, which is consumed.
  std::optional<std::string> statement(Instance& instance) {
    int depth = 0;
    bool empty_place = true;  // between two commas nothing may be left out
    while (true) {
      skip();
      if (at_ >= text_.size()) return where("the file ends before END-ISO-10303-21;");
      const char c = text_[at_];
      if (c == ';') {
        ++at_;
        if (depth != 0) return where("a parenthesis is not closed");
        return std::nullopt;
      }
      if (c == '(' || c == ')') {
        depth += c == '(' ? 1 : -1;
        if (depth < 0) return where("a parenthesis is closed that was not opened");
        empty_place = c == '(';
        ++at_;
      } else if (c == ',') {
        if (empty_place) return where("a value is missing before a comma");
        empty_place = true;
        ++at_;
      } else {
        empty_place = false;
        if (auto fault = value(instance, depth)) return fault;
      }
    }
  }

  std::optional<std::string> value(Instance& instance, int depth) {
    const char c = text_[at_];
    if (c == '\'' || c == '"') {
      do {  // a doubled quote stands for itself
        const auto end = text_.find(c, at_ + 1);
        if (end == std::string_view::npos) return where("a text is not closed");
        at_ = end + 1;
      } while (at_ < text_.size() && text_[at_] == c);
    } else if (c == '#') {
      ++at_;
      if (at_ >= text_.size() || !is_digit(text_[at_])) return where("a number was expected after '#'");
      instance.refers.push_back(digits());
    } else if (c == '.') {
      const auto end = text_.find('.', at_ + 1);
      if (end == std::string_view::npos) return where("a '.' is not closed");
      at_ = end + 1;
    } else if (c == '$' || c == '*' || c == '=') {
      ++at_;
    } else if (is_letter(c)) {
      const auto begin = at_;
      while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]) || text_[at_] == '-')) ++at_;
      const std::string_view found = text_.substr(begin, at_ - begin);
      skip();
      if (depth > 0 && at_ < text_.size() && text_[at_] != '(')
        return where("'" + std::string(found) + "' stands where a number or an entity was expected");
    } else if (is_digit(c) || c == '-' || c == '+') {
      const auto begin = at_;
      while (at_ < text_.size() &&
             (is_digit(text_[at_]) || std::string_view("+-.Ee").find(text_[at_]) != std::string_view::npos))
        ++at_;
      std::string_view number = text_.substr(begin, at_ - begin);
      if (number[0] == '+') number.remove_prefix(1);
      double parsed = 0;
      const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), parsed);
      const bool tiny = error == std::errc::result_out_of_range && number.find("-", 1) != std::string_view::npos;
      if ((error != std::errc() && !tiny) || (end != number.data() + number.size() && !tiny))
        return where("'" + std::string(number) + "' is no finite number");
    } else {
      return where(std::string("the character '") + c + "' is not expected");
    }
    return std::nullopt;
  }
};

}  // namespace

std::optional<std::string> fault_of_step(std::string_view text) {
  std::vector<Instance> instances;
  if (auto fault = Scanner(text).run(instances)) return fault;
  std::stable_sort(instances.begin(), instances.end(),
                   [](const Instance& a, const Instance& b) { return a.id < b.id; });
  for (std::size_t i = 0; i + 1 < instances.size(); ++i)
    if (instances[i].id == instances[i + 1].id) return name(instances[i].id) + " is defined twice";
  std::vector<std::vector<std::size_t>> refers(instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i)
    for (const Id id : instances[i].refers) {
      const auto at =
          std::lower_bound(instances.begin(), instances.end(), id, [](const Instance& a, Id b) { return a.id < b; });
      if (at == instances.end() || at->id != id)
        return name(instances[i].id) + " refers to " + name(id) + ", which is missing";
      refers[i].push_back(static_cast<std::size_t>(at - instances.begin()));
    }
  // Depth first, without recursion: a chain may be as long as the file.
  std::vector<std::uint8_t> state(instances.size(), 0);  // 1: on the path, 2: done
  std::vector<std::pair<std::size_t, std::size_t>> path;
  for (std::size_t start = 0; start < instances.size(); ++start) {
    if (state[start]) continue;
    path.push_back({start, 0}), state[start] = 1;
    while (!path.empty()) {
      auto& [i, next] = path.back();
      if (next == refers[i].size()) {
        state[i] = 2, path.pop_back();
        continue;
      }
      const std::size_t to = refers[i][next++];
      if (state[to] == 1) return name(instances[to].id) + " refers to itself in a circle";
      if (state[to] == 0) state[to] = 1, path.push_back({to, 0});
    }
  }
  return std::nullopt;
}

}  // namespace partscribe::verify
