#include "core/process.h"

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/sysinfo.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>

#include "core/number.h"
#include "core/process_watch.h"
#include "core/sanitized.h"

namespace partscribe::core {
namespace {

constexpr int most_files = 100'000;
constexpr double interval = 0.1;  // seconds between looks at what it has used
constexpr double patience = 0.5;  // seconds for output that is still on its way when a program has ended

/// Variables that a program needs to find its files, and what tells a sanitizer how to speak.
constexpr std::array passed_on = {"PATH",
                                  "HOME",
                                  "TMPDIR",
                                  "TZ",
                                  "LD_LIBRARY_PATH",
                                  "LANG",
                                  "OPENSCADPATH",
                                  "ASAN_OPTIONS",
                                  "TSAN_OPTIONS",
                                  "UBSAN_OPTIONS",
                                  "PARTSCRIBE_OPENSCAD_WASM"};
constexpr std::array passed_on_families = {"LC_", "XDG_"};

/// "NAME=value" of the variables that are passed on.
std::vector<char*> environment() {
  std::vector<char*> passed;
  for (char** variable = environ; *variable; ++variable) {
    const std::string_view text = *variable, name = text.substr(0, text.find('='));
    const auto begins = [&](const char* family) { return name.starts_with(family); };
    if (std::ranges::find(passed_on, name) != passed_on.end() || std::ranges::any_of(passed_on_families, begins))
      passed.push_back(*variable);
  }
  passed.push_back(nullptr);
  return passed;
}

void limit(int resource, double most) {
  const auto value = static_cast<rlim_t>(most);
  const rlimit both{value, value};
  ::setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

void append_tail(std::string& text, std::string_view bytes, std::size_t kept) {
  text.append(bytes);
  if (text.size() > 2 * kept) text.erase(0, text.size() - kept);
}

/// Takes bytes as they come and passes on whole lines, of a bearable length.
class Lines {
 public:
  explicit Lines(const LineListener& listener) : listener_(listener) {}
  void take(std::string_view bytes) {
    if (!listener_) return;
    constexpr std::size_t longest = 4096;
    for (const char c : bytes)
      if (c == '\n')
        listener_(line_), line_.clear();
      else if (line_.size() < longest)
        line_ += c;
  }

 private:
  const LineListener& listener_;
  std::string line_;
};

/// Whether the files in the folders, or their number, have outgrown `most_mb`.
bool outgrown(const std::vector<Path>& folders, double most_mb) {
  double bytes = 0;
  int files = 0;
  for (const auto& folder : folders) {
    std::error_code failure;
    for (std::filesystem::recursive_directory_iterator at(folder, failure), end; !failure && at != end;
         at.increment(failure)) {
      std::error_code gone;
      const auto size = at->is_symlink(gone) ? 0 : at->file_size(gone);
      if (!gone) bytes += static_cast<double>(size);
      if (++files > most_files || bytes > most_mb * 1048576.0) return true;
    }
  }
  return false;
}

/// How many processes run that `first` has started, itself among them: those below it, and those of its group.
int family_of(pid_t first) {
  struct Kin {
    pid_t parent = 0, group = 0;
  };
  std::map<pid_t, Kin> all;
  std::error_code failure;
  for (std::filesystem::directory_iterator at("/proc", failure), end; !failure && at != end; at.increment(failure)) {
    const pid_t process = static_cast<pid_t>(std::atoi(at->path().filename().c_str()));
    if (process <= 0) continue;
    std::ifstream file(at->path() / "stat");
    std::string text;
    std::getline(file, text, '\0');  // a process may end here, and iterators of a stream throw at what cannot be read
    std::istringstream fields(text.substr(std::min(text.size(), text.rfind(')') + 1)));  // behind its name
    std::string state;
    Kin kin;
    if (fields >> state >> kin.parent >> kin.group) all[process] = kin;
  }
  int count = 0;
  for (auto [process, kin] : all) {
    bool ours = process == first || kin.group == first;
    for (pid_t above = kin.parent; !ours && above > 1;) {
      ours = above == first;
      const auto next = all.find(above);
      above = next == all.end() ? 0 : next->second.parent;
    }
    count += ours;
  }
  return count;
}

struct Pipe {
  int read_end = -1, write_end = -1;
  bool open() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return false;
    read_end = ends[0], write_end = ends[1];
    return true;
  }
};

}  // namespace

Path find_program(const std::string& name) {
  const auto runs = [](const Path& file) {
    std::error_code hidden;
    return ::access(file.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(file, hidden);
  };
  if (name.find('/') != std::string::npos) return runs(name) ? Path(name) : Path();
  const char* variable = std::getenv("PATH");
  std::istringstream folders(variable ? variable : "/usr/local/bin:/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const Path candidate = Path(folder.empty() ? "." : folder) / name;
    if (runs(candidate)) return candidate;
  }
  return {};
}

Result<ProcessOutput> run_process(const std::vector<std::string>& arguments, const ProcessLimits& limits,
                                  Context& context, const Path& working_directory, const LineListener& listener) {
  ensure(!arguments.empty(), "a process needs a program");
  return run_watched(arguments, limits, {arguments[0], working_directory, {}, listener}, context);
}

Result<ProcessOutput> run_watched(const std::vector<std::string>& arguments, const ProcessLimits& limits,
                                  const ProcessWatch& watch, Context& context) {
  ensure(!arguments.empty(), "a process needs a program");
  const Path program = find_program(arguments[0]);
  if (program.empty())
    return Error{"program '" + arguments[0] + "' was not found on PATH: install it", ErrorKind::missing_program};

  // Everything that allocates happens before the fork: the child of a threaded process may not.
  std::vector<char*> argv;
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const std::vector<char*> variables = environment();
  struct sysinfo system {};
  ::sysinfo(&system);
  const double processes = system.procs + limits.processes;  // the limit counts all processes of the user
  const pid_t parent = ::getpid();
  const std::string program_text = program.string(), folder = watch.working_directory.string();
  Pipe out, err;
  if (!out.open() || !err.open()) return Error{"no pipe for '" + watch.name + "'", ErrorKind::stopped};

  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child < 0) return Error{"'" + watch.name + "' cannot be started: " + std::strerror(errno), ErrorKind::stopped};
  if (child == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, 0);
    ::dup2(out.write_end, 1);
    ::dup2(err.write_end, 2);
    ::close_range(3, ~0U, CLOSE_RANGE_CLOEXEC);
    if (!sanitized) limit(RLIMIT_AS, limits.memory_mb * 1048576.0);
    limit(RLIMIT_FSIZE, limits.file_mb * 1048576.0);
    limit(RLIMIT_NPROC, processes);
    limit(RLIMIT_CORE, 0);
    if (!folder.empty() && ::chdir(folder.c_str()) != 0) ::_exit(127);
    ::execve(program_text.c_str(), argv.data(), variables.data());
    ::_exit(127);
  }
  ::setpgid(child, child);
  ::close(out.write_end);
  ::close(err.write_end);

