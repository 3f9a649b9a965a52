#include "core/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace partscribe {
namespace {

constexpr std::size_t kept_output = 1 << 20;

void append_tail(std::string& text, const char* bytes, std::size_t count) {
  text.append(bytes, count);
  if (text.size() > 2 * kept_output) text.erase(0, text.size() - kept_output);
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
  if (name.find('/') != std::string::npos) return ::access(name.c_str(), X_OK) == 0 ? Path(name) : Path();
  const char* variable = std::getenv("PATH");
  std::istringstream folders(variable ? variable : "/usr/local/bin:/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const Path candidate = Path(folder.empty() ? "." : folder) / name;
    if (::access(candidate.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(candidate)) return candidate;
  }
  return {};
}

Result<ProcessOutput> run_process(const std::vector<std::string>& arguments, const ProcessLimits& limits,
                                  Context& context, const Path& working_directory) {
  ensure(!arguments.empty(), "a process needs a program");
  const Path program = find_program(arguments[0]);
  if (program.empty())
    return Error{"program '" + arguments[0] + "' was not found on PATH: install it", ErrorKind::missing_program};

  // Everything that allocates happens before the fork: the child of a threaded process may not.
  std::vector<char*> argv;
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const std::string program_text = program.string(), folder = working_directory.string();
  Pipe out, err;
  if (!out.open() || !err.open()) return Error{"no pipe for '" + arguments[0] + "'", ErrorKind::stopped};

  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child < 0) return Error{"'" + arguments[0] + "' cannot be started: " + std::strerror(errno), ErrorKind::stopped};
  if (child == 0) {
    ::setpgid(0, 0);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, 0);
    ::dup2(out.write_end, 1);
    ::dup2(err.write_end, 2);
    const auto bytes = static_cast<rlim_t>(limits.memory_mb * 1048576.0);
    const rlimit memory{bytes, bytes};
    ::setrlimit(RLIMIT_AS, &memory);
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    if (!folder.empty() && ::chdir(folder.c_str()) != 0) ::_exit(127);
    ::execv(program_text.c_str(), argv.data());
    ::_exit(127);
  }
  ::setpgid(child, child);
  ::close(out.write_end);
  ::close(err.write_end);

  ProcessOutput result;
  bool cancelled = false;
  pollfd ends[2] = {{out.read_end, POLLIN, 0}, {err.read_end, POLLIN, 0}};
  auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  int open_ends = 2;
  bool killed = false;
  while (open_ends > 0) {
    ::poll(ends, 2, 100);
    for (auto& end : ends) {
      if (end.fd < 0 || !(end.revents & (POLLIN | POLLHUP | POLLERR))) continue;
      char buffer[65536];
      const auto got = ::read(end.fd, buffer, sizeof buffer);
      if (got > 0) {
        append_tail(end.fd == out.read_end ? result.out : result.err, buffer, static_cast<std::size_t>(got));
      } else if (got == 0 || errno != EINTR) {
        end.fd = -1;
        --open_ends;
      }
    }
    cancelled = context.cancelled;
    result.timed_out = elapsed() > limits.seconds;
    if ((cancelled || result.timed_out) && !killed) {
      ::kill(-child, SIGKILL);
      killed = true;
    }
  }
  ::close(out.read_end);
  ::close(err.read_end);
  int status = 0;
  // The output may be closed long before the end: keep the time limit here as well.
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if ((context.cancelled || elapsed() > limits.seconds) && !killed) {
      result.timed_out = !context.cancelled;
      ::kill(-child, SIGKILL);
      killed = true;
    }
    ::usleep(1000);
  }
  if (context.cancelled) return Error{"cancelled while '" + arguments[0] + "' was running", ErrorKind::stopped};
  result.seconds = elapsed();
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace partscribe
