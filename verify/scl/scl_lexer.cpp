#include "verify/scl/scl_lexer.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "core/number.h"

namespace partscribe::verify {
namespace {

constexpr std::array<std::string_view, 20> keywords = {
    "and", "const", "commentoutcode", "else",   "quit", "false", "for",  "forcollect", "if",    "include",
    "not", "or",    "procedure",      "return", "seq",  "set",   "true", "unset",      "while", "seqcollect"};

// Longest first, so that "<<" is not read as two "<".
constexpr std::array<std::string_view, 27> symbols = {"!=", "&&", "**", "++", "--", "<=", "==", ">=", "||",
                                                      "$;", "::", "<<", ">>", "!",  ";",  ":",  "(",  ")",
                                                      "{",  "}",  ",",  "+",  "-",  "*",  "/",  "<",  ">"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

std::string quoted(char c) {
  if (c >= 32 && c < 127) return std::string("'") + c + "'";
  return "byte " + std::to_string(static_cast<int>(static_cast<unsigned char>(c)));
}

/// Walks the text and knows the line and column it is at.
struct Reader {
  std::string_view text;
  std::size_t at = 0;
  SclPlace place;

  bool ended() const { return at >= text.size(); }
  char peek(std::size_t ahead = 0) const { return at + ahead < text.size() ? text[at + ahead] : '\0'; }
  void skip(std::size_t count) {
    for (; count > 0 && !ended(); --count, ++at) {
      if (text[at] == '\n')
        ++place.line, place.column = 1;
      else
        ++place.column;
    }
  }
};

}  // namespace

std::string print_place(const std::string& file, SclPlace place) {
  return file + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (auto& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

Result<std::vector<SclToken>> scl_tokens(std::string_view text, const std::string& file) {
  std::vector<SclToken> tokens;
  Reader r{text, 0, {}};
  auto refuse = [&](SclPlace place, const std::string& what) {
    return bad_input(print_place(file, place) + ": " + what);
  };
  for (;;) {
    while (!r.ended()) {
      const char c = r.peek();
      if (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f')
        r.skip(1);
      else if (c == '#')
        while (!r.ended() && r.peek() != '\n') r.skip(1);
      else
        break;
    }
    SclToken token;
    token.place = r.place;
    if (r.ended()) {
      tokens.push_back(token);
      return tokens;
    }
    const std::size_t begin = r.at;
    const char c = r.peek();
    if (is_letter(c)) {
      while (is_letter(r.peek()) || is_digit(r.peek())) r.skip(1);
      token.text = std::string(text.substr(begin, r.at - begin));
      const std::string word = lower_case(token.text);
      token.kind = SclToken::Kind::identifier;
      if (word == "and" || word == "or" || word == "not") {
        token.kind = SclToken::Kind::symbol;
        token.text = word == "and" ? "&&" : word == "or" ? "||" : "!";
      } else if (std::find(keywords.begin(), keywords.end(), word) != keywords.end()) {
        token.kind = SclToken::Kind::keyword;
        token.text = word;
      }
    } else if (is_digit(c) || (c == '.' && is_digit(r.peek(1)))) {
      while (is_digit(r.peek())) r.skip(1);
      bool real = false;
      if (r.peek() == '.') {
        real = true;
        r.skip(1);
        while (is_digit(r.peek())) r.skip(1);
        const char sign = r.peek(1);
        const bool signed_exponent = (sign == '+' || sign == '-') && is_digit(r.peek(2));
        if ((r.peek() == 'e' || r.peek() == 'E') && (is_digit(sign) || signed_exponent)) {
          r.skip(signed_exponent ? 2 : 1);
          while (is_digit(r.peek())) r.skip(1);
        }
      }
      token.text = std::string(text.substr(begin, r.at - begin));
      if (is_letter(r.peek()) || r.peek() == '.')
        return refuse(token.place, "expected a number, found '" + token.text + r.peek() +
                                       "'; a real number needs a point before its exponent, as in 1.0e5");
      if (real) {
        token.kind = SclToken::Kind::real;
        const auto value = parse_number(token.text);
        if (!value) return refuse(token.place, "expected a finite real number, found " + token.text);
        token.real = *value;
      } else {
        token.kind = SclToken::Kind::integer;
        const auto [end, failure] =
            std::from_chars(token.text.data(), token.text.data() + token.text.size(), token.integer);
        if (failure != std::errc() || end != token.text.data() + token.text.size())
          return refuse(token.place, "expected a whole number below 2^63, found " + token.text);
        token.real = static_cast<double>(token.integer);
      }
    } else if (c == '"') {
      const auto close = text.find('"', begin + 1);
      if (close == std::string_view::npos)
        return refuse(token.place, "expected a closing \" of the string, found the end of the file");
      token.kind = SclToken::Kind::string;
      token.text = std::string(text.substr(begin + 1, close - begin - 1));
      r.skip(close + 1 - begin);
    } else {
      const auto rest = text.substr(begin);
      const auto found = std::find_if(symbols.begin(), symbols.end(), [&](auto s) { return rest.starts_with(s); });
      if (found == symbols.end())
        return refuse(token.place, "expected a word, a number or a sign of SCL, found " + quoted(c));
      token.kind = SclToken::Kind::symbol;
      token.text = std::string(*found);
      r.skip(found->size());
    }
    tokens.push_back(std::move(token));
  }
}

}  // namespace partscribe::verify
