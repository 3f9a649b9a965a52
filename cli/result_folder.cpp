#include "cli/result_folder.h"

#include <map>
#include <nlohmann/json.hpp>

#include "cli/inputs.h"
#include "core/json_nesting.h"
#include "core/json_text.h"

namespace partscribe::cli {
namespace {

constexpr const char* mark_name = "unfinished.json";

/// What an unfinished run of the command on the inputs left, each file with its checksum; nothing if there is none.
std::map<std::string, std::string> left_by(const Path& mark, const std::string& command,
                                           const std::vector<std::string>& inputs) {
  const auto text = read_file(mark);
  if (!text || nested_too_deeply(*text)) return {};
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || json.value("command", nlohmann::json()) != command ||
      json.value("inputs", nlohmann::json()) != nlohmann::json(inputs))
    return {};
  std::map<std::string, std::string> files;
  if (const auto found = json.find("files"); found != json.end() && found->is_object())
    for (const auto& [name, checksum] : found->items())
      if (checksum.is_string()) files[name] = checksum;
  return files;
}

}  // namespace

ResultFolder::ResultFolder(Path folder, std::vector<std::string> files, std::string command,
                           const std::vector<Path>& inputs)
    : folder_(std::move(folder)), files_(std::move(files)), command_(std::move(command)) {
  std::error_code ignored;
  was_there_ = std::filesystem::exists(folder_, ignored);
  for (const auto& input : inputs) inputs_.push_back(std::filesystem::absolute(input).lexically_normal().string());
}

Result<Done> ResultFolder::check(bool force) const {
  const auto own = left_by(folder_ / mark_name, command_, inputs_);
  std::vector<std::string> others;
  for (const auto& file : files_) {
    const auto known = own.find(file);
    const auto bytes = known == own.end() ? Result<std::string>(bad_input("")) : read_file(folder_ / file);
    if (!bytes || sha256(*bytes) != known->second) others.push_back(file);
  }
  return check_overwriting(folder_, others, force);
}

Result<Done> ResultFolder::begin() {
  if (auto ok = make_folder(folder_); !ok) return ok;
  std::error_code failure;
  for (const auto& file : files_) {
    std::filesystem::remove(folder_ / file, failure);
    if (failure)
      return usage_error((folder_ / file).string() + ": cannot be replaced: " + failure.message() +
                         "; give another --out");
  }
  begun_ = true;
  return mark();
}

std::vector<std::string> ResultFolder::present() const {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& file : files_)
    if (std::filesystem::is_regular_file(folder_ / file, ignored)) names.push_back(file);
  return names;
}

Result<Done> ResultFolder::mark() const {
  nlohmann::ordered_json json = {
      {"remark", "the files of a run that did not end: they were not verified, and the same command replaces them"},
      {"command", command_},
      {"inputs", inputs_},
      {"files", nlohmann::ordered_json::object()}};
  for (const auto& file : present())
    if (const auto bytes = read_file(folder_ / file)) json["files"][file] = sha256(*bytes);
  return write_file(folder_ / mark_name, json_text(json));
}

std::string ResultFolder::left() const {
  std::string names;
  for (const auto& file : present()) names += (names.empty() ? "" : " ") + file;
  return names.empty() ? ""
                       : "; what is in " + folder_.string() + " (" + names +
                             ") is unfinished and not verified, and the same command replaces it";
}

Result<int> ResultFolder::close(Result<int> outcome) const {
  std::error_code ignored;
  if (!begun_) {
    if (!outcome && !was_there_) std::filesystem::remove(folder_, ignored);  // only if nothing is in it
    return outcome;
  }
  const std::string rest = outcome ? "" : left();
  if (rest.empty()) std::filesystem::remove(folder_ / mark_name, ignored);
  if (rest.empty() || !mark()) return outcome;
  return Error{outcome.error().message + rest, outcome.error().kind};
}

}  // namespace partscribe::cli
