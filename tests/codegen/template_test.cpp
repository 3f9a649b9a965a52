/// Templates: what a template author may rely on.
#include "codegen/template.h"

#include <catch2/catch.hpp>
#include <fstream>

using namespace partscribe::codegen;

namespace {
std::string rendered(const std::string& text, const TemplateRecord& data) {
  auto result = render_template(text, data, "test.txt");
  return result.ok() ? *result : "error: " + result.error().message;
}
}  // namespace

TEST_CASE("template: keys, lists, records and inner scopes") {
  const TemplateRecord data{
      {"name", "pin"},
      {"parameters", TemplateList{{{"key", "a"}, {"value", "1 < 2"}}, {{"key", "b"}, {"value", "\"&\""}}}},
      {"part", TemplateRecord{{"name", "inner"}}}};
  CHECK(rendered("{{name}}: {{#part}}{{name}}{{/part}}", data) == "pin: inner");
  CHECK(rendered("begin\n{{#parameters}}\n{{key}} = {{value}}; // {{name}}\n{{/parameters}}\nend\n", data) ==
        "begin\na = 1 < 2; // pin\nb = \"&\"; // pin\nend\n");
}

TEST_CASE("template: separators stand between entries only") {
  TemplateList list = template_lines({"x", "y", "z"});
  separate(list, ", ");
  CHECK(rendered("[{{#list}}{{line}}{{comma}}{{/list}}]", {{"list", list}}) == "[x, y, z]");
}

TEST_CASE("template: texts of several lines keep the indentation of their place") {
  CHECK(rendered("module a() {\n  {{body}}\n}\n", {{"body", "one;\n\ntwo;"}}) == "module a() {\n  one;\n\n  two;\n}\n");
  CHECK(rendered("a\n  {{body}}\nb\n", {{"body", ""}}) == "a\nb\n");
  CHECK(rendered("a\n  {{body}};\nb\n", {{"body", ""}}) == "a\n  ;\nb\n");
}

TEST_CASE("template: sections of texts and empty lists") {
  CHECK(rendered("x{{#note}} // {{note}}{{/note}}\n", {{"note", "why"}}) == "x // why\n");
  CHECK(rendered("x{{#note}} // {{note}}{{/note}}\n", {{"note", ""}}) == "x\n");
  CHECK(rendered("{{^list}}none{{/list}}", {{"list", TemplateList{}}}) == "none");
  CHECK(rendered("a\n{{! a remark }}\nb\n", {}) == "a\nb\n");
}

TEST_CASE("template: bad templates are refused with file and line") {
  CHECK(rendered("a\n{{b}}\n", {}) == "error: test.txt:2: unknown name 'b'");
  CHECK(rendered("{{#b}}\n", {}) == "error: test.txt:1: expected {{/b}} before the end of the file");
  CHECK(rendered("{{#b}}\n{{/c}}\n", {}) == "error: test.txt:2: expected {{/b}} (opened in line 1), found {{/c}}");
  CHECK(rendered("{{/c}}\n", {}) == "error: test.txt:1: expected no {{/c}} here, no section is open");
  CHECK(rendered("{{c\n", {}) == "error: test.txt:1: expected }} after {{ on the same line");
  CHECK(rendered("{{ }}\n", {}) == "error: test.txt:1: expected a name between {{ and }}");
  CHECK(rendered("{{l}}\n", {{"l", TemplateList{}}}) == "error: test.txt:1: 'l' is a list or record, expected a text");
}

TEST_CASE("template: sections that multiply, or stand in one another without end, are refused") {
  const auto nested = [](int times) {
    std::string text = "{{name}}";
    for (int i = 0; i < times; ++i) text = "{{#list}}" + text + "{{/list}}";
    return text;
  };
  const auto result = [&](int times, const std::string& name) {
    return rendered(nested(times), {{"name", name}, {"list", template_lines({"a", "b", "c"})}});
  };
  CHECK(result(3, "x") == std::string(27, 'x'));
  CHECK(result(40, "").find("its sections multiply") != std::string::npos);
  CHECK(result(9, std::string(1 << 16, 'x')).find("its sections multiply") != std::string::npos);
  CHECK(result(10'000, "x") == "error: test.txt:1: expected at most 64 sections within each other");
}

TEST_CASE("template packs: a folder replaces single templates and nothing else") {
  TemporaryDirectory folder;
  auto builtin = load_template_pack("openscad", {});
  REQUIRE(builtin.ok());
  std::filesystem::create_directory(folder.path() / "openscad");
  std::ofstream(folder.path() / "openscad" / "part.scad") << "mine\n";
  auto pack = load_template_pack("openscad", folder.path());
  REQUIRE(pack.ok());
  CHECK(pack->render("part.scad", {}).value() == "mine\n");
  CHECK(pack->files.size() == builtin->files.size());

  std::ofstream(folder.path() / "openscad" / "prat.scad") << "typing error\n";
  auto refused = load_template_pack("openscad", folder.path());
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().message.find("prat.scad: expected one of the pack's templates") != std::string::npos);

  auto missing = load_template_pack("openscad", folder.path() / "nowhere");
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().message.find("expected a folder of template packs") != std::string::npos);
}
