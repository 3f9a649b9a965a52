#include "cli/commands/judged.h"

#include "cli/commands/stages.h"
#include "cli/inputs.h"
#include "core/number.h"
#include "verify/evaluate/evaluate.h"

namespace partscribe::cli {

Result<Operands> told_apart(const std::vector<Path>& files, const std::string& command) {
  Operands operands;
  for (const auto& file : files) (is_cad_file(file) ? operands.artifacts : operands.scans).push_back(file);
  if (operands.artifacts.empty()) {
    operands.artifacts.push_back(operands.scans.front());
    operands.scans.erase(operands.scans.begin());
  }
  if (operands.scans.empty())
    return usage_error(command + " needs an artifact and at least one scan, found only " + files.front().string() +
                       (files.size() > 1 ? " and " + std::to_string(files.size() - 1) + " more of its kind" : "") +
                       "; add the scan file");
  for (const auto& artifact : operands.artifacts)
    if (!is_file(artifact))
      return bad_input(artifact.string() + ": expected a script, a CAD file or a mesh, found no such file");
  return operands;
}

Result<std::optional<Model>> model_of(const Path& artifact, const Path& named) {
  if (!named.empty()) {
    auto model = read_model(named);
    if (!model) return model.error();
    return std::optional<Model>(**model);
  }
  const Path beside = artifact.parent_path() / "model.json";
  if (!is_file(beside)) return std::optional<Model>();
  auto model = read_model(beside);
  return model ? std::optional<Model>(**model) : std::optional<Model>();
}

VerifyOptions verify_options(const std::optional<Model>& model, const Scan& scan, std::optional<double> outliers,
                             Session& session) {
  VerifyOptions options;
  if (!session.options.tolerance && model) {
    options.tolerance = model->tolerance;
    session.print("Tolerance " + print_number(options.tolerance) + " mm, as in the model beside the artifact.\n");
  } else {
    const auto tolerance = tolerance_for(scan, session);
    options.tolerance = tolerance.tolerance;
    if (!session.options.tolerance) session.print("T" + tolerance.reason.substr(1) + ".\n");
  }
  if (outliers) {
    options.outlier_rate = *outliers;
  } else if (model && outlier_rate_of(*model) > options.outlier_rate) {
    options.outlier_rate = outlier_rate_of(*model);
    session.print("Up to " + print_number(snapped(100 * options.outlier_rate, 0.1)) +
                  " % of the points may be outliers, as many as the fit of the model beside the artifact set aside.\n");
  }
  return options;
}

}  // namespace partscribe::cli
