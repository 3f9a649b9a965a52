/// A scan becomes an OpenSCAD script and a STEP file, and both are held against the scan: the stages of partscribe, one
/// call each.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "codegen/emit.h"
#include "fit/build.h"
#include "scan/read/read.h"
#include "verify/verify.h"

using namespace partscribe;

namespace {

/// The value, or the end of the program with the one line that says why there is none.
template <class T>
T needed(core::Result<T> result) {
  if (result) return std::move(result).value();
  std::fprintf(stderr, "scan_to_cad: %s\n", result.error().message.c_str());
  std::exit(static_cast<int>(result.error().kind));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: scan_to_cad SCAN TOLERANCE-IN-MM\n");
    return 2;
  }
  const double tolerance = std::atof(argv[2]);
  core::Context context;

  auto scan = needed(scan::read_scan({argv[1]}, {}, context));
  const auto model = needed(fit::build_model(scan, {.tolerance = tolerance}, context));
  for (const auto& parameter : model->parameters)
    std::printf("%s = %g, %s\n", parameter.name.c_str(), parameter.value, parameter.note.c_str());

  std::vector<core::Path> files;
  for (const std::string backend : {"openscad", "step"}) {
    const auto artifact = needed(codegen::emit(model, backend, {}, context));
    for (const auto& file : artifact.files) needed(core::write_file(file.name, file.bytes));
    files.push_back(artifact.files.front().name);
  }

  const auto verdict = needed(verify::verify_artifacts(files, scan, *model, {.tolerance = tolerance}, context));
  std::fputs(verify::verdict_table(verdict).c_str(), stdout);
  return verify::exit_code_of(verdict.verdict);
}
