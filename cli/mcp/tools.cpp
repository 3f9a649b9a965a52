#include "cli/mcp/tools.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "cli/mcp/findings.h"
#include "cli/mcp/server.h"
#include "cli/mcp/tool_schema.h"
#include "cli/report/report_html.h"
#include "cli/verdict_file.h"
#include "core/lies_within.h"
#include "verify/evaluate/run_openscad.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;

/// A command, and what a call of it says besides its arguments.
struct CommandTool {
  Command command;
  std::vector<std::string> writes;  ///< options of what it writes into the root; none: it only reads
  std::string asks = {};   ///< the option by which it is asked for pictures; empty: it writes some anyway, or none
  std::string place = {};  ///< of these pictures in the scratch folder
};

std::vector<CommandTool> command_tools() {
  return {{build_command(), {"--out", "--force"}, "--pictures=", "pictures"},
          {verify_command(), {}, "--pictures=", "pictures"},
          {explain_command(), {}},
          {measure_command(), {"--out", "--csv", "--force"}},
          {render_command(), {"--picture", "--force"}, "--picture=", "picture.png"}};
}

/// What an agent may say: the command's own arguments and those of the shared ones that concern its work. How it speaks
/// is the server's, and what a call that only reads would write is in its answer.
std::vector<Declared> arguments_of(const CommandTool& tool) {
  const auto is_one_of = [](const std::vector<std::string>& names) {
    return [names](const Declared& d) { return std::find(names.begin(), names.end(), d.name) != names.end(); };
  };
  std::vector<Declared> declared = declared_by(tool.command);
  for (const auto& d : shared_options())
    if (is_one_of({"--tolerance", "--units", "--out", "--force", "--threads"})(d)) declared.push_back(d);
  const auto output = is_one_of({"--out", "--force", "--picture", "--pictures", "--csv", "--junit", "--json-file"});
  const auto written = is_one_of(tool.writes);
  std::erase_if(declared, [&](const Declared& d) { return output(d) && !written(d); });
  return declared;
}

/// What help says behind the examples, which are lines for a shell.
std::string description_of(const Command& command, const std::vector<Declared>& declared) {
  const auto text = command.help.find("\n\n");
  std::string description = command.summary + ".";
  if (text != std::string::npos) description += " " + command.help.substr(text + 2);
  std::replace(description.begin(), description.end(), '\n', ' ');
  description[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(description[0])));
  return in_properties(description, declared);
}

Json text_block(const std::string& text) { return {{"type", "text"}, {"text", text}}; }

/// The folders of a call.
struct Places {
  Path root, scratch;

  /// What the call has written; nothing where it could not: it names its files itself.
  std::optional<std::string> read(const Path& file) const {
    const Path path = root / file;  // an absolute one is itself
    if (!lies_within(path, root) && !lies_within(path, scratch)) return {};
    auto bytes = read_file(path);
    return bytes ? std::optional(std::move(*bytes)) : std::nullopt;
  }
};

std::vector<std::string> within_root(std::vector<std::string> files, const Path& root) {
  std::erase_if(files, [&](const std::string& file) { return !lies_within(root / file, root); });
  return files;
}

/// Nothing if there is no such picture.
void add_picture(const Path& file, const Places& places, Json& content) {
  if (const auto png = places.read(file))
    content.push_back({{"type", "image"}, {"data", base64(*png)}, {"mimeType", "image/png"}});
}

/// The line by which the program said why it failed.
std::string complaint_in(const ProcessOutput& run) {
  const std::string mark = "partscribe: ", warning = mark + "warning: ";
  std::string complaint;
  std::istringstream lines(run.err);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(mark) && !line.starts_with(warning)) complaint = line.substr(mark.size());
  if (complaint.empty()) complaint = "partscribe ended with exit code " + std::to_string(run.exit_code);
  return complaint;
}

/// A run of the program, confined to the root and `scratch`.
Result<ProcessOutput> run(const std::vector<std::string>& words, const Workshop& workshop, const Places& places,
                          Context& context) {
  std::vector<std::string> command = {workshop.program.string()};
  command.insert(command.end(), words.begin(), words.end());
  const Confinement reach{openscad_folders(), {places.scratch}, {places.root}};
  return run_confined(command, workshop.limits, reach, context, [&](const std::string& line) {
    const Json said = Json::parse(line, nullptr, false);
    if (said.is_object() && said.contains("step")) context.report(said.value("step", ""), said.value("share", 0.0));
  });
}

