/// A headless Chromium, driven through its debugging pipe: opens pages, presses keys, reads what it drew.
#pragma once

#include <sys/types.h>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/files.h"
#include "testing/png_pixels.h"

namespace partscribe::testing {

using namespace core;

using Json = nlohmann::json;

/// Path of a Chromium on PATH; empty if there is none.
Path find_chromium();

/// One page. Everything that goes wrong with the browser itself throws std::runtime_error and so ends the test.
class Chromium {
 public:
  /// `flags` are added to the command line.
  explicit Chromium(const std::vector<std::string>& flags = {});
  ~Chromium();
  Chromium(const Chromium&) = delete;
  Chromium& operator=(const Chromium&) = delete;

  void open(const Path& page, int width, int height);
  void open_address(const std::string& address, int width, int height);
  /// Calls a method of the debugging protocol for this page.
  Json call(const std::string& method);
  Json call(const std::string& method, Json parameters);
  /// The value of an expression in the page; promises are awaited.
  Json evaluate(const std::string& expression);
  /// Waits until the expression is true; false after `seconds`.
  bool wait_for(const std::string& expression, double seconds = 20);
  /// Moves the mouse to a place in the middle of the element, offset in pixels; presses and releases when `click`.
  void point_at(const std::string& selector, double dx, double dy, bool click = false);
  void press(const std::string& key);
  /// What the window shows of an element.
  Pixels screenshot(const std::string& selector);

  const std::vector<std::string>& complaints() const { return complaints_; }  ///< errors and console messages
  const std::vector<std::string>& requests() const { return requests_; }      ///< addresses, without data:

 private:
  Json receive(double seconds);
  void note(const Json& event);

  TemporaryDirectory profile_;
  pid_t process_ = -1;
  int to_ = -1, from_ = -1;
  int last_id_ = 0;
  std::string session_, buffer_;
  std::vector<std::string> complaints_, requests_;
};

}  // namespace partscribe::testing
