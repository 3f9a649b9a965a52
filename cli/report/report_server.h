/// The report beside its script in the browser: a number is edited, verified, and the map drawn anew. On this machine
/// alone.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "cli/session.h"
#include "core/result.h"

namespace partscribe::cli {

/// What came of a script.
struct BenchAnswer {
  std::string page;      ///< the report, a page by itself
  std::string outcome;   ///< "verified", as in verdict.json
  std::string sentence;  ///< the verdict in a sentence
};

struct Workbench {
  std::string name;    ///< of the part
  std::string file;    ///< of the script, without folder: "part.scad"
  std::string script;  ///< its text, as the file has it
  BenchAnswer judged;  ///< what came of it
  std::function<Result<BenchAnswer>(const std::string& script)> judge;
};

/// A port of 127.0.0.1, kept from the moment it is taken.
class BenchPort {
 public:
  /// `port` 0: any free one. Errors: a usage error if another program has it.
  static Result<BenchPort> take(int port);
  BenchPort(BenchPort&&) noexcept;
  ~BenchPort();

  /// Serves the bench until the session is cancelled; `started` is told its address, which holds a random word that
  /// nobody else knows.
  void serve(Workbench bench, Session& session, const std::function<void(const std::string& address)>& started);

 private:
  struct Open;
  explicit BenchPort(std::unique_ptr<Open> open);
  std::unique_ptr<Open> open_;
};

}  // namespace partscribe::cli
