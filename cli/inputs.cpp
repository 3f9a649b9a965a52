#include "cli/inputs.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "cli/names.h"
#include "core/number.h"
#include "geometry/normals/local_noise.h"
#include "geometry/points/bulk_box.h"
#include "model/json.h"
#include "scan/read/read.h"

namespace partscribe::cli {
namespace {

/// Its folder is that of the other stages as well.
bool written_by_a_stage(const Path& input) {
  return input.filename() == "cloud.ply" || input.filename() == "model.json";
}

/// What may not be looked at is not there; that nothing can be written there either is said when it is tried.
bool is_there(const Path& path) {
  std::error_code hidden;
  return std::filesystem::exists(path, hidden);
}

/// The least round number that is not below `value`.
double rounded_up(double value) {
  const double decade = power_of_ten_below(value);
  for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
    if (value <= step * decade * (1 + 1e-9)) return snapped(step * decade, decade / 10);
  return snapped(10 * decade, decade);
}

}  // namespace

bool is_file(const Path& path) {
  std::error_code hidden;
  return std::filesystem::is_regular_file(path, hidden);
}

bool is_folder(const Path& path) {
  std::error_code hidden;
  return std::filesystem::is_directory(path, hidden);
}

Path output_folder(const SharedOptions& options, const Path& input, const Path& named_after) {
  if (!options.out.empty()) return options.out;
  if (written_by_a_stage(input)) return input.has_parent_path() ? input.parent_path() : Path(".");
  return folder_name(named_after) + folder_ending;
}

Result<Done> check_same_part(const SharedOptions& options, const Path& folder, const std::vector<Path>& inputs) {
  if (!options.out.empty() || written_by_a_stage(inputs.front()) || !is_there(folder / "model.json")) return Done{};
  const auto model = read_model(folder / "model.json");
  if (!model || (*model)->provenance.sources.empty()) return Done{};
  const auto& sources = (*model)->provenance.sources;
  for (const auto& input : inputs) {
    const std::string file = is_folder(input) ? "scan.json" : input.filename().string();
    if (std::any_of(sources.begin(), sources.end(), [&](const auto& source) { return source.file == file; }))
      return Done{};
  }
  return usage_error(folder.string() + " holds what was made from " + sources.front().file + ", not from " +
                     inputs.front().filename().string() + "; give --out for another folder, or --out " +
                     folder.string() + " to replace it");
}

Result<Done> check_overwriting(const Path& folder, const std::vector<std::string>& files, bool force) {
  if (is_there(folder) && !is_folder(folder))
    return usage_error(folder.string() + ": expected a folder for the results, found a file; give another --out");
  for (const auto& file : files)
    if (!force && is_there(folder / file))
      return usage_error((folder / file).string() +
                         " exists already; give --force to overwrite it or --out for another folder");
  return Done{};
}

Result<Done> check_overwriting(const Path& file, bool force, const std::vector<Path>& inputs) {
  std::error_code missing;
  for (const auto& input : inputs)
    if (std::filesystem::equivalent(file, input, missing))
      return usage_error(file.string() + " is read by this command and cannot be written as well; give another name");
  const Path folder = file.parent_path();
  if (!folder.empty() && !is_folder(folder))
    return usage_error(file.string() + ": there is no folder " + folder.string() + "; make it first");
  if (!force && is_there(file))
    return usage_error(file.string() + " exists already; give --force to overwrite it or another name");
  return Done{};
}

Result<Done> make_folder(const Path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) return usage_error(folder.string() + ": cannot be made: " + failure.message() + "; give another --out");
  return Done{};
}

Result<Scan> read_scans(const std::vector<Path>& inputs, Session& session, ReadOptions options,
                        std::vector<RangeImage>* images) {
  if (!session.options.units.empty()) options.unit = parse_unit(session.options.units);
  auto scan = read_scan(inputs, options, session.context, images);
  if (scan)
    for (const auto& warning : scan->warnings) session.warn(warning);
  return scan;
}

Result<CheckedModel> read_model(const Path& given) {
  const Path file = is_folder(given) ? given / "model.json" : given;
  if (file != given && !is_there(file))
    return bad_input(given.string() + ": expected a folder that build or fit has filled, found no model.json in it");
  const auto text = read_file(file);
  if (!text) return text.error();
  auto model = read_model_json(*text, file.string());
  if (!model) return model.error();
  return checked(std::move(*model), file.string());
}

ChosenTolerance tolerance_for(const Scan& scan, Session& session) {
  ChosenTolerance chosen;
  if (session.options.tolerance) {
    chosen.tolerance = *session.options.tolerance;
    chosen.reason = "tolerance " + print_number(chosen.tolerance) + " mm, as given";
    return chosen;
  }
  chosen.noise = noise_along_normals(scan.cloud, session.context.threads);
  const double diagonal = bulk_box(scan.cloud.points, 0.005).diagonal();
  const double from_noise = 5 * chosen.noise, from_size = diagonal / 1000;
  chosen.tolerance = rounded_up(std::max({from_noise, from_size, 1e-6}));
  chosen.reason =
      "tolerance " + print_number(chosen.tolerance) + " mm, chosen because none was given: " +
      (from_noise >= from_size
           ? "5 times the noise of the scan (" +
                 print_number(snapped(chosen.noise, power_of_ten_below(std::max(chosen.noise, 1e-9)) / 10)) + " mm)"
           : "a thousandth of the part's size (" +
                 print_number(snapped(diagonal, power_of_ten_below(std::max(diagonal, 1e-9)) / 100)) + " mm)") +
      ", rounded up; --tolerance sets it";
  return chosen;
}

}  // namespace partscribe::cli
