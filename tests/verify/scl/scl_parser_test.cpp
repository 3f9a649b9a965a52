#include "verify/scl/scl_parser.h"

#include <catch2/catch.hpp>

using namespace partscribe::verify;

namespace {

std::string complaint(const std::string& text) {
  const auto parsed = parse_scl(text, "t.scl");
  return parsed.ok() ? std::string() : parsed.error().message;
}

std::string repeated(const std::string& text, int count) {
  std::string result;
  for (int i = 0; i < count; ++i) result += text;
  return result;
}

}  // namespace

TEST_CASE("scl parser: accepts what the manual's grammar allows") {
  const std::vector<std::string> good = {
      "",
      ";",
      "$;",
      "# only a remark",
      "A : 1;",
      "a_1 : 1. ; B : .1; C : 1.234; D : 1.e2; E : .1e-4; F : 1.2e+6; G : 12;",
      "set demand_eval true;",
      "unset demand_eval; quit;",
      "include \"prelude.scl\";",
      "pt( 1, -1 );",
      "A : -B * ( C + 2.0 ) / D - E ** 2 $;",
      "X : a < b && not c == d or ! e;",
      "{ A; B : 2; }",
      "seq { A; }",
      "M : seqCollect { seqcollect { 1; 2; } 3; }",
      "SEQCOLLECT { 1; }",
      "while ( A < 3 ) B;",
      "if ( A ) B; else C;",
      "S : if ( A < B ) A; else if ( B < C ) B; else { C; }",
      "for ( I; 1; I < 10; I + 1 ) f( I );",
      "forCollect ( I; 1; I < 10; I + 1 ) { A : I; A * 2; }",
      "procedure f( A, B ) A + B;",
      "procedure g( A ) { return A; }",
      "<< A : 1; procedure f( X ) X; ; >>",
      "commentoutcode A : f( 1, 2 );",
      "{ A; };",  // at the outermost level a lone end of statement is legal
      "show( \"text with # inside\" );",
  };
  for (const auto& text : good) {
    INFO(text);
    CHECK(complaint(text) == "");
  }
}

TEST_CASE("scl parser: refuses everything else and says where") {
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"A : 1", "t.scl:1:6: expected ';', found the end of the file"},
      {"A : 1e5;", "t.scl:1:5: expected a number, found '1e'"},
      {"\n  A : 1.5.2;", "t.scl:2:7: expected a number"},
      {"A : 2x;", "t.scl:1:5: expected a number"},
      {"A : 99999999999999999999;", "t.scl:1:5: expected a whole number below 2^63"},
      {"A : \"open", "t.scl:1:5: expected a closing \""},
      {"A : 1 % 2;", "t.scl:1:7: expected a word, a number or a sign of SCL, found '%'"},
      {"A = 1;", "t.scl:1:3: expected a word, a number or a sign of SCL, found '='"},
      {"A : [ 1 ];", "found '['"},
      {std::string("A : \xff;"), "found byte 255"},
      {"if ( A ) B;", "t.scl:1:12: expected else (no if without it), found the end of the file"},
      {"{ A; ; }", "t.scl:1:6: expected a statement (none may be empty between braces), found ';'"},
      {"{ }", "t.scl:1:3: expected at least one statement between the braces, found '}'"},
      {"seqCollect { {A;}; }", "t.scl:1:18: expected a statement (none may be empty between braces)"},
      {"f( seqCollect { 1; } );", "t.scl:1:4: expected an expression, found the keyword seqcollect"},
      {"f( 1, );", "t.scl:1:7: expected an expression, found ')'"},
      {"f( 1 2 );", "t.scl:1:6: expected ',' or ')' after an argument, found '2'"},
      {"procedure f() 1;", "t.scl:1:13: expected the name of a formal argument, found ')'"},
      {"procedure f( A ) ;", "t.scl:1:18: expected an expression, found ';'"},
      {"{ procedure f( A ) A; }", "expected a value (procedure stands at the outermost level only)"},
      {"{ set x true; }", "expected a value (set stands at the outermost level only)"},
      {"{ include \"a.scl\"; }", "expected a value (include stands at the outermost level only)"},
      {"include prelude;", "t.scl:1:9: expected the file to include, in quotes, found 'prelude'"},
      {"for ( I; 1; I < 10 ) f( I );", "t.scl:1:20: expected ';', found ')'"},
      {"forCollect ( I : 1; I < 10; I + 1 ) I;", "t.scl:1:16: expected ';', found ':'"},
      {"while A < 3 B;", "t.scl:1:7: expected '(', found 'A'"},
      {"A :: 1;", "expected an operator whose meaning is documented, found '::'"},
      {"A ++ ;", "expected an operator whose meaning is documented, found '++'"},
      {"const A : 1;", "expected an expression, found the keyword const"},
      {"<< A : 1;", "t.scl:1:10: expected '>>', found the end of the file"},
      {"seq A;", "t.scl:1:5: expected '{', found 'A'"},
      {"true : 1;", "t.scl:1:6: expected ';', found ':'"},
      {"A : B : 1;", "t.scl:1:7: expected ';', found ':'"},
  };
  for (const auto& [text, message] : bad) {
    INFO(text);
    const std::string said = complaint(text);
    CHECK_THAT(said, Catch::Contains(message));
  }
}

TEST_CASE("scl parser: stops at nesting and chains that no person writes") {
  CHECK_THAT(complaint("A : " + std::string(100000, '(') + "1;"), Catch::Contains("levels of nesting"));
  CHECK_THAT(complaint(std::string(100000, '{')), Catch::Contains("levels of nesting"));
  CHECK_THAT(complaint("A : " + repeated("- ", 100000) + "1;"), Catch::Contains("levels of nesting"));
  std::string chain = "A : 1";
  for (int i = 0; i < 100000; ++i) chain += " + 1";
  CHECK_THAT(complaint(chain + ";"), Catch::Contains("operators in a row"));
  std::string choices;
  for (int i = 0; i < 100000; ++i) choices += "if ( a ) b; else ";
  CHECK_THAT(complaint(choices), Catch::Contains("levels of nesting"));
}

TEST_CASE("scl parser: operators bind as in arithmetic") {
  const auto parsed = parse_scl("1 - 2 - 3 * 4 ** 2;", "t.scl");
  REQUIRE(parsed.ok());
  const SclNode& minus = (*parsed)[0].children[0];
  CHECK(minus.text == "-");
  CHECK(minus.children[0].text == "-");  // (1 - 2) - ...
  CHECK(minus.children[1].text == "*");
  CHECK(minus.children[1].children[1].text == "**");
}
