/// Other programs stay within their limits, see what they may see, and leave nothing running.
#include "core/process.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "core/number.h"
#include "core/sanitized.h"
#include "testing/processes.h"

namespace partscribe::testing {

using namespace core;

namespace {

ProcessOutput ran(const std::vector<std::string>& arguments, const ProcessLimits& limits = {.seconds = 20}) {
  Context context;
  auto output = run_process(arguments, limits, context);
  REQUIRE(output.ok());
  return std::move(output).value();
}

ProcessOutput shell(const std::string& script, const ProcessLimits& limits = {.seconds = 20}) {
  return ran({"sh", "-c", script}, limits);
}

bool runs(const std::string& pid) {
  return std::filesystem::exists(Path("/proc") / pid / "stat") && shell("kill -0 " + pid).exit_code == 0;
}

/// Whether the process ends within two seconds.
bool ends(const std::string& pid) {
  for (int i = 0; i < 200; ++i) {
    if (!runs(pid)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace

TEST_CASE("process: output, exit code and missing programs") {
  const auto good = shell("echo out; echo err >&2; exit 3");
  CHECK(good.exit_code == 3);
  CHECK(good.out == "out\n");
  CHECK(good.err == "err\n");
  Context context;
  const auto missing = run_process({"no-such-program-here"}, {}, context);
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().kind == ErrorKind::missing_program);
}

TEST_CASE("process: a program that never ends is ended") {
  const auto result = ran({"sleep", "60"}, {.seconds = 0.3});
  CHECK(result.timed_out);
  CHECK(result.exit_code == 128 + 9);
}

TEST_CASE("process: cancelling stops the wait") {
  Context context;
  context.cancelled = true;
  const auto result = run_process({"sleep", "60"}, {}, context);
  REQUIRE_FALSE(result.ok());
  CHECK(result.error().kind == ErrorKind::stopped);
}

TEST_CASE("process: what a program leaves running, with its output open, neither holds us up nor lives on") {
  const auto result = shell("sleep 300 & echo $!; exit 4");
  CHECK(result.exit_code == 4);
  CHECK(result.seconds < 10);
  CHECK_FALSE(result.timed_out);
  const std::string pid = result.out.substr(0, result.out.find('\n'));
  REQUIRE(parse_number(pid).has_value());
  CHECK(ends(pid));
}

TEST_CASE("process: no descriptor but the three, and of the environment only what finds files") {
  ::setenv("PARTSCRIBE_SECRET", "token", 1);
  const auto result = shell("ls /proc/self/fd | wc -l; env");
  ::unsetenv("PARTSCRIBE_SECRET");
  CHECK(result.out.starts_with("4\n"));  // three, and the one that ls reads
  CHECK(result.out.find("PATH=") != std::string::npos);
  CHECK(result.out.find("token") == std::string::npos);
}

TEST_CASE("process: files and memory are limited") {
  const TemporaryDirectory folder;
  const Path file = folder.path() / "large";
  const auto output = shell("dd if=/dev/zero of=" + file.string() + " bs=1M count=64", {.seconds = 20, .file_mb = 8});
  CHECK(output.exit_code != 0);
  CHECK(std::filesystem::file_size(file) <= 8 << 20);
  if (sanitized) return;
  CHECK(shell("dd if=/dev/zero of=/dev/null bs=512M count=1", {.seconds = 20, .memory_mb = 128}).exit_code != 0);
}

TEST_CASE("process: a program ends when the one that started it is killed") {
  const TemporaryDirectory folder;
  const Path pid = folder.path() / "pid";
  // This test program once more starts the child, and is killed.
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  shell("CHILD_PID=" + pid.string() + "; export XDG_CHILD_PID=$CHILD_PID; '" + self +
        "' '[.leaves a child]' & parent=$!; " +
        "for i in $(seq 200); do [ -s $CHILD_PID ] && break; sleep 0.05; done; kill -9 $parent; wait $parent");
  const auto text = read_file(pid);
  REQUIRE(text.ok());
  const std::string child = text->substr(0, text->find('\n'));
  REQUIRE(parse_number(child).has_value());
  CHECK(ends(child));
}

TEST_CASE("process: a child to be left behind", "[.leaves a child]") {
  const char* file = std::getenv("XDG_CHILD_PID");
  if (file) shell("echo $$ > " + std::string(file) + "; exec sleep 300", {.seconds = 300});
}

TEST_CASE("process: a confined program sees the files that were named, and neither others nor the network") {
  if (!no_confinement().empty()) {
    WARN("skipped: " << no_confinement());
    return;
  }
  const TemporaryDirectory named, other, scratch;
  REQUIRE(write_file(named.path() / "a", "named").ok());
  REQUIRE(write_file(other.path() / "b", "other").ok());
  Context context;
  const auto output = run_confined({"sh", "-c",
                                    "cat " + (named.path() / "a").string() + "; cat " + (other.path() / "b").string() +
                                        "; cat /etc/passwd; echo x > out; echo x > " + (named.path() / "c").string() +
                                        "; echo x > /usr/c; ls /sys/class/net; ls $HOME; grep -c : /proc/net/dev"},
                                   {.seconds = 20}, {{named.path()}, {scratch.path()}}, context);
  REQUIRE(output.ok());
  INFO(output->out << output->err);
  CHECK(output->out == "named1\n");  // and of the network the loop to itself
  CHECK(read_file(scratch.path() / "out")->starts_with("x"));
  CHECK_FALSE(std::filesystem::exists(named.path() / "c"));
  CHECK_FALSE(std::filesystem::exists("/usr/c"));
}

TEST_CASE("process: a confined program that never ends is ended with all that it started") {
  if (!no_confinement().empty()) {
    WARN("skipped: " << no_confinement());
    return;
  }
  const TemporaryDirectory scratch;
  Context context;
  const auto output = run_confined({"sh", "-c", "(setsid sleep 301.25 &); sleep 302.25"}, {.seconds = 0.5},
                                   {{}, {scratch.path()}}, context);
  REQUIRE(output.ok());
  CHECK(output->timed_out);
  bool left = true;
  for (int i = 0; left && i < 200; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(10)))
    left = processes_with("301.25") + processes_with("302.25") > 0;
  CHECK_FALSE(left);
}

TEST_CASE(
    "process: a confined program sees named files where it has folders of its own, and writes nothing beside them") {
  if (!no_confinement().empty()) {
    WARN("skipped: " << no_confinement());
    return;
  }
  for (const Path within : {"/tmp", "/dev/shm"}) {
    if (!std::filesystem::exists(within)) continue;
    const Path named = within / ("partscribe-named-" + std::to_string(::getpid()));
    REQUIRE(write_file(named, "named").ok());
    const TemporaryDirectory scratch;
    Context context;
    const auto output = run_confined({"sh", "-c",
                                      "cat " + named.string() +
                                          "; for folder in / /dev /dev/shm /home; do echo x > $folder/x && echo wrote; "
                                          "done; echo x > /dev/null; head -c 300000000 /dev/zero > /tmp/large"},
                                     {.seconds = 20}, {{named}, {scratch.path()}}, context);
    std::filesystem::remove(named);
    REQUIRE(output.ok());
    INFO(output->err);
    CHECK(output->out == "named");
    CHECK(output->err.find("No space left on device") != std::string::npos);
  }
}

TEST_CASE("process: a confined program that fills its folder, with large files or many, is ended") {
  const TemporaryDirectory scratch;
  Context context;
  for (const char* script :
       {"while :; do i=x$i; head -c 100000 /dev/zero > $i; done", "seq 400000 | split -l 1 -a 4; sleep 60"}) {
    const auto output =
        run_confined({"sh", "-c", script}, {.seconds = 60, .file_mb = 8}, {{}, {scratch.path()}}, context);
    REQUIRE_FALSE(output.ok());
    CHECK(output.error().kind == ErrorKind::stopped);
    CHECK(output.error().message.starts_with("'sh' wrote more than "));
  }
}

TEST_CASE("process: what lies in a shared folder is not the program's, which starts there and may write") {
  const TemporaryDirectory scratch, shared;
  REQUIRE(write_file(shared.path() / "others", std::string(3 << 20, 'x')).ok());
  Context context;
  const auto output = run_confined({"sh", "-c", "echo mine > mine; sleep 1; pwd"}, {.seconds = 20, .file_mb = 1},
                                   {{}, {scratch.path()}, {shared.path()}}, context);
  REQUIRE(output.ok());
  CHECK(output->out == std::filesystem::canonical(shared.path()).string() + "\n");
  CHECK(std::filesystem::exists(shared.path() / "mine"));
}

TEST_CASE("process: a program that multiplies is ended with all that it started") {
  Context context;
  const auto output =
      run_process({"sh", "-c", "while :; do sleep 301.5 & done"}, {.seconds = 5, .processes = 100}, context);
  if (output.ok())  // whoever is not root is refused more by the system
    CHECK(output->seconds < 6);
  else
    CHECK(output.error().message == "'sh' started more than 100 processes");
  for (int i = 0; i < 200 && processes_with("301.5") > 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  CHECK(processes_with("301.5") == 0);
}

}  // namespace partscribe::testing
