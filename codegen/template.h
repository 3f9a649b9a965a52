/// Renders text templates that hold no logic: the layout is in the template, every decision in C++.
///
/// A template is text with tags in double braces:
///   {{name}}                  the text of a key; keys are sought in the innermost record first, then outwards
///   {{#name}} ... {{/name}}   a list: once per record; a record: once, inside it; a text: once unless it is empty
///   {{^name}} ... {{/name}}   once if the list or text is empty
///   {{! remark}}              nothing
/// A line that holds nothing but section tags and remarks leaves no trace. A {{name}} that stands first on its line
/// hands its indentation on to all lines of its text; where such a text is empty and alone, the line is left out.
/// Unknown keys, wrong kinds, unbalanced sections and sections that multiply beyond measure are errors that name the
/// template's file and line.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/files.h"
#include "core/result.h"

namespace partscribe::codegen {

struct TemplateValue;
using TemplateRecord = std::map<std::string, TemplateValue, std::less<>>;
using TemplateList = std::vector<TemplateRecord>;

/// What a key stands for.
struct TemplateValue {
  std::variant<std::string, TemplateList, TemplateRecord> value;
  TemplateValue() = default;
  TemplateValue(std::string text) : value(std::move(text)) {}
  TemplateValue(const char* text) : value(std::string(text)) {}
  TemplateValue(TemplateList list) : value(std::move(list)) {}
  TemplateValue(TemplateRecord record) : value(std::move(record)) {}
};

/// A list of records with the one key `key`, for lists of plain lines.
TemplateList template_lines(const std::vector<std::string>& lines, const std::string& key = "line");

/// Gives every record the key `key`: `separator`, and an empty text in the last one.
void separate(TemplateList& list, const std::string& separator = ",", const std::string& key = "comma");

/// Renders `text`; `where` names it in errors ("templates/openscad/part.scad").
Result<std::string> render_template(std::string_view text, const TemplateRecord& data, const std::string& where);

/// The templates of one backend by file name.
struct TemplatePack {
  std::string name;                          ///< "openscad"
  std::map<std::string, std::string> files;  ///< text by name: "part.scad"
  std::map<std::string, std::string> where;  ///< what errors call them

  /// Renders one file of the pack; that it exists is our own promise.
  Result<std::string> render(const std::string& file, const TemplateRecord& data) const;
};

/// The built-in pack `name`; files in `folder`/`name` replace those of the same name when `folder` is not empty.
/// Errors: no such folder, or a file there that the built-in pack does not know.
Result<TemplatePack> load_template_pack(const std::string& name, const Path& folder);

/// A file of the built-in packs; the list is generated from templates/ when the program is built.
struct EmbeddedTemplate {
  std::string_view pack, file, text;
};
const std::vector<EmbeddedTemplate>& embedded_templates();

}  // namespace partscribe::codegen
