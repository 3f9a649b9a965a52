/// mcp: the program as tools for agents, over standard input and output.
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "cli/mcp/server.h"
#include "cli/mcp/tools.h"

namespace partscribe::cli {
namespace {

constexpr const char* mcp_help =
    R"(Examples
  partscribe mcp --root ~/parts                   serve the files in ~/parts to the agent that started it
  {"mcpServers": {"partscribe": {"command": "partscribe", "args": ["mcp", "--root", "/home/me/parts"]}}}
                                                  the same in the settings that most agents read

Speaks the Model Context Protocol on standard input and output: build, verify, explain, measure and render are its
tools, with the arguments that these commands take. Paths are relative to the root, and none may lead out of it. An
agent that wrote a script asks verify, and is told what is wrong, where, by how much and on which feature, with a
picture; then it mends the script and asks again. Reports progress, can be cancelled, ends when its input does.)";

constexpr const char* instructions =
    "Partscribe judges CAD scripts against 3-D scans of real parts. To turn a scan into an editable OpenSCAD "
    "script, call build. After writing or editing a script, call verify with the script and the scan: its tasks "
    "say what is wrong, where (mm, in the scan's frame), by how much and on which feature, and what the scan "
    "measures instead; mend that and verify again until the verdict is 'verified'. measure says what faces, holes "
    "and walls a scan has; render draws anything; explain says why a model's dimensions are what they are. Paths "
    "are relative to the folder that is served.";

struct McpArguments {
  Path root = ".";
  double seconds = 3600;
};

/// Lines of standard input, each handed on when it is whole, until the input ends or the program is interrupted.
void serve(Server& server, const Context& context) {
  std::string line;
  for (;;) {
    pollfd input{0, POLLIN, 0};
    const int ready = ::poll(&input, 1, 100);
    if (context.cancelled) return;
    if (ready <= 0) continue;
    char buffer[65536];
    const auto got = ::read(0, buffer, sizeof buffer);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got <= 0) return;
    for (const char c : std::string_view(buffer, static_cast<std::size_t>(got))) {
      if (c != '\n') {
        if (line.size() <= longest_message) line += c;  // one byte more than allowed tells the server
        continue;
      }
      server.receive(line);
      line.clear();
    }
  }
}

Result<int> run_mcp(const McpArguments& given, Session& session) {
  if (const auto& o = session.options; o.tolerance || !o.units.empty() || !o.out.empty() || o.force)
    return usage_error("mcp takes no --tolerance, --units, --out or --force: they are arguments of each call");
  std::error_code failure;
  Workshop workshop;
  workshop.root = std::filesystem::canonical(given.root, failure);
  if (failure || !std::filesystem::is_directory(workshop.root))
    return bad_input(given.root.string() + ": expected a folder to serve, found none");
  workshop.program = std::filesystem::canonical("/proc/self/exe", failure);
  if (failure) return Error{"the program's own file was not found", ErrorKind::missing_program};
  workshop.limits.seconds = given.seconds;
  workshop.limits.output_mb = 64;
  workshop.limits.processes = 1 << 16;  // what a call runs has limits of its own
  if (!no_confinement().empty())
    session.warn("calls are not confined to " + workshop.root.string() + ", only their arguments are, because " +
                 no_confinement());
  if (::isatty(0))
    session.warn("waiting for messages of the Model Context Protocol; an agent's client starts this command");
  std::string advice = instructions;
  if (!no_confinement().empty())
    advice +=
        " On this machine nothing keeps a script or scan from reading files outside that folder: give it none from "
        "strangers.";
  Service service{"partscribe",
                  "Partscribe",
                  session.version,
                  advice,
                  tool_list(),
                  [&](const std::string& tool, const std::string& arguments, Context& context) {
                    return call_tool(tool, arguments, workshop, context);
                  }};
  Server server(std::move(service), [](const std::string& line) {
    std::fwrite(line.data(), 1, line.size(), stdout);
    std::fputc('\n', stdout);
    std::fflush(stdout);
  });
  serve(server, session.context);
  return 0;
}

}  // namespace

Command mcp_command() {
  auto options = std::make_shared<McpArguments>();
  return {"mcp", "serve build, verify, explain, measure and render to agents (Model Context Protocol)", mcp_help,
          [options](Arguments& a) {
            a.path(options->root, "--root", "DIR",
                   "the only folder that calls can read and write (default: the current one)");
            a.number(options->seconds, "--time-limit", "SECONDS", 1, 1e6, "for each call (default 3600)");
          },
          [options](Session& session) { return run_mcp(*options, session); }};
}

}  // namespace partscribe::cli
