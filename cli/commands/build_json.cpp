#include "cli/commands/build_json.h"

#include <nlohmann/json.hpp>

#include "cli/describe.h"
#include "core/json_text.h"
#include "fit/procedures.h"
#include "model/json.h"

namespace partscribe::cli {

std::string procedure_of(const Model& model) {
  const auto& shape = model.objects.back().shape;
  if (std::holds_alternative<TriSurface>(shape)) return only_a_mesh;
  if (std::holds_alternative<SurfaceSet>(shape)) return only_free_form;
  return std::string(kind_of(shape));
}

std::string build_json(const Model& model, const std::string& asked, const std::optional<Wider>& wider,
                       const std::string& verdict_json, const std::vector<Path>& files,
                       const std::vector<std::string>& warnings) {
  auto json = nlohmann::ordered_json::parse(verdict_json);
  json["procedure"] = procedure_of(model);
  json["description"] = procedure_text(model);
  json["fallback"] = model.fallback;
  if (std::string line = no_procedure_line(model, asked); !line.empty()) {
    line.pop_back();
    json["no_procedure"] = line;
  }
  if (wider) json["wider"] = {{"procedure", wider->procedure}, {"tolerance", wider->tolerance}};
  json["parameters"] = nlohmann::ordered_json::parse(write_model_json(model)).at("parameters");
  json["files"] = nlohmann::ordered_json::array();
  for (const auto& file : files) json["files"].push_back(file.string());
  json["warnings"] = warnings;
  return json_text(json);
}

}  // namespace partscribe::cli
