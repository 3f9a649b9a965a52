/// The Model Context Protocol (revision 2025-06-18, modelcontextprotocol.io): JSON-RPC messages, a line each, by which
/// an agent lists tools and calls them. What the tools do is not known here.
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/context.h"

namespace partscribe::cli {

/// What a server serves. Texts of JSON, so that no more than lines is shared.
struct Service {
  std::string name, title, version;
  std::string instructions;  ///< for the agent: what the tools are good for together
  std::string tools;         ///< a JSON array, as `tools/list` answers it
  /// A call's result, a JSON object with `content`; several may run at a time. `context` reports progress and says when
  /// the call was cancelled.
  std::function<std::string(const std::string& tool, const std::string& arguments, Context& context)> call;
};

/// One connection.
class Server {
 public:
  /// `send` is given one line at a time, without its end, by one thread at a time.
  Server(Service service, std::function<void(const std::string& line)> send);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  /// Cancels what is running and waits for it.
  ~Server();

  /// A message as it came. Answers follow by `send`, those of calls when they have ended.
  void receive(const std::string& line);
  /// Waits for the calls that are running.
  void finish();

 private:
  struct Call;

  const Service service_;
  const std::function<void(const std::string&)> send_;
  std::mutex sending_, calls_access_;
  std::list<std::shared_ptr<Call>> calls_;  ///< running ones, and ended ones that were not waited for

  void send(const std::string& line);
  void start_call(const std::string& id, const std::string& params);
  void cancel(const std::string& id);
  void drop_ended();
};

/// The result of a call that failed, with one line that says why.
std::string failed_call(const std::string& text);

inline constexpr std::size_t most_calls = 4;             ///< that run at a time
inline constexpr std::size_t longest_message = 4 << 20;  ///< bytes
inline constexpr const char* newest_protocol = "2025-06-18";

}  // namespace partscribe::cli
