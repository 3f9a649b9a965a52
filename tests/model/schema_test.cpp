/// docs/model.schema.json says what model.json holds: what is written validates, and what is broken does not.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "core/files.h"
#include "model/json.h"
#include "tests/model/parts.h"

using namespace partscribe;

namespace {

using Json = nlohmann::json;

Json parsed(const Path& path) {
  const auto text = read_file(path);
  REQUIRE(text.ok());
  return Json::parse(*text);
}

const Json& schema() {
  static const Json document = parsed(Path(PARTSCRIBE_SOURCE_DIR) / "docs" / "model.schema.json");
  return document;
}

/// The keywords that the schema uses; any other is a fault of the test, not silently true.
const std::set<std::string> known_keywords = {"$schema",
                                              "title",
                                              "description",
                                              "definitions",
                                              "$ref",
                                              "type",
                                              "enum",
                                              "anyOf",
                                              "oneOf",
                                              "allOf",
                                              "required",
                                              "properties",
                                              "additionalProperties",
                                              "items",
                                              "minItems",
                                              "maxItems",
                                              "minimum",
                                              "maximum",
                                              "exclusiveMinimum",
                                              "pattern"};

bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number() && value.get<double>() == std::floor(value.get<double>());
  FAIL("unknown type " + type);
  return false;
}

/// Validates by the part of JSON Schema that the document uses. With `strict`, keys that no property names are faults.
class Validator {
 public:
  explicit Validator(bool strict) : strict_(strict) {}

  /// The first fault and where it is; empty if there is none.
  std::string fault(const Json& value, const Json& rule = schema(), const std::string& at = "document") const {
    for (const auto& [keyword, argument] : rule.items()) {
      if (!known_keywords.count(keyword)) FAIL("the schema uses the unknown keyword " + keyword);
      const std::string text = check(keyword, argument, value, rule, at);
      if (!text.empty()) return text;
    }
    return "";
  }

 private:
  bool strict_;

  std::string check(const std::string& keyword, const Json& argument, const Json& value, const Json& rule,
                    const std::string& at) const {
    const std::string wrong = at + ": " + keyword;
    if (keyword == "$ref") {
      const std::string name = argument.get<std::string>().substr(std::string("#/definitions/").size());
      return fault(value, schema().at("definitions").at(name), at);
    }
    if (keyword == "type") return has_type(value, argument) ? "" : wrong + " " + argument.get<std::string>();
    if (keyword == "enum") return std::find(argument.begin(), argument.end(), value) != argument.end() ? "" : wrong;
    if (keyword == "allOf" || keyword == "anyOf" || keyword == "oneOf") {
      std::size_t fits = 0;
      for (const auto& choice : argument) fits += fault(value, choice, at).empty();
      const bool good = keyword == "allOf" ? fits == argument.size() : keyword == "anyOf" ? fits > 0 : fits == 1;
      return good ? "" : wrong;
    }
    if (keyword == "minimum") return !value.is_number() || value >= argument ? "" : wrong;
    if (keyword == "maximum") return !value.is_number() || value <= argument ? "" : wrong;
    if (keyword == "exclusiveMinimum") return !value.is_number() || value > argument ? "" : wrong;
    if (keyword == "pattern")
      return !value.is_string() || std::regex_search(value.get<std::string>(), std::regex(argument.get<std::string>()))
                 ? ""
                 : wrong;
    if (keyword == "minItems") return !value.is_array() || value.size() >= argument.get<std::size_t>() ? "" : wrong;
    if (keyword == "maxItems") return !value.is_array() || value.size() <= argument.get<std::size_t>() ? "" : wrong;
    if (keyword == "items" && value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) {
        if (argument.is_array() && i >= argument.size()) break;
        const std::string text =
            fault(value[i], argument.is_array() ? argument[i] : argument, at + "[" + std::to_string(i) + "]");
        if (!text.empty()) return text;
      }
    }
    if (keyword == "required" && value.is_object())
      for (const auto& key : argument)
        if (!value.contains(key.get<std::string>())) return wrong + " " + key.get<std::string>();
    if (keyword == "properties" && value.is_object())
      for (const auto& [key, member] : value.items()) {
        if (argument.contains(key)) {
          const std::string text = fault(member, argument[key], at + "." + key);
          if (!text.empty()) return text;
        } else if (strict_ || rule.value("additionalProperties", true) == false) {
          return at + ": unknown key " + key;
        }
      }
    return "";
  }
};

