#include "cli/report/report_server.h"

#include <httplib.h>

#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "cli/report/report_html.h"
#include "codegen/template.h"

namespace partscribe::cli {
namespace {

constexpr std::size_t longest_script = 4 << 20;  // bytes

std::string random_word() {
  std::random_device device;
  constexpr char digits[] = "0123456789abcdef";
  std::string word;
  for (int k = 0; k < 32; ++k) word += digits[device() % 16];
  return word;
}

/// `filed`: the script before it was edited.
std::string bench_page(const Workbench& bench, const std::string& filed) {
  const auto pack = load_template_pack("bench", {});
  ensure(pack.ok(), "the bench's templates are part of the program");
  TemplateRecord data;
  data["name"] = escaped(bench.name);
  data["file"] = escaped(bench.file);
  data["script"] = escaped(bench.script);
  data["filed"] = escaped(filed);
  data["outcome"] = bench.judged.outcome;
  data["sentence"] = escaped(bench.judged.sentence);
  data["style"] = pack->files.at("bench.css");
  const std::string& program = pack->files.at("bench.js");
  data["program"] = program;
  data["policy"] = "default-src 'none'; style-src 'unsafe-inline'; frame-src 'self'; connect-src 'self'; script-src " +
                   policy_hash(program) + "; base-uri 'none'; form-action 'none'";
  auto page = pack->render("bench.html", data);
  ensure(page.ok(), page.ok() ? "" : page.error().message.c_str());
  return *page;
}

void answer_page(const std::string& page, httplib::Response& response) {
  response.set_content(page, "text/html; charset=utf-8");
}

void answer_json(const nlohmann::json& json, httplib::Response& response) {
  response.set_content(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), "application/json");
}

}  // namespace

struct BenchPort::Open {
  httplib::Server server;
  int number = -1;
};

BenchPort::BenchPort(std::unique_ptr<Open> open) : open_(std::move(open)) {}
BenchPort::BenchPort(BenchPort&&) noexcept = default;
BenchPort::~BenchPort() = default;

Result<BenchPort> BenchPort::take(int port) {
  auto open = std::make_unique<Open>();
  // By default the library shares a port with whoever asked for the same.
  open->server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  open->number = port == 0                                      ? open->server.bind_to_any_port("127.0.0.1")
                 : open->server.bind_to_port("127.0.0.1", port) ? port
                                                                : -1;
  if (open->number < 0)
    return usage_error(
        "port " + std::to_string(port) +
        " of this machine cannot be used: another program has it, or it is kept for the system (below 1024)");
  return BenchPort(std::move(open));
}

void BenchPort::serve(Workbench bench, Session& session, const std::function<void(const std::string&)>& started) {
  httplib::Server& server = open_->server;
  server.set_payload_max_length(longest_script);
  std::mutex judging;  // one script at a time
  const std::string filed = bench.script;
  const std::string base = "/" + random_word() + "/";
  const std::string host = "127.0.0.1:" + std::to_string(open_->number);
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"Referrer-Policy", "no-referrer"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"X-Frame-Options", "SAMEORIGIN"}});
  // A page elsewhere that has its own name resolved to this machine is none of ours, nor is one that sends us a script.
  server.set_pre_routing_handler([&](const httplib::Request& request, httplib::Response& response) {
    const bool own_page = !request.has_header("Origin") || request.get_header_value("Origin") == "http://" + host;
    if (own_page && request.get_header_value("Host") == host) return httplib::Server::HandlerResponse::Unhandled;
    response.status = 403;
    return httplib::Server::HandlerResponse::Handled;
  });
  server.Get(base, [&](const httplib::Request&, httplib::Response& response) {
    const std::lock_guard lock(judging);
    answer_page(bench_page(bench, filed), response);
  });
  server.Get(base + "report", [&](const httplib::Request&, httplib::Response& response) {
    const std::lock_guard lock(judging);
    answer_page(bench.judged.page, response);
  });
  server.Post(base + "verify", [&](const httplib::Request& request, httplib::Response& response) {
    const std::lock_guard lock(judging);
    auto judged = bench.judge(request.body);
    if (!judged) {
      response.status = 422;
      return answer_json({{"error", judged.error().message}}, response);
    }
    bench.script = request.body;
    bench.judged = std::move(*judged);
    answer_json({{"outcome", bench.judged.outcome}, {"sentence", bench.judged.sentence}}, response);
  });
  std::thread listening([&] { server.listen_after_bind(); });
  started("http://" + host + base);
  while (!session.context.cancelled) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  server.stop();
  listening.join();
}

}  // namespace partscribe::cli
