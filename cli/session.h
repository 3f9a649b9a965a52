/// One run of the program: the options all commands share, where words go, how long stages take.
#pragma once

#include <chrono>
#include <condition_variable>
#include <fstream>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"

namespace partscribe::cli {

/// Shared by every command.
struct SharedOptions {
  std::optional<double> tolerance;  ///< mm; none: chosen from the scan
  std::string units;                ///< empty: what the file says
  Path out;                         ///< empty: chosen from the input's name
  bool force = false;
  int threads = 0;  ///< 0: all processors
  bool quiet = false;
  bool json = false;
  bool progress = false;  ///< as lines of JSON on standard error
  Path log;
};

/// Where the news of a run go that is a part of another program.
struct Host {
  std::function<void(const std::string& stage, double share)> progress;  ///< called by any thread
  std::function<void(const std::string& line)> warning;
};

/// Results go to standard output (nothing but JSON with --json); progress and warnings to standard error.
class Session {
 public:
  Session(SharedOptions options, std::string version);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  const SharedOptions options;
  const std::string version;  ///< of the program
  Context context;

  /// Opens the log and connects progress, threads and Ctrl-C.
  Result<Done> start();
  /// In place of start(), where the run is a part of another program: prints nothing and leaves signals alone.
  void start_within(Host host);
  /// What a run that is cancelled from now on leaves, as an end of the line that says so.
  void if_cancelled(const std::string& leaves);
  /// Ends the running stage and starts the next; also the place where Ctrl-C is noticed.
  Result<Done> stage(const std::string& name);
  void finish_stage();
  const std::vector<std::pair<std::string, double>>& stages() const { return stages_; }  ///< name, seconds

  void print(const std::string& text);       ///< a result for a person: silent with --quiet and --json
  void print_json(const std::string& text);  ///< a result for a program: only with --json
  void output(const std::string& text);      ///< what was asked for by name (explain): never silenced
  void warn(const std::string& line);        ///< standard error, never silenced
  void note(const std::string& line);        ///< news while working: --log, and standard error if it is a terminal's

 private:
  void connect();
  void show_progress(const std::string& stage, double share);
  void tell_progress(const std::string& title, double share);
  void clear_bar();
  void end_when_cancelled();
  void log_line(const std::string& line);

  std::optional<Host> host_;
  std::ofstream log_;
  std::mutex mutex_;
  bool terminal_ = false, bar_shown_ = false;
  std::string shown_;  ///< the last progress line
  std::chrono::steady_clock::time_point begin_, stage_begin_, last_drawn_;
  std::string stage_;
  std::vector<std::pair<std::string, double>> stages_;
  std::condition_variable ending_;
  std::string leaves_;  ///< guarded by mutex_
  bool ended_ = false;  ///< guarded by mutex_
  std::thread watch_;   ///< over Ctrl-C
};

}  // namespace partscribe::cli
