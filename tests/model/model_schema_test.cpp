/// docs/model.schema.json says what model.json holds: what is written validates, and what is broken does not.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "core/files.h"
#include "model/json.h"
#include "testing/json_schema.h"
#include "testing/models.h"
#include "testing/program.h"

using namespace partscribe::model;
using namespace partscribe::testing;
using Keys = JsonSchema::Keys;

namespace {

using Json = nlohmann::json;

Json parsed(const Path& path) {
  const auto text = read_file(path);
  REQUIRE(text.ok());
  return Json::parse(*text);
}

const JsonSchema& schema() {
  static const JsonSchema document(source_file("docs/model.schema.json"));
  return document;
}

std::string fault_of(const Model& model) { return schema().fault(Json::parse(write_model_json(model)), Keys::named); }

/// A model that uses every optional part of the document.
Model full_model() {
  Model m = pin();
  m.provenance.sources = {{"pin.ply", std::string(64, 'a')}};
  m.provenance.version = "0.1.0";
  m.parameters[0].nominal = NominalEvidence{20, 0.3, true, "0.5 mm grid"};
  m.parameters[0].note = "radius of the head";
  m.parameters.push_back({"head_diameter", Quantity::length, 40, 40});
  m.parameters.back().formula = Expr(2) * Expr::of("head_radius");
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
  for (const auto& model : one_of_each()) {
    INFO(kind_of(model.objects.back().shape));
    CHECK(fault_of(model) == "");
  }
  CHECK(fault_of(full_model()) == "");
}

TEST_CASE("model.schema.json: every committed model validates") {
  std::size_t models = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_file("tests/golden"))) {
    if (!std::filesystem::exists(entry.path() / "model.json")) continue;
    INFO(entry.path().filename());
    CHECK(schema().fault(parsed(entry.path() / "model.json"), Keys::named) == "");
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
  for (const auto& choice : schema().document()["definitions"]["shape"]["oneOf"])
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
    CHECK(schema().fault(broken, Keys::any) != "");
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
    CHECK(schema().fault(broken, Keys::any) != "");
  }
  Json later = good;
  later["parameters"][0]["a_later_key"] = 1;
  CHECK(read_model_json(later.dump(), "m.json").ok());
  CHECK(schema().fault(later, Keys::any) == "");
}
