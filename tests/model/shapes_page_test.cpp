/// docs/shapes.md shows every shape: its picture, a model of it that makes sense, and the names of its numbers.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>

#include "model/check.h"
#include "model/json.h"
#include "model/shapes.h"
#include "testing/program.h"

using namespace partscribe::model;
using namespace partscribe::testing;

namespace {

/// The names in the fields() walk of a shape.
std::vector<std::string> names_of_fields(const EvaluatedShape& shape) {
  std::vector<std::string> names;
  std::visit(
      [&](auto copy) { copy.fields(copy, [&](const std::string& name, const auto&...) { names.push_back(name); }); },
      shape);
  return names;
}

/// One shape of every kind.
template <std::size_t... I>
std::vector<EvaluatedShape> one_of_each(std::index_sequence<I...>) {
  return {EvaluatedShape(std::in_place_index<I>)...};
}

std::string row_of(const std::string& page, const std::string& kind) {
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    if (line.find("[`" + kind + "`](shapes/" + kind + ".json)") != std::string::npos) return line;
  return "";
}

}  // namespace

TEST_CASE("shapes page: every shape has its row, with picture, numbers and a model that can be built") {
  const auto page = bytes_of(source_file("docs/shapes.md"));
  for (const auto& shape : one_of_each(std::make_index_sequence<std::variant_size_v<EvaluatedShape>>())) {
    const std::string kind(kind_of(shape));
    INFO(kind);
    const auto row = row_of(page, kind);
    REQUIRE(!row.empty());
    CHECK(row.find("](images/shapes/" + kind + ".png)") != std::string::npos);
    CHECK(std::filesystem::exists(source_file("docs/images/shapes/" + kind + ".png")));
    for (const auto& name : names_of_fields(shape)) {
      INFO(name);
      CHECK(row.find("`" + name + "`") != std::string::npos);
    }
    const auto model = read_model_json(bytes_of(source_file("docs/shapes/" + kind + ".json")), kind + ".json");
    INFO((model ? "" : model.error().message));
    REQUIRE(model.ok());
    CHECK(checked(*model, kind + ".json").ok());
    CHECK(std::any_of(model->objects.begin(), model->objects.end(),
                      [&](const auto& object) { return kind_of(object.shape) == kind; }));
  }
}
