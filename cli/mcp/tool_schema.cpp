#include "cli/mcp/tool_schema.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/suggest.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;
using Takes = Declared::Takes;

Json property_schema(const Declared& d) {
  const Json text = {{"type", "string"}};
  if (d.repeated) return {{"type", "array"}, {"items", text}, {"minItems", 1}};
  Json schema;
  switch (d.takes) {
    case Takes::nothing:
      schema = {{"type", "boolean"}};
      break;
    case Takes::list:
      schema = {{"type", "array"}, {"items", text}};
      if (!d.words.empty()) schema["items"]["enum"] = d.words;
      break;
    case Takes::number:
      schema = {{"type", "number"}, {"minimum", d.low}, {"maximum", d.high}};
      break;
    case Takes::count:
      schema = {{"type", "integer"}, {"minimum", std::lround(d.low)}, {"maximum", std::lround(d.high)}};
      break;
    default:
      schema = text;
      if (!d.words.empty()) schema[d.other_words ? "examples" : "enum"] = d.words;
  }
  return schema;
}

/// A path as the command line is given it: within `root`, and relative to it.
Result<std::string> path_within(const Path& root, const std::string& property, const std::string& given) {
  std::error_code failure;
  const Path path = std::filesystem::weakly_canonical(root / given, failure);
  const Path inside = path.lexically_relative(root);
  if (failure || given.empty() || given.find('\0') != std::string::npos || inside.empty() || *inside.begin() == "..")
    return usage_error(property + ": expected a path within " + root.string() + ", found '" + given + "'");
  return inside.string();
}

/// One value as text; what its text may be is the command's to say.
Result<std::string> value_text(const Json& value, const Declared& d, const Path& root) {
  const std::string property = property_name(d);
  if (value.is_number()) return print_number(value.get<double>());
  if (!value.is_string())
    return usage_error(property + ": expected a " + (d.takes_words() && d.high > d.low ? "number" : "text") +
                       ", found " + value.dump());
  const auto text = value.get<std::string>();
  return d.takes == Takes::file || d.takes == Takes::folder ? path_within(root, property, text) : Result(text);
}

/// The values of a property, of which there may be several.
Result<std::vector<std::string>> value_texts(const Json& value, const Declared& d, const Path& root) {
  std::vector<std::string> texts;
  const bool several = (d.repeated || d.takes == Takes::list) && value.is_array();
  for (const auto& item : several ? value : Json::array({value})) {
    auto text = value_text(item, d, root);
    if (!text) return text.error();
    texts.push_back(std::move(*text));
  }
  return texts;
}

}  // namespace

std::string property_name(const Declared& declared) {
  std::string name = declared.name.substr(std::min(declared.name.find_first_not_of('-'), declared.name.size()));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::string in_properties(std::string text, const std::vector<Declared>& declared) {
  for (const auto& d : declared) {
    if (!d.is_option()) continue;
    const std::string property = '"' + property_name(d) + (d.takes == Takes::nothing ? "\": true" : "\"");
    for (std::size_t at = 0; (at = text.find(d.name, at)) != std::string::npos;) {
      const char next = at + d.name.size() < text.size() ? text[at + d.name.size()] : ' ';
      const bool longer = next == '-' || (next >= 'a' && next <= 'z');  // another option, that begins like this one
      if (!longer) text.replace(at, d.name.size(), property);
      at += longer ? d.name.size() : property.size();
    }
  }
  return text;
}

Json input_schema(const std::vector<Declared>& declared) {
  Json properties = Json::object(), required = Json::array();
  for (const auto& d : declared) {
    properties[property_name(d)] = property_schema(d);
    properties[property_name(d)]["description"] = in_properties(d.help, declared);
    if (!d.is_option()) required.push_back(property_name(d));
  }
  return {{"type", "object"}, {"properties", properties}, {"required", required}, {"additionalProperties", false}};
}

Result<std::vector<std::string>> command_words(const Json& arguments, const std::vector<Declared>& declared,
                                               const Path& root) {
  if (!arguments.is_object()) return usage_error("expected arguments as a JSON object, found " + arguments.dump());
  std::vector<std::string> names;
  for (const auto& d : declared) names.push_back(property_name(d));
  for (const auto& [name, value] : arguments.items())
    if (std::find(names.begin(), names.end(), name) == names.end())
      return usage_error("there is no argument '" + name + "'" + did_you_mean(name, names));
  std::vector<std::string> words, operands = {"--"};
  for (const auto& d : declared) {
    const auto given = arguments.find(property_name(d));
    const bool missing = given == arguments.end() || given->is_null() || (given->is_array() && given->empty());
    if (missing && !d.is_option()) return usage_error("expected the argument '" + property_name(d) + "', found none");
    if (missing) continue;
    if (d.takes == Takes::nothing) {
      if (!given->is_boolean())
        return usage_error(property_name(d) + ": expected true or false, found " + given->dump());
      if (*given) words.push_back(d.name);
      continue;
    }
    const auto texts = value_texts(*given, d, root);
    if (!texts) return texts.error();
    if (!d.is_option()) {
      operands.insert(operands.end(), texts->begin(), texts->end());
      continue;
    }
    std::string joined;
    for (const auto& text : *texts) joined += (joined.empty() ? "" : ",") + text;
    words.push_back(d.name + "=" + joined);
  }
  words.insert(words.end(), operands.begin(), operands.end());
  return words;
}

}  // namespace partscribe::cli
