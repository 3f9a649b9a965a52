/// What every long operation shares: how many threads, where progress goes, whether to stop.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "core/layers.h"

namespace partscribe::core {

/// Passed by reference down every call; holds no results.
struct Context {
  int threads = 1;                                                       ///< never changes any result
  std::function<void(const std::string& stage, double share)> progress;  ///< share 0..1; may be empty
  std::function<void(const std::string& line)> log;                      ///< one line of news; may be empty
  std::atomic<bool> cancelled = false;                                   ///< set from outside to stop early

  void report(const std::string& stage, double share) const {
    if (progress) progress(stage, share);
  }
  void say(const std::string& line) const {
    if (log) log(line);
  }
};

}  // namespace partscribe::core
