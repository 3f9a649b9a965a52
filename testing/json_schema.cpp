#include "testing/json_schema.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <stdexcept>

#include "core/ensure.h"
#include "core/files.h"

namespace partscribe::testing {

using namespace core;

namespace {

using Json = nlohmann::json;

const std::set<std::string> known_keywords = {"$schema",     "title",
                                              "description", "definitions",
                                              "$defs",       "$ref",
                                              "type",        "enum",
                                              "anyOf",       "oneOf",
                                              "allOf",       "required",
                                              "properties",  "additionalProperties",
                                              "items",       "minItems",
                                              "maxItems",    "minimum",
                                              "maximum",     "exclusiveMinimum",
                                              "pattern"};

bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number() && value.get<double>() == std::floor(value.get<double>());
  throw std::logic_error("the schema uses the unknown type " + type);
}

bool keeps_limit(const std::string& keyword, const Json& argument, const Json& value) {
  if (keyword == "type") return has_type(value, argument);
  if (keyword == "enum") return std::find(argument.begin(), argument.end(), value) != argument.end();
  if (keyword == "minimum") return !value.is_number() || value >= argument;
  if (keyword == "maximum") return !value.is_number() || value <= argument;
  if (keyword == "exclusiveMinimum") return !value.is_number() || value > argument;
  if (keyword == "minItems") return !value.is_array() || value.size() >= argument.get<std::size_t>();
  if (keyword == "maxItems") return !value.is_array() || value.size() <= argument.get<std::size_t>();
  if (keyword == "pattern")
    return !value.is_string() || std::regex_search(value.get<std::string>(), std::regex(argument.get<std::string>()));
  return true;
}

}  // namespace

JsonSchema::JsonSchema(const std::filesystem::path& file) {
  const auto text = read_file(file);
  ensure(text.ok(), "the schema can be read");
  document_ = std::make_shared<const Json>(Json::parse(*text));
}

std::string JsonSchema::fault(const Json& value, const Json& rule, Keys keys, const std::string& at) const {
  for (const auto& [keyword, argument] : rule.items()) {
    if (!known_keywords.count(keyword)) throw std::logic_error("the schema uses the unknown keyword " + keyword);
    const std::string text = fault_by(keyword, argument, value, rule, keys, at);
    if (!text.empty()) return text;
  }
  return "";
}

std::string JsonSchema::fault_by(const std::string& keyword, const Json& argument, const Json& value, const Json& rule,
                                 Keys keys, const std::string& at) const {
  const std::string wrong = at + ": " + keyword;
  if (!keeps_limit(keyword, argument, value)) return wrong;
  if (keyword == "$ref")
    return fault(value, document_->at(Json::json_pointer(argument.get<std::string>().substr(1))), keys, at);
  if (keyword == "allOf" || keyword == "anyOf" || keyword == "oneOf") {
    std::size_t fits = 0;
    for (const auto& choice : argument) fits += fault(value, choice, keys, at).empty();
    const bool good = keyword == "allOf" ? fits == argument.size() : keyword == "anyOf" ? fits > 0 : fits == 1;
    return good ? "" : wrong;
  }
  if (keyword == "items" && value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (argument.is_array() && i >= argument.size()) break;
      const Json& item_rule = argument.is_array() ? argument[i] : argument;
      const std::string text = fault(value[i], item_rule, keys, at + "[" + std::to_string(i) + "]");
      if (!text.empty()) return text;
    }
  if (keyword == "required" && value.is_object())
    for (const auto& key : argument)
      if (!value.contains(key.get<std::string>())) return wrong + " " + key.get<std::string>();
  if (keyword == "properties" && value.is_object())
    for (const auto& [key, member] : value.items()) {
      if (argument.contains(key)) {
        const std::string text = fault(member, argument[key], keys, at + "." + key);
        if (!text.empty()) return text;
      } else if (keys == Keys::named || rule.value("additionalProperties", true) == false) {
        return at + ": unknown key " + key;
      }
    }
  return "";
}

}  // namespace partscribe::testing
