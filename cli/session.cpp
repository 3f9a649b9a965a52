#include "cli/session.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "cli/printable.h"
#include "core/number.h"
#include "core/temporary_directories.h"

namespace partscribe::cli {
namespace {

/// What the signal handler may touch: lock-free values of the one running session.
std::atomic<std::atomic<bool>*> cancel_flag = nullptr;
std::atomic<std::int64_t> first_interrupt_ms = 0;

constexpr std::int64_t same_interrupt_ms = 500;

std::int64_t monotonic_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t(now.tv_sec) * 1000 + now.tv_nsec / 1'000'000;
}

/// A second Ctrl-C ends the program at once, should a stage not listen. One interrupt may arrive more than once
/// (`timeout` sends it to its child and then to the whole group), so only what comes later counts as a second.
void on_interrupt(int signal) {
  if (auto* flag = cancel_flag.load()) *flag = true;
  std::int64_t first = 0;
  const std::int64_t now = monotonic_ms();
  if (first_interrupt_ms.compare_exchange_strong(first, now) || now - first < same_interrupt_ms) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Unlike std::signal, keeps the handler in place after it ran on every system.
void listen_for(int signal) {
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  ::sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  ::sigaction(signal, &action, nullptr);
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::string in_tenths(double seconds) { return print_number(snapped(seconds, 0.1)); }

int terminal_width() {
  winsize size{};
  if (::ioctl(2, TIOCGWINSZ, &size) == 0 && size.ws_col > 20) return size.ws_col;
  return 80;
}

}  // namespace

Session::Session(SharedOptions given, std::string program_version)
    : options(std::move(given)), version(std::move(program_version)) {
  begin_ = stage_begin_ = last_drawn_ = std::chrono::steady_clock::now();
}

Session::~Session() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  ending_.notify_all();
  if (watch_.joinable()) watch_.join();
  clear_bar();
  cancel_flag = nullptr;
}

Result<Done> Session::start() {
  connect();
  terminal_ = ::isatty(2) == 1 && std::getenv("TERM") != nullptr;
  if (!options.log.empty()) {
    log_.open(options.log, std::ios::app);
    if (!log_)
      return usage_error("--log " + options.log.string() + ": cannot be written; name a file in an existing folder");
  }
  cancel_flag = &context.cancelled;
  first_interrupt_ms = 0;
  listen_for(SIGINT);
  listen_for(SIGTERM);
  // A reader that goes away (`partscribe explain m.json | head`) must not look like a crash.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is an error of the write
  watch_ = std::thread([this] { end_when_cancelled(); });
  return Done{};
}

void Session::start_within(Host host) {
  host_ = std::move(host);
  connect();
}

void Session::connect() {
  context.threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  context.progress = [this](const std::string& name, double share) { show_progress(name, share); };
  context.log = [this](const std::string& line) { note(line); };
}

/// Stages look at the flag and end by themselves; one that is deep in somebody else's library is not waited for. No
/// file is left half written: each gets its name when it is whole. Programs that were started have been ended by then.
void Session::end_when_cancelled() {
  using namespace std::chrono_literals;
  std::unique_lock lock(mutex_);
  while (!ending_.wait_for(lock, 100ms, [this] { return ended_ || context.cancelled; })) {
  }
  if (ending_.wait_for(lock, 700ms, [this] { return ended_; })) return;
  std::fprintf(stderr, "%spartscribe: cancelled%s%s\n", bar_shown_ ? "\r\033[K" : "",
               stage_.empty() ? "" : (" in: " + stage_).c_str(), leaves_.c_str());
  remove_temporary_directories();
  ::_exit(static_cast<int>(ErrorKind::stopped));
}

void Session::if_cancelled(const std::string& leaves) {
  const std::lock_guard lock(mutex_);
  leaves_ = leaves;
}

Result<Done> Session::stage(const std::string& name) {
  finish_stage();
  if (context.cancelled) return Error{"cancelled before: " + name, ErrorKind::stopped};
  {
    const std::lock_guard lock(mutex_);
    stage_ = name;
  }
  stage_begin_ = std::chrono::steady_clock::now();
  show_progress(name, 0);
  return Done{};
}

void Session::finish_stage() {
  if (stage_.empty()) return;
  const double seconds = seconds_since(stage_begin_);
  const auto known = std::find_if(stages_.begin(), stages_.end(), [&](const auto& s) { return s.first == stage_; });
  if (known == stages_.end())
    stages_.emplace_back(stage_, seconds);
  else
    known->second += seconds;
  clear_bar();
  log_line(stage_ + ": " + in_tenths(seconds) + " s");
  const std::lock_guard lock(mutex_);
  stage_.clear();
}

void Session::print(const std::string& text) {
  clear_bar();
  if (options.quiet || options.json || host_) return;
  std::fputs(printable(text).c_str(), stdout);
  std::fflush(stdout);
}

void Session::print_json(const std::string& text) {
  clear_bar();
  if (!options.json || host_) return;
  std::fputs(text.c_str(), stdout);
  if (!text.ends_with('\n')) std::fputc('\n', stdout);
  std::fflush(stdout);
}

void Session::output(const std::string& text) {
  clear_bar();
  std::fputs(printable(text).c_str(), stdout);
  std::fflush(stdout);
}

void Session::warn(const std::string& line) {
  if (host_) return host_->warning(line);
  clear_bar();
  std::fprintf(stderr, "partscribe: warning: %s\n", printable(line).c_str());
  log_line("warning: " + line);
}

void Session::note(const std::string& line) {
  log_line(line);
  if (options.quiet || options.json || !terminal_) return;
  clear_bar();
  std::fprintf(stderr, "%s\n", printable(line).c_str());
}

/// A line of JSON whenever a step begins, and from then on at most ten a second.
void Session::tell_progress(const std::string& title, double share) {
  if (title == shown_ && seconds_since(last_drawn_) < 0.1) return;
  shown_ = title;
  last_drawn_ = std::chrono::steady_clock::now();
  std::fprintf(stderr, "{\"step\": %s, \"share\": %s, \"seconds\": %s}\n",
               nlohmann::json(title).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str(),
               print_number(snapped(std::clamp(share, 0.0, 1.0), 0.001)).c_str(),
               in_tenths(seconds_since(begin_)).c_str());
}

void Session::show_progress(const std::string& name, double share) {
  if (options.quiet && !options.progress) return;
  std::unique_lock lock(mutex_);
  const std::string title = printable(stage_.empty() || name == stage_ ? name : stage_ + ": " + name);
  if (host_) {
    lock.unlock();  // the host may take its time
    return host_->progress(title, share);
  }
  if (options.progress) return tell_progress(title, share);
  if (!terminal_) {
    // One plain line per stage: a log file or a build server wants no bar.
    if (title == shown_ || options.json) return;
    shown_ = title;
    std::fprintf(stderr, "%s\n", title.c_str());
    return;
  }
  const bool due = seconds_since(last_drawn_) > 0.1 || title != shown_;
  if (!due) return;
  shown_ = title;
  last_drawn_ = std::chrono::steady_clock::now();
  constexpr int bar_width = 24;
  const int filled = static_cast<int>(std::clamp(share, 0.0, 1.0) * bar_width + 0.5);
  std::string line = "[" + std::string(filled, '#') + std::string(bar_width - filled, '.') + "] " + title + "  " +
                     in_tenths(seconds_since(begin_)) + " s";
  const auto width = static_cast<std::size_t>(terminal_width() - 1);
  if (line.size() > width) line.resize(width);
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
  std::fflush(stderr);
  bar_shown_ = true;
}

void Session::clear_bar() {
  const std::lock_guard lock(mutex_);
  if (!bar_shown_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  bar_shown_ = false;
}

void Session::log_line(const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (log_) log_ << in_tenths(seconds_since(begin_)) << " s  " << printable(line) << std::endl;
}

}  // namespace partscribe::cli
