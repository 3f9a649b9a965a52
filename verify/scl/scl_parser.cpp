#include "verify/scl/scl_parser.h"

#include <algorithm>
#include <array>
#include <initializer_list>

namespace partscribe::verify {
namespace {

using Kind = SclNode::Kind;
using Token = SclToken::Kind;

// Deeper nesting than any person writes; a limit so that hostile text cannot overflow the stack.
constexpr int max_nesting = 200;
constexpr int max_chain = 1000;  // a + b + c + ... becomes a tree as deep as it is long

/// Recursive descent over the tokens; stops at the first error.
class Parser {
 public:
  Parser(std::vector<SclToken> tokens, const std::string& file) : tokens_(std::move(tokens)), file_(file) {}

  Result<std::vector<SclNode>> forms() {
    std::vector<SclNode> result;
    while (now().kind != Token::end) {
      auto form = statement();
      if (!form.ok()) return form.error();
      result.push_back(std::move(*form));
    }
    return result;
  }

 private:
  using Parsed = Result<SclNode>;

  const SclToken& now() const { return tokens_[at_]; }
  const SclToken& next() const { return tokens_[std::min(at_ + 1, tokens_.size() - 1)]; }
  void step() {
    if (now().kind != Token::end) ++at_;
  }
  bool symbol(std::string_view s) const { return now().kind == Token::symbol && now().text == s; }
  bool keyword(std::string_view s) const { return now().kind == Token::keyword && now().text == s; }
  bool end_of_statement() const { return symbol(";") || symbol("$;"); }

  std::string found() const {
    switch (now().kind) {
      case Token::end:
        return "the end of the file";
      case Token::string:
        return "the string \"" + now().text.substr(0, 40) + "\"";
      case Token::keyword:
        return "the keyword " + now().text;
      default:
        return "'" + now().text.substr(0, 40) + "'";
    }
  }
  Error refuse(const std::string& expected) const {
    return bad_input(print_place(file_, now().place) + ": expected " + expected + ", found " + found());
  }
  SclNode node(Kind kind) const {
    SclNode n;
    n.kind = kind;
    n.place = now().place;
    return n;
  }

  /// Counts how deep the descent is.
  struct Descent {
    explicit Descent(int& depth) : depth_(++depth) {}
    ~Descent() { --depth_; }
    int& depth_;
  };

  // ---- statements -----------------------------------------------------------------------------------------------

  /// A form at the outermost level or between << and >>.
  Parsed statement() {
    const Descent descent(depth_);
    if (depth_ > max_nesting) return refuse("less than " + std::to_string(max_nesting) + " levels of nesting");
    if (end_of_statement()) {
      auto n = node(Kind::nothing);
      step();
      return n;
    }
    if (symbol("<<")) {
      auto n = node(Kind::block);
      step();
      while (!symbol(">>")) {
        if (now().kind == Token::end) return refuse("'>>'");
        auto child = statement();
        if (!child.ok()) return child;
        n.children.push_back(std::move(*child));
      }
      step();
      return n;
    }
    if (keyword("procedure")) return procedure();
    if (keyword("set") || keyword("unset")) {
      const bool sets = keyword("set");
      auto n = node(sets ? Kind::set : Kind::unset);
      step();
      if (now().kind != Token::identifier) return refuse("the name of a setting");
      n.text = now().text;
      step();
      if (sets) {
        auto value = expression();
        if (!value.ok()) return value;
        n.children.push_back(std::move(*value));
      }
      return ended(std::move(n));
    }
    if (keyword("quit")) {
      auto n = node(Kind::quit);
      step();
      return ended(std::move(n));
    }
    if (keyword("include")) {
      auto n = node(Kind::include);
      step();
      if (now().kind != Token::string) return refuse("the file to include, in quotes");
      n.text = now().text;
      step();
      return ended(std::move(n));
    }
    return member(true);
  }

  Parsed ended(SclNode n) {
    if (!end_of_statement()) return refuse("';'");
    step();
    return n;
  }

