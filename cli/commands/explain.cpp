/// explain: a model in words, with every number's evidence.
#include <memory>

#include "cli/commands.h"
#include "cli/describe.h"
#include "cli/inputs.h"
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

Result<int> run_explain(const Path& given, Session& session) {
  const auto model = read_model(given);
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
