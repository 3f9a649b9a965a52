/// Files of strangers: a script reads, writes and uses no more than it was promised, and a refusal is one line.
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <thread>

#include "geometry/io/read_geometry.h"
#include "testing/processes.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

/// A folder with a scan of a block in it, and a secret block outside.
struct Desk {
  TemporaryDirectory outside;
  const Path folder = outside.path() / "desk", secret = outside.path() / "secret.off";

  Desk() {
    std::filesystem::create_directories(folder / ".hidden");
    std::string points;
    for (int i = 0; i <= 20; ++i)
      for (int j = 0; j <= 15; ++j)
        for (const char* z : {" 0\n", " 10\n"}) points += std::to_string(i) + " " + std::to_string(j) + z;
    put("scan.xyz", points);
    const std::string block =
        "OFF\n8 12 0\n0 0 0\n20 0 0\n20 15 0\n0 15 0\n0 0 10\n20 0 10\n20 15 10\n0 15 10\n"
        "3 0 3 2\n3 0 2 1\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";
    REQUIRE(write_file(secret, block).ok());
    for (const char* name : {"beside.off", ".hidden/block.off", ".block.off"}) put(name, block);
    std::filesystem::create_symlink(secret, folder / "link.off");
  }
  void put(const std::string& name, const std::string& text) const { REQUIRE(write_file(folder / name, text).ok()); }

  /// The verdict, as JSON, on a script in a folder of which it names what it likes.
  ProcessOutput verdict(const std::string& script, const std::string& seconds = "20") const {
    put("part.scad", script);
    return run_partscribe({"verify", (folder / "part.scad").string(), (folder / "scan.xyz").string(), "--units", "mm",
                           "--tolerance", "0.1", "--time-limit", seconds, "--json"});
  }
};

bool can_confine() {
  if (no_confinement().empty() && !find_program("openscad").empty()) return true;
  WARN("skipped: " << (no_confinement().empty() ? "openscad is not installed" : no_confinement()));
  return false;
}

/// The lines of a text that contain `word`.
std::vector<std::string> lines_with(const std::string& text, const std::string& word) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.find(word) != std::string::npos) found.push_back(line);
  return found;
}

/// A program that stands in for OpenSCAD while the object lives: what a script could make of it at worst.
class FakeOpenscad {
 public:
  /// `body` runs in sh, with the file to write in $stl.
  explicit FakeOpenscad(const std::string& body) : path_(std::getenv("PATH")) {
    const Path file = folder_.path() / "openscad";
    REQUIRE(
        write_file(file, "#!/bin/sh\n[ \"$1\" != --version ] || { echo OpenSCAD version 1; exit; }\nstl=$2\n" + body)
            .ok());
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    ::setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~FakeOpenscad() { ::setenv("PATH", path_.c_str(), 1); }

 private:
  TemporaryDirectory folder_;
  const std::string path_;
};

}  // namespace

TEST_CASE("strangers: a script reads the files beside it that it names") {
  if (!can_confine()) return;
  const Desk desk;
  std::filesystem::create_directory(desk.folder / "lib");
  desk.put("lib/block.scad", "module block() { import(\"../beside.off\"); }");
  desk.put("sizes.scad", "length = 20;");
  for (const char* script : {"import(\"beside.off\");", "use <lib/block.scad>\nblock();",
                             "// a \" in a remark\ninclude <sizes.scad>\ncube([length, 15, 10]);"}) {
    const auto output = desk.verdict(script);
    INFO(script << output.out << output.err);
    CHECK(output.exit_code == 0);
  }
}

TEST_CASE("strangers: a script reads nothing else, and one line says what it asked for") {
  if (!can_confine()) return;
  const Desk desk;
  const std::string secret = desk.secret.string();
  const std::vector<std::pair<std::string, std::string>> scripts = {
      {"include </etc/passwd>\ncube([20, 15, 10]);", "/etc/passwd"},
      {"use </etc/shadow>\ncube([20, 15, 10]);", "/etc/shadow"},
      {"import(\"" + secret + "\");", secret},
      {"import(\"../secret.off\");", "secret.off"},
      {"import(\"link.off\");", "link.off"},
      {"import(\".block.off\");", ".block.off"},
      {"import(\".hidden/block.off\");", ".hidden/block.off"},
      {"import(str(\"besi\", \"de.off\"));", "beside.off"},  // of a name that is put together nobody knows beforehand
      {"surface(file = \"" + secret + "\");", secret}};
  for (const auto& [script, named] : scripts) {
    const auto output = desk.verdict(script);
    INFO(script << "\n" << output.out << output.err);
    CHECK(output.exit_code == 1);
    CHECK(output.err.empty());
    CHECK(lines_with(output.out, named).size() == 1);
  }
}