  Parsed procedure() {
    auto n = node(Kind::procedure);
    step();
    if (now().kind != Token::identifier) return refuse("the name of the procedure");
    n.text = now().text;
    step();
    if (!symbol("(")) return refuse("'(' before the formal arguments");
    do {
      step();
      if (now().kind != Token::identifier) return refuse("the name of a formal argument");
      n.formals.push_back(now().text);
      step();
    } while (symbol(","));
    if (!symbol(")")) return refuse("',' or ')' after a formal argument");
    step();
    auto body = value_statement();
    if (!body.ok()) return body;
    n.children.push_back(std::move(*body));
    return n;
  }

  /// What may stand between braces: a value statement, with or without a label.
  Parsed member(bool outermost) {
    if (now().kind == Token::identifier && next().kind == Token::symbol && next().text == ":") {
      auto n = node(Kind::labelled);
      n.text = now().text;
      step();
      step();
      auto value = value_statement();
      if (!value.ok()) return value;
      n.children.push_back(std::move(*value));
      return n;
    }
    if (!outermost && end_of_statement()) return refuse("a statement (none may be empty between braces)");
    return value_statement();
  }

  Parsed value_statement() {
    const Descent descent(depth_);
    if (depth_ > max_nesting) return refuse("less than " + std::to_string(max_nesting) + " levels of nesting");
    if (symbol("{")) return braces(Kind::sequence);
    if (keyword("seq") || keyword("seqcollect")) {
      const Kind kind = keyword("seq") ? Kind::sequence : Kind::collected;
      step();
      if (!symbol("{")) return refuse("'{'");
      return braces(kind);
    }
    if (keyword("while")) return while_loop();
    if (keyword("if")) return choice();
    if (keyword("for") || keyword("forcollect")) return for_loop();
    if (keyword("return")) {
      auto n = node(Kind::returned);
      step();
      auto value = expression();
      if (!value.ok()) return value;
      n.children.push_back(std::move(*value));
      return ended(std::move(n));
    }
    if (keyword("commentoutcode")) {
      auto n = node(Kind::commented_out);
      step();
      auto child = statement();
      if (!child.ok()) return child;
      return n;
    }
    for (const auto word : {"procedure", "set", "unset", "quit", "include"})
      if (keyword(word)) return refuse("a value (" + std::string(word) + " stands at the outermost level only)");
    auto n = node(Kind::expression);
    auto value = expression();
    if (!value.ok()) return value;
    n.children.push_back(std::move(*value));
    return ended(std::move(n));
  }

  Parsed braces(Kind kind) {
    auto n = node(kind);
    step();
    if (symbol("}")) return refuse("at least one statement between the braces");
    while (!symbol("}")) {
      if (now().kind == Token::end) return refuse("'}'");
      auto child = member(false);
      if (!child.ok()) return child;
      n.children.push_back(std::move(*child));
    }
    step();
    return n;
  }

  Parsed in_parentheses() {
    if (!symbol("(")) return refuse("'('");
    step();
    auto value = expression();
    if (!value.ok()) return value;
    if (!symbol(")")) return refuse("')'");
    step();
    return value;
  }

  Parsed while_loop() {
    auto n = node(Kind::while_loop);
    step();
    auto condition = in_parentheses();
    if (!condition.ok()) return condition;
    auto body = value_statement();
    if (!body.ok()) return body;
    n.children.push_back(std::move(*condition));
    n.children.push_back(std::move(*body));
    return n;
  }

  Parsed choice() {
    auto n = node(Kind::choice);
    step();
    auto condition = in_parentheses();
    if (!condition.ok()) return condition;
    n.children.push_back(std::move(*condition));
    auto first = value_statement();
    if (!first.ok()) return first;
    n.children.push_back(std::move(*first));
    if (!keyword("else")) return refuse("else (no if without it)");
    step();
    auto second = value_statement();
    if (!second.ok()) return second;
    n.children.push_back(std::move(*second));
    return n;
  }

