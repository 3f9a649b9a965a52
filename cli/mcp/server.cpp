#include "cli/mcp/server.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;

// Codes of JSON-RPC 2.0.
constexpr int no_json = -32700, no_request = -32600, no_method = -32601, bad_params = -32602;

/// Bytes that are no UTF-8 are replaced: file names and what programs say may hold any.
std::string line_of(const Json& message) {
  return message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string answer_line(const Json& id, const Json& result) {
  return line_of({{"jsonrpc", "2.0"}, {"id", id}, {"result", result}});
}

std::string error_line(const Json& id, int code, const std::string& message) {
  return line_of({{"jsonrpc", "2.0"}, {"id", id}, {"error", {{"code", code}, {"message", message}}}});
}

/// Deep nesting costs the parser's stack nothing, but what walks the value afterwards its own.
std::optional<Json> parsed_message(const std::string& line) {
  constexpr int deepest = 64;
  bool too_deep = false;
  Json message = Json::parse(
      line,
      [&](int depth, Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > deepest;
        return depth <= deepest;
      },
      false);
  if (message.is_discarded() || too_deep) return {};
  return message;
}

const Json& member(const Json& object, const char* name) {
  static const Json none;
  if (!object.is_object()) return none;
  const auto found = object.find(name);
  return found == object.end() ? none : *found;
}

}  // namespace

std::string failed_call(const std::string& text) {
  const Json block = {{"type", "text"}, {"text", text}};
  return line_of({{"content", Json::array({block})}, {"isError", true}});
}

struct Server::Call {
  std::string id;  ///< as JSON
  Context context;
  std::atomic<bool> ended = false;
  std::thread thread;
};

Server::Server(Service service, std::function<void(const std::string&)> send)
    : service_(std::move(service)), send_(std::move(send)) {}

Server::~Server() {
  {
    const std::lock_guard lock(calls_access_);
    for (const auto& call : calls_) call->context.cancelled = true;
  }
  finish();
}

void Server::finish() {
  std::list<std::shared_ptr<Call>> calls;
  {
    const std::lock_guard lock(calls_access_);
    calls.swap(calls_);
  }
  for (const auto& call : calls) call->thread.join();
}

void Server::send(const std::string& line) {
  const std::lock_guard lock(sending_);
  send_(line);
}

void Server::drop_ended() {
  const std::lock_guard lock(calls_access_);
  calls_.remove_if([](const auto& call) {
    if (!call->ended) return false;
    call->thread.join();
    return true;
  });
}

void Server::cancel(const std::string& id) {
  const std::lock_guard lock(calls_access_);
  for (const auto& call : calls_)
    if (call->id == id) call->context.cancelled = true;
}

void Server::start_call(const std::string& id_text, const std::string& params_text) {
  const Json id = Json::parse(id_text), params = Json::parse(params_text);
  const Json& name = member(params, "name");
  const Json tools = Json::parse(service_.tools);
  if (!name.is_string() || std::none_of(tools.begin(), tools.end(), [&](const Json& t) { return t["name"] == name; }))
    return send(error_line(id, bad_params, "there is no tool " + line_of(name)));
  drop_ended();
  auto call = std::make_shared<Call>();
  call->id = id_text;
  if (const Json& token = member(member(params, "_meta"), "progressToken"); !token.is_null()) {
    using Clock = std::chrono::steady_clock;
    // The protocol wants numbers that grow; how long a build takes nobody knows beforehand.
    call->context.progress = [this, token, begin = Clock::now(), last = Clock::time_point(), step = std::string()](
                                 const std::string& name, double share) mutable {
      const auto now = Clock::now();
      if (name == step && now - last < std::chrono::milliseconds(500)) return;
      step = name, last = now;
      const double seconds = std::chrono::duration<double>(now - begin).count();
      const std::string percent = share > 0 ? " " + std::to_string(std::lround(100 * share)) + " %" : "";
      send(line_of({{"jsonrpc", "2.0"},
                    {"method", "notifications/progress"},
                    {"params", {{"progressToken", token}, {"progress", seconds}, {"message", name + percent}}}}));
    };
  }
  const Json& given = member(params, "arguments");
  std::string arguments = given.is_null() ? "{}" : line_of(given);
  const std::lock_guard lock(calls_access_);
  if (calls_.size() >= most_calls)
    return send(answer_line(id, Json::parse(failed_call(std::to_string(calls_.size()) +
                                                        " calls are running: wait for one to end, or cancel it"))));
  calls_.push_back(call);
  call->thread =
      std::thread([this, call = call.get(), id, tool = name.get<std::string>(), arguments = std::move(arguments)] {
        const std::string result = service_.call(tool, arguments, call->context);
        if (!call->context.cancelled) send(answer_line(id, Json::parse(result)));  // a cancelled call has no answer
        call->ended = true;
      });
}

void Server::receive(const std::string& line) {
  if (line.find_first_not_of(" \t\r\n") == std::string::npos) return;
  if (line.size() > longest_message)
    return send(error_line(nullptr, no_request,
                           "expected a message of at most " + std::to_string(longest_message) + " bytes, found " +
                               std::to_string(line.size())));
  const auto message = parsed_message(line);
  if (!message) return send(error_line(nullptr, no_json, "expected one JSON message in a line"));
  const Json &id = member(*message, "id"), &method = member(*message, "method"), &params = member(*message, "params");
  const bool wants_answer = id.is_string() || id.is_number();
  if (!wants_answer && message->is_object() && message->contains("id"))
    return send(error_line(nullptr, no_request, "expected an id that is a text or a number"));
  if (!method.is_string()) {
    // An answer to a question that was not asked is ignored, as all answers are.
    if (member(*message, "result").is_null() && member(*message, "error").is_null())
      send(error_line(wants_answer ? id : Json(), no_request, "expected a request with a 'method'"));
    return;
  }
  if (!wants_answer) {
    if (method == "notifications/cancelled") cancel(line_of(member(params, "requestId")));
    return;
  }
  if (method == "initialize") {
    const Json& asked = member(params, "protocolVersion");
    constexpr std::array known = {"2024-11-05", "2025-03-26", newest_protocol};
    const bool same = std::any_of(known.begin(), known.end(), [&](const char* version) { return asked == version; });
    send(answer_line(
        id, {{"protocolVersion", same ? asked : Json(newest_protocol)},
             {"capabilities", {{"tools", Json::object()}}},
             {"serverInfo", {{"name", service_.name}, {"title", service_.title}, {"version", service_.version}}},
             {"instructions", service_.instructions}}));
  } else if (method == "ping") {
    send(answer_line(id, Json::object()));
  } else if (method == "tools/list") {
    send(answer_line(id, {{"tools", Json::parse(service_.tools)}}));
  } else if (method == "tools/call") {
    start_call(line_of(id), line_of(params));
  } else {
    send(error_line(id, no_method, "there is no method " + line_of(method)));
  }
}

}  // namespace partscribe::cli