std::string fault_of(const Model& model) { return Validator(true).fault(Json::parse(write_model_json(model))); }

/// A model that uses every optional part of the document.
Model full_model() {
  Model m = test::pin();
  m.provenance.sources = {{"pin.ply", std::string(64, 'a')}};
  m.provenance.version = "0.1.0";
  m.parameters[0].nominal = NominalEvidence{20, 0.3, true, "0.5 mm grid"};
  m.parameters[0].note = "radius of the head";
  m.objects[0].note = "a pin";
  m.objects[0].frame.x = Expr::call(Expr::Kind::atan2, {Expr::of("head_radius"), -Expr::of("head_height")});
  m.objects[0].frame.rx = Expr::call(Expr::Kind::sqrt, {Expr::of("head_radius") / Expr::of("head_height")});
  m.hypothesis = Hypothesis{1, 2, 3, 0.5, 1, 0, 0, 0.1, 0.2, "surface of revolution"};
  m.rivals = {{"box", false, 3.5, 100, "deviates"}};
  m.unexplained = {{"not scanned", 3, 4}};
  return m;
}

}  // namespace

TEST_CASE("model.schema.json: every shape as it is written validates, without a key that the schema does not name") {
  for (const auto& model : test::one_of_each()) {
    INFO(kind_of(model.objects.back().shape));
    CHECK(fault_of(model) == "");
  }
  CHECK(fault_of(full_model()) == "");
}

TEST_CASE("model.schema.json: every committed model validates") {
  std::size_t models = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Path(PARTSCRIBE_SOURCE_DIR) / "tests" / "golden")) {
    if (!std::filesystem::exists(entry.path() / "model.json")) continue;
    INFO(entry.path().filename());
    CHECK(Validator(true).fault(parsed(entry.path() / "model.json")) == "");
    ++models;
  }
  CHECK(models >= 16);
}

TEST_CASE("model.schema.json: there is a definition for every kind of shape, and for no other") {
  std::set<std::string> written, defined;
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (written.insert(std::string(std::variant_alternative_t<I, Shape>::kind)), ...);
  }
  (std::make_index_sequence<std::variant_size_v<Shape>>());
  for (const auto& choice : schema()["definitions"]["shape"]["oneOf"])
    defined.insert(choice["$ref"].get<std::string>().substr(std::string("#/definitions/shape_").size()));
  CHECK(written == defined);
}

TEST_CASE("model.schema.json: what the reader refuses, the schema refuses") {
  const Json good = Json::parse(write_model_json(full_model()));
  const auto refused = [&](const char* pointer, Json value) {
    Json broken = good;
    broken[Json::json_pointer(pointer)] = std::move(value);
    INFO(pointer);
    CHECK_FALSE(read_model_json(broken.dump(), "m.json").ok());
    CHECK(Validator(false).fault(broken) != "");
  };
  refused("/format", "other");
  refused("/version", 99);
  refused("/units", "inch");
  refused("/tolerance", "0.1");
  refused("/objects", 3);
  refused("/objects/0/shape/kind", "spiral");
  refused("/objects/0/shape/sketch/loops/0/elements/0", {{"spline", Json::object()}});
  refused("/objects/0/shape/sketch/loops/0/elements/0/point/x", {"%", 1, 2});
  refused("/objects/0/shape/sketch/loops/0/elements/0/point/x", {"+", 1});
  refused("/objects/0/frame/move", {1, 2});
  refused("/parameters/0/quantity", "weight");
  refused("/parameters/0/value", "20");
  refused("/hypothesis/a1", "1");
  for (const char* key : {"format", "version", "tolerance", "objects"}) {
    Json broken = good;
    broken.erase(key);
    CHECK_FALSE(read_model_json(broken.dump(), "m.json").ok());
    CHECK(Validator(false).fault(broken) != "");
  }
  Json later = good;
  later["parameters"][0]["a_later_key"] = 1;
  CHECK(read_model_json(later.dump(), "m.json").ok());
  CHECK(Validator(false).fault(later) == "");
}
