// Confinement of other programs by bubblewrap (man 1 bwrap).
#include <algorithm>
#include <set>

#include "core/process_watch.h"

namespace partscribe::core {
namespace {

/// Programs, libraries, fonts, and what is needed to find these. What does not exist is left out.
const std::vector<Path> system_folders = {"/usr",
                                          "/bin",
                                          "/sbin",
                                          "/lib",
                                          "/lib32",
                                          "/lib64",
                                          "/etc/alternatives",
                                          "/etc/fonts",
                                          "/etc/ld.so.cache",
                                          "/var/cache/fontconfig"};

/// The options for one path: `bind` it, or draw the symbolic link that it is here.
void show(const std::string& bind, const Path& path, std::vector<std::string>& command) {
  std::error_code failure;
  if (!std::filesystem::exists(path, failure)) return;
  if (bind == "--ro-bind" && std::filesystem::is_symlink(path, failure) && path.parent_path() == "/") {
    command.insert(command.end(), {"--symlink", std::filesystem::read_symlink(path, failure).string(), path.string()});
    return;
  }
  command.insert(command.end(), {bind, path.string(), path.string()});
}

/// Where a confined program starts; may be empty.
Path first_folder(const Confinement& confinement) {
  return !confinement.shared.empty()     ? confinement.shared.front()
         : !confinement.writable.empty() ? confinement.writable.front()
                                         : Path();
}

/// What the shell of a program is given, before the program itself.
std::vector<std::string> shell_of(const Confinement& confinement) {
  std::vector<std::string> command = {"bwrap",         "--unshare-all", "--die-with-parent",
                                      "--new-session", "--cap-drop",    "ALL"};
  std::vector<std::pair<Path, bool>> paths;  // and whether they are writable
  for (const auto& path : system_folders) paths.emplace_back(path, false);
  for (const auto& path : confinement.readable) paths.emplace_back(path, false);
  for (const auto* folders : {&confinement.writable, &confinement.shared})
    for (const auto& path : *folders) paths.emplace_back(path, true);
  // What is mounted later hides what lies below it: the outer ones first.
  std::stable_sort(paths.begin(), paths.end(), [](const auto& a, const auto& b) {
    return std::distance(a.first.begin(), a.first.end()) < std::distance(b.first.begin(), b.first.end());
  });
  const std::string most_bytes = std::to_string(256u << 20);  // it is memory that is written to
  command.insert(command.end(), {"--size", most_bytes, "--tmpfs", "/tmp", "--proc", "/proc", "--dev", "/dev"});
  for (const auto& [path, writable] : paths) show(writable ? "--bind" : "--ro-bind", path, command);
  command.insert(command.end(), {"--remount-ro", "/dev", "--remount-ro", "/"});
  command.insert(command.end(), {"--setenv", "TMPDIR", "/tmp"});
  const Path first = first_folder(confinement);
  command.insert(command.end(), {"--chdir", first.empty() ? "/tmp" : first.string()});
  return command;
}

std::string reason_against() {
  if (find_program("bwrap").empty()) return "bubblewrap is not installed";
  std::vector<std::string> command = shell_of({});
  command.insert(command.end(), {"--", "/usr/bin/true"});
  Context context;
  const auto run = run_process(command, {.seconds = 10}, context);
  if (run.ok() && run->exit_code == 0) return "";
  return "bubblewrap does not work here" +
         (run.ok() && !run->err.empty() ? ": " + run->err.substr(0, run->err.find('\n')) : std::string());
}

/// The output, unless the program may have found no room for what it had to write.
Result<ProcessOutput> with_room(Result<ProcessOutput> output, const std::string& program,
                                const Confinement& confinement) {
  constexpr std::uintmax_t least_room = 1 << 20;
  for (const auto& folder : confinement.writable) {
    std::error_code failure;
    const auto space = std::filesystem::space(folder, failure);
    if (output.ok() && !failure && space.available < least_room)
      return Error{"'" + program + "' had no room to write in " + folder.string() + ": " +
                       std::to_string(space.available) + " bytes are left there",
                   ErrorKind::stopped};
  }
  return output;
}

}  // namespace

const std::string& no_confinement() {
  static const std::string reason = reason_against();
  return reason;
}

Result<ProcessOutput> run_confined(const std::vector<std::string>& arguments, const ProcessLimits& limits,
                                   const Confinement& confinement, Context& context, const LineListener& listener) {
  std::error_code replaced;  // a program that was replaced while it runs has no path any more
  const Path found = find_program(arguments[0]), program = std::filesystem::canonical(found, replaced);
  ProcessWatch watch{arguments[0], {}, confinement.writable, listener};
  const std::string reason = !no_confinement().empty() ? no_confinement() : replaced ? "its file was replaced" : "";
  if (found.empty() || !reason.empty()) {
    if (!found.empty()) context.say(arguments[0] + " runs with access to all files and the network, because " + reason);
    watch.working_directory = first_folder(confinement);
    return with_room(run_watched(arguments, limits, watch, context), arguments[0], confinement);
  }
  Confinement shown = confinement;
  shown.readable.push_back(program);
  std::vector<std::string> command = shell_of(shown);
  command.insert(command.end(), {"--", program.string()});
  command.insert(command.end(), arguments.begin() + 1, arguments.end());
  return with_room(run_watched(command, limits, watch, context), arguments[0], confinement);
}

}  // namespace partscribe::core