TEST_CASE("strangers: scripts that never end, eat memory or talk without end are not run, in their time") {
  if (!can_confine()) return;
  const Desk desk;
  const std::vector<std::string> scripts = {
      "x = [for (i = [0:99999]) for (j = [0:99999]) if (i < 0) i]; cube(len(x));",
      "x = [for (i = [0:99999]) [for (j = [0:99999]) j]]; cube(len(x));",
      "for (i = [0:9998]) for (j = [0:9998]) echo(\"WARNING\");",
  };
  for (const auto& script : scripts) {
    const auto output = desk.verdict(script, "2");
    INFO(script << "\n" << output.out << output.err);
    CHECK(output.exit_code == 4);
    CHECK(output.seconds < 15);
    CHECK(lines_with(output.out, "openscad did not finish 'part.scad' within 2 s").size() == 1);
  }
}

TEST_CASE("strangers: whatever runs in OpenSCAD's place sees no other file, writes none and reaches nobody") {
  if (!can_confine()) return;
  const Desk desk;
  const int listening = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET, address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(::bind(listening, reinterpret_cast<const sockaddr*>(&address), size) == 0);
  REQUIRE(::listen(listening, 1) == 0);
  REQUIRE(::getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  const std::string port = std::to_string(ntohs(address.sin_port));
  const FakeOpenscad fake(
      "for file in /etc/passwd '" + desk.secret.string() + "' '" + (desk.folder / ".block.off").string() + "' '" +
      (desk.folder / "beside.off").string() +
      "' \"$HOME\"/*; do cat \"$file\" > /dev/null && echo ERROR: read >&2; done\n" +
      "for folder in /etc /usr /dev / \"$HOME\"; do echo x > \"$folder/partscribe-wrote-this\" && "
      "echo ERROR: wrote >&2; done\n" +
      // Below /tmp, which is a scratch of its own there: that it arrives nowhere is looked at below.
      "echo x > '" + (desk.folder / "partscribe-wrote-this").string() + "'\n" +
      "bash -c 'echo x > /dev/tcp/127.0.0.1/" + port + "' && echo ERROR: reached >&2\n" +
      "echo WARNING: this was run >&2\n");
  const auto output = desk.verdict("cube(1);");
  INFO(output.out << output.err);
  CHECK(output.exit_code == 1);
  CHECK(lines_with(output.out, "this was run").size() == 1);
  CHECK(lines_with(output.out, "ERROR").empty());
  CHECK_FALSE(std::filesystem::exists(desk.folder / "partscribe-wrote-this"));
  ::close(listening);
}

TEST_CASE("strangers: what OpenSCAD says of its own memory is no fault of a script") {
  if (!can_confine()) return;
  const Desk desk;
  const FakeOpenscad fake(
      "case \"$*\" in *--hardwarnings*) echo \"WARNING: GeometryEvaluator: Node didn't fit into cache.\" >&2; exit 1;; "
      "esac\necho \"WARNING: GeometryEvaluator: Node didn't fit into cache.\" >&2\ncat '" +
      (desk.folder / "block.stl").string() + "' > $stl\n");
  Context context;
  const auto block = geometry::read_geometry(desk.secret, context);
  REQUIRE(block.ok());
  desk.put("block.stl", geometry::write_stl(block->mesh));
  const auto output = desk.verdict("import(\"block.stl\");");
  INFO(output.out << output.err);
  CHECK(output.exit_code == 0);
}

TEST_CASE("strangers: a program that multiplies is ended with all that it started") {
  if (!can_confine()) return;
  const Desk desk;
  const FakeOpenscad fake("while :; do sleep 301.77 & done\n");
  const auto output = desk.verdict("cube(1);", "3");
  INFO(output.out << output.err);
  CHECK(output.exit_code == 4);
  CHECK(output.seconds < 20);
  CHECK(lines_with(output.out, "'openscad'").size() + lines_with(output.out, "openscad did not finish").size() == 1);
  for (int i = 0; i < 100 && processes_with("301.77") > 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(processes_with("301.77") == 0);
}

TEST_CASE("strangers: a scan that names other people's files, or what is none, is refused in one line") {
  const Desk desk;
  REQUIRE(::mkfifo((desk.folder / "pipe.ply").c_str(), 0600) == 0);
  std::filesystem::create_symlink("/dev/zero", desk.folder / "zero.ply");
  for (const std::string named : {"/etc/passwd", "../secret.off", "link.off", "/dev/zero", "zero.ply", "pipe.ply",
                                  ".hidden", ".", ".block.off"}) {
    desk.put("scan.json", "{\"views\": [{\"file\": \"" + named + "\"}]}");
    const auto output = run_partscribe({"scan", (desk.folder / "scan.json").string(), "--out",
                                        (desk.folder / "out").string(), "--units", "mm", "--quiet"});
    INFO(named << ": " << output.err);
    CHECK(output.exit_code == 3);
    CHECK(std::ranges::count(output.err, '\n') == 1);
    CHECK(output.err.find("expected a file") != std::string::npos);
  }
}

}  // namespace partscribe::testing
