/// The server answers by JSON-RPC and the protocol, whatever it is sent.
#include "cli/mcp/server.h"

#include <catch2/catch.hpp>
#include <condition_variable>
#include <nlohmann/json.hpp>

namespace partscribe::testing {
namespace {

using namespace cli;
using Json = nlohmann::json;

/// A server whose one tool, "wait", ends when it is cancelled or told to, and what it has sent.
struct Talk {
  std::mutex access;
  std::condition_variable changed;
  std::vector<Json> sent;
  bool let_go = false;
  Server server{
      {"name", "Title", "1.2.3", "Wait well.", R"([{"name": "wait", "inputSchema": {"type": "object"}}])",
       [this](const std::string&, const std::string& arguments, Context& context) {
         context.report("waiting", 0.25);
         std::unique_lock lock(access);
         while (!changed.wait_for(lock, std::chrono::milliseconds(5), [&] { return let_go || context.cancelled; })) {
         }
         return Json{{"content", Json::array()}, {"structuredContent", Json::parse(arguments)}}.dump();
       }},
      [this](const std::string& line) {
        CHECK(line.find('\n') == std::string::npos);
        const std::lock_guard lock(access);
        sent.push_back(Json::parse(line));
      }};

  Json answer_to(const std::string& message) {
    const std::size_t before = sent.size();
    server.receive(message);
    return sent.size() == before + 1 ? sent.back() : Json();
  }
  void release() {
    {
      const std::lock_guard lock(access);
      let_go = true;
    }
    changed.notify_all();
    server.finish();
  }
};

std::string call_message(const std::string& id, const std::string& more = {}) {
  return R"({"jsonrpc": "2.0", "id": )" + id +
         R"(, "method": "tools/call", "params": {"name": "wait", "arguments": {"id": )" + id + "}" + more + "}}";
}

}  // namespace

TEST_CASE("mcp server: introduces itself in the revision that was asked for, or in the newest it knows") {
  Talk talk;
  for (const auto& [asked, given] : {std::pair("2024-11-05", "2024-11-05"), std::pair("2031-01-01", newest_protocol)}) {
    const auto answer = talk.answer_to(R"({"jsonrpc": "2.0", "id": "a", "method": "initialize", "params":
        {"protocolVersion": ")" + std::string(asked) +
                                       R"(", "capabilities": {}}})");
    CHECK(answer["id"] == "a");
    CHECK(answer["result"]["protocolVersion"] == given);
    CHECK(answer["result"]["serverInfo"]["version"] == "1.2.3");
    CHECK(answer["result"]["instructions"] == "Wait well.");
    CHECK(answer["result"]["capabilities"].contains("tools"));
  }
  CHECK(talk.answer_to(R"({"jsonrpc": "2.0", "id": 2, "method": "tools/list"})")["result"]["tools"][0]["name"] ==
        "wait");
  CHECK(talk.answer_to(R"({"jsonrpc": "2.0", "id": 3, "method": "ping"})")["result"] == Json::object());
  CHECK(talk.answer_to(R"({"jsonrpc": "2.0", "method": "notifications/initialized"})").is_null());
}

TEST_CASE("mcp server: what is no request gets the error that JSON-RPC has for it, and the server goes on") {
  Talk talk;
  const auto code = [&](const std::string& message) {
    return talk.answer_to(message).value("/error/code"_json_pointer, 0);
  };
  CHECK(code("{") == -32700);
  CHECK(code("\xff\xfe") == -32700);
  CHECK(code(std::string(100000, '[')) == -32700);
  CHECK(code(std::string(200, '[') + std::string(200, ']')) == -32700);
  CHECK(code("[]") == -32600);
  CHECK(code("7") == -32600);
  CHECK(code(R"({"id": 1})") == -32600);
  CHECK(code(R"({"id": null, "method": "ping"})") == -32600);
  CHECK(code(R"({"id": {}, "method": "ping"})") == -32600);
  CHECK(code(std::string(longest_message + 1, ' ') + "x") == -32600);
  CHECK(code(R"({"id": 1, "method": "resources/list"})") == -32601);
  CHECK(code(R"({"id": 1, "method": "tools/call"})") == -32602);
  CHECK(code(R"({"id": 1, "method": "tools/call", "params": {"name": "dig"}})") == -32602);
  CHECK(talk.answer_to(R"({"id": 1, "result": {}})").is_null());
  CHECK(talk.answer_to("  ").is_null());
  CHECK(talk.answer_to(R"({"id": 9, "method": "ping"})")["id"] == 9);
}

TEST_CASE("mcp server: a call that runs keeps nobody waiting, reports its progress and is answered at its end") {
  Talk talk;
  talk.server.receive(call_message("1", R"(, "_meta": {"progressToken": "t"})"));
  CHECK(talk.answer_to(R"({"id": 2, "method": "ping"})")["id"] == 2);
  talk.release();
  REQUIRE(talk.sent.size() == 3);
  const auto progress =
      std::find_if(talk.sent.begin(), talk.sent.end(), [](const Json& m) { return m.contains("method"); });
  REQUIRE(progress != talk.sent.end());
  CHECK((*progress)["params"]["progressToken"] == "t");
  CHECK((*progress)["params"]["message"] == "waiting 25 %");
  CHECK(talk.sent.back()["result"]["structuredContent"]["id"] == 1);
}

TEST_CASE("mcp server: a cancelled call ends without an answer, and no other one") {
  Talk talk;
  talk.server.receive(call_message("1"));
  talk.server.receive(call_message("\"1\""));
  talk.server.receive(R"({"method": "notifications/cancelled", "params": {"requestId": 1}})");
  talk.release();
  REQUIRE(talk.sent.size() == 1);
  CHECK(talk.sent[0]["id"] == "1");
}

TEST_CASE("mcp server: more calls than it runs at a time are refused, and ended ones make room") {
  Talk talk;
  for (std::size_t k = 0; k < most_calls; ++k) talk.server.receive(call_message(std::to_string(k)));
  const auto refused = talk.answer_to(call_message("99"));
  CHECK(refused["id"] == 99);
  CHECK(refused["result"]["isError"] == true);
  talk.release();
  talk.server.receive(call_message("100"));
  talk.server.finish();
  CHECK(talk.sent.back()["id"] == 100);
}

}  // namespace partscribe::testing