  Parsed for_loop() {
    auto n = node(keyword("for") ? Kind::for_loop : Kind::for_collected);
    step();
    if (!symbol("(")) return refuse("'('");
    step();
    if (now().kind != Token::identifier) return refuse("the name of the index");
    n.text = now().text;
    step();
    for (int part = 0; part < 3; ++part) {
      if (!end_of_statement()) return refuse("';'");
      step();
      auto value = expression();
      if (!value.ok()) return value;
      n.children.push_back(std::move(*value));
    }
    if (!symbol(")")) return refuse("')'");
    step();
    auto body = value_statement();
    if (!body.ok()) return body;
    n.children.push_back(std::move(*body));
    return n;
  }

  // ---- expressions ----------------------------------------------------------------------------------------------

  Parsed expression() { return binary(0); }

  /// Operators of one strength, weakest first, all from left to right.
  Parsed binary(std::size_t level) {
    static const std::array<std::vector<std::string_view>, 6> levels = {
        {{"||"}, {"&&"}, {"==", "!="}, {"<", "<=", ">", ">="}, {"+", "-"}, {"*", "/"}}};
    if (level == levels.size()) return unary();
    auto left = binary(level + 1);
    if (!left.ok()) return left;
    for (int chained = 0;; ++chained) {
      if (chained > max_chain) return refuse("at most " + std::to_string(max_chain) + " operators in a row");
      if (symbol("++") || symbol("--") || symbol("::")) return refuse("an operator whose meaning is documented");
      std::string_view op;
      for (const auto s : levels[level])
        if (symbol(s)) op = s;
      if (op.empty()) return left;
      auto n = node(Kind::binary);
      n.text = std::string(op);
      step();
      auto right = binary(level + 1);
      if (!right.ok()) return right;
      n.children.push_back(std::move(*left));
      n.children.push_back(std::move(*right));
      left = std::move(n);
    }
  }

  Parsed unary() {
    const Descent descent(depth_);
    if (depth_ > max_nesting) return refuse("less than " + std::to_string(max_nesting) + " levels of nesting");
    if (symbol("-") || symbol("!")) {
      auto n = node(symbol("-") ? Kind::negate : Kind::negation);
      step();
      auto child = unary();
      if (!child.ok()) return child;
      n.children.push_back(std::move(*child));
      return n;
    }
    auto base = primary();
    if (!base.ok() || !symbol("**")) return base;
    auto n = node(Kind::binary);
    n.text = "**";
    step();
    auto exponent = unary();
    if (!exponent.ok()) return exponent;
    n.children.push_back(std::move(*base));
    n.children.push_back(std::move(*exponent));
    return n;
  }

  Parsed primary() {
    auto n = node(Kind::label);
    const SclToken token = now();
    switch (token.kind) {
      case Token::integer:
        n.kind = Kind::integer, n.integer = token.integer;
        step();
        return n;
      case Token::real:
        n.kind = Kind::real, n.real = token.real;
        step();
        return n;
      case Token::string:
        n.kind = Kind::string, n.text = token.text;
        step();
        return n;
      case Token::keyword:
        if (token.text != "true" && token.text != "false") return refuse("an expression");
        n.kind = Kind::boolean, n.truth = token.text == "true";
        step();
        return n;
      case Token::identifier:
        n.text = token.text;
        step();
        if (symbol("(")) return call(std::move(n));
        return n;
      default:
        break;
    }
    if (symbol("(")) return in_parentheses();
    return refuse("an expression");
  }

  Parsed call(SclNode n) {
    n.kind = Kind::call;
    step();
    if (symbol(")")) {
      step();
      return n;
    }
    for (;;) {
      auto argument = expression();
      if (!argument.ok()) return argument;
      n.children.push_back(std::move(*argument));
      if (symbol(")")) break;
      if (!symbol(",")) return refuse("',' or ')' after an argument");
      step();
    }
    step();
    return n;
  }

  std::vector<SclToken> tokens_;
  const std::string& file_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Result<std::vector<SclNode>> parse_scl(std::string_view text, const std::string& file) {
  auto tokens = scl_tokens(text, file);
  if (!tokens.ok()) return tokens.error();
  return Parser(std::move(*tokens), file).forms();
}

}  // namespace partscribe::verify
