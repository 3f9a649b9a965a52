/// explain: a model in words, with every number's evidence.
#include <memory>

#include "cli/commands.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "core/number.h"
#include "model/json.h"

namespace partscribe::cli {
namespace {

constexpr const char* explain_help =
    R"(Examples
  partscribe explain bracket-partscribe/model.json          why each dimension is what it is
  partscribe explain bracket-partscribe                     the same
  partscribe explain model.json --json | jq .parameters     for a program

Prints for each parameter its value, the fitted number with one standard deviation, and whether a nominal size was
taken and why; then the first hypothesis, the steps with their evidence, and the rivals with the reason they lost.)";

std::string explanation(const Model& model) {
  std::string text = model.name + ": " + procedure_text(model) + ".\nTolerance " + print_number(model.tolerance) +
                     " mm; " + std::to_string(model.provenance.points) + " points in " +
                     std::to_string(model.provenance.views) + " views, " + std::to_string(model.provenance.rejected) +
                     " set aside; noise " + readable(model.provenance.noise) + " mm.\n\nDimensions\n";
  for (const auto& parameter : model.parameters) {
    const auto row = describe(parameter);
    text += "  " + row.name + " = " + row.value + (row.unit.empty() ? "" : " " + row.unit) +
            (row.note.empty() ? "" : "   " + row.note) + "\n";
    if (!row.fitted.empty())
      text += "      fitted " + row.fitted + (row.points.empty() ? "" : " from " + row.points + " points") + "\n";
    if (parameter.sigma_systematic > 0 || parameter.sigma_noise > 0) {
      const double scale = parameter.quantity == Quantity::angle ? 180 / pi : 1;
      text += "      of which noise " + readable(scale * parameter.sigma_noise) + ", systematic " +
              readable(scale * parameter.sigma_systematic) + "\n";
    }
    if (!row.nominal.empty()) text += "      nominal " + row.nominal + "\n";
  }
  if (model.parameters.empty()) text += "  none: the shape has no dimension that a person would name\n";
  if (const auto line = hypothesis_line(model); !line.empty()) text += "\nHypothesis\n  " + line + "\n";
  text += "\nSteps\n";
  std::vector<std::vector<std::string>> steps = {{"step", "shape", "points", "rms", "max", "covered", "note"}};
  for (const auto& object : model.objects)
    steps.push_back({object.name, std::string(kind_of(object.shape)), std::to_string(object.evidence.points),
                     readable(object.evidence.rms), readable(object.evidence.max),
                     print_number(snapped(100 * object.evidence.covered, 1)) + " %", object.note});
  text += table(steps);
  for (const auto& u : model.unexplained)
    text += "  unexplained: " + u.reason + " (" + readable(u.area) + " mm2, " + std::to_string(u.points) + " points)\n";
  const auto rivals = rival_lines(model);
  text += "\nRivals\n";
  for (const auto& line : rivals) text += "  " + line + "\n";
  if (rivals.empty()) text += "  none were recorded\n";
  if (const auto nearest = nearest_procedure_line(model); !nearest.empty()) text += "\n" + nearest + "\n";
  return text;
}

Result<int> run_explain(const Path& given, Session& session) {
  const auto model = read_model(std::filesystem::is_directory(given) ? given / "model.json" : given);
  if (!model) return model.error();
  session.output(session.options.json ? write_model_json(**model) : explanation(**model));
  return 0;
}

}  // namespace

Command explain_command() {
  auto file = std::make_shared<Path>();
  return {"explain", "say why each feature is what it is, with rivals and numbers", explain_help,
          [file](Arguments& a) { a.operand(*file, "model", "a model.json, or the folder that holds one"); },
          [file](Session& session) { return run_explain(*file, session); }};
}

}  // namespace partscribe::cli