  ProcessOutput result;
  const auto kept_output = static_cast<std::size_t>(limits.output_mb * 1048576);
  Lines lines(watch.listener);
  pollfd ends[2] = {{out.read_end, POLLIN, 0}, {err.read_end, POLLIN, 0}};
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  int open_ends = 2, status = 0;
  bool killed = false;
  double ended = -1, next_look = interval;
  std::string excess;  // what it had too much of
  // A program may close its output long before its end; and what it left running may hold the output open for ever.
  while (ended < 0 || (open_ends > 0 && elapsed() < ended + patience)) {
    if (open_ends > 0)
      ::poll(ends, 2, 20);
    else
      ::usleep(1000);
    for (auto& end : ends) {
      if (end.fd < 0 || !(end.revents & (POLLIN | POLLHUP | POLLERR))) continue;
      char buffer[65536];
      const auto got = ::read(end.fd, buffer, sizeof buffer);
      if (got > 0) {
        const std::string_view bytes(buffer, static_cast<std::size_t>(got));
        const bool is_err = end.fd == err.read_end;
        append_tail(is_err ? result.err : result.out, bytes, kept_output);
        if (is_err) lines.take(bytes);
      } else if (got == 0 || errno != EINTR) {
        end.fd = -1;
        --open_ends;
      }
    }
    if (ended < 0 && ::waitpid(child, &status, WNOHANG) == child) ended = elapsed();
    if (ended < 0 && excess.empty() && elapsed() > next_look) {
      const double began = elapsed();
      if (outgrown(watch.folders, limits.file_mb))
        excess = "wrote more than " + print_number(limits.file_mb) + " MB, or more than " + std::to_string(most_files) +
                 " files";
      else if (::geteuid() == 0 && family_of(child) > limits.processes)  // root has no other limit
        excess = "started more than " + std::to_string(limits.processes) + " processes";
      next_look = elapsed() + std::max(interval, 10 * (elapsed() - began));  // to look must not become the work
    }
    if (ended < 0 && !killed && (context.cancelled || !excess.empty() || elapsed() > limits.seconds)) {
      result.timed_out = !context.cancelled && excess.empty();
      ::kill(-child, SIGKILL);
      killed = true;
    }
  }
  ::kill(-child, SIGKILL);  // what it left running
  ::close(out.read_end);
  ::close(err.read_end);
  if (context.cancelled) return Error{"cancelled while '" + watch.name + "' was running", ErrorKind::stopped};
  if (!excess.empty()) return Error{"'" + watch.name + "' " + excess, ErrorKind::stopped};
  result.seconds = ended;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace partscribe::core