/// The verdict in words, the script that was written, and the pictures that say most.
void add_verdict(const Json& said, const Places& places, const Path& pictures, Json& content, Json& structured) {
  const auto verdict = read_verdict_json(said.dump(), "the verdict");
  if (!verdict) return;
  structured["tasks"] = tasks_of(*verdict);
  std::string text = said.value("description", "");
  if (!text.empty()) text = "Found: " + text + ".\n\n";
  content.push_back(text_block(text + verdict_table(*verdict)));
  constexpr std::size_t longest_script = 64 << 10;
  for (const auto& file : said.value("files", std::vector<std::string>()))
    if (file.ends_with(".scad"))
      if (const auto script = places.read(file); script && script->size() <= longest_script)
        content.push_back(text_block(file + ":\n" + *script));
  add_picture(pictures / "deviation.png", places, content);
  if (!structured["tasks"].empty()) add_picture(pictures / "finding-1.png", places, content);
}

/// What a model says that is short, whatever the part: no shapes, which may hold a million triangles.
Json short_model(const Json& model) {
  Json brief;
  for (const char* key : {"name", "tolerance", "fallback", "parameters", "rivals", "unexplained", "provenance"})
    if (model.contains(key)) brief[key] = model[key];
  return brief;
}

}  // namespace

std::string tool_list() {
  Json list = Json::array();
  for (const auto& tool : command_tools()) {
    const auto declared = arguments_of(tool);
    list.push_back({{"name", tool.command.name},
                    {"description", description_of(tool.command, declared)},
                    {"inputSchema", input_schema(declared)},
                    {"annotations",
                     {{"readOnlyHint", tool.writes.empty()},
                      {"destructiveHint", false},
                      {"idempotentHint", true},
                      {"openWorldHint", false}}}});
  }
  return list.dump();
}

std::string call_tool(const std::string& name, const std::string& arguments, const Workshop& workshop,
                      Context& context) {
  auto tools = command_tools();
  const auto tool = std::find_if(tools.begin(), tools.end(), [&](const auto& t) { return t.command.name == name; });
  if (tool == tools.end()) return failed_call("there is no tool '" + name + "'");
  const auto declared = arguments_of(*tool);
  const auto given = command_words(Json::parse(arguments), declared, workshop.root);
  if (!given) return failed_call(given.error().message);
  const auto scratch = TemporaryDirectory::make();
  if (!scratch) return failed_call(scratch.error().message);
  const Places places{workshop.root, scratch->path()};
  const Path pictures = places.scratch / tool->place;
  std::vector<std::string> words = {name, "--progress"};
  const bool told = std::any_of(given->begin(), given->end(), [&](const auto& w) { return w.starts_with(tool->asks); });
  if (!tool->asks.empty() && !told) words.push_back(tool->asks + pictures.string());
  words.insert(words.end(), given->begin(), given->end());
  auto with_json = words;
  with_json.insert(with_json.begin() + 1, "--json");

  const auto output = run(with_json, workshop, places, context);
  if (!output) return failed_call(output.error().message);
  if (output->timed_out)
    return failed_call(name + " did not end within " + std::to_string(static_cast<long>(workshop.limits.seconds)) +
                       " s");
  const Json said = Json::parse(output->out, nullptr, false);
  if (!said.is_object()) return failed_call(in_properties(complaint_in(*output), declared));
  Json content = Json::array(), structured = said;
  if (structured.contains("files"))  // pictures in the scratch folder are gone with the call
    structured["files"] = within_root(said.value("files", std::vector<std::string>()), places.root);
  structured["exit_code"] = output->exit_code;
  if (name == "build" || name == "verify") {
    add_verdict(said, places, pictures, content, structured);
  } else if (name == "explain") {
    const auto plain = run(words, workshop, places, context);
    if (!plain) return failed_call(plain.error().message);
    content.push_back(text_block(plain->out));
    structured = short_model(said);
  } else {
    content.push_back(text_block(name == "measure" ? said.dump(1) : said.value("description", "")));
    for (const auto& file : said.value("files", std::vector<std::string>()))
      if (file.ends_with(".png")) add_picture(file, places, content);
  }
  const Json result = {{"content", content}, {"structuredContent", structured}, {"isError", false}};
  return result.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace partscribe::cli
