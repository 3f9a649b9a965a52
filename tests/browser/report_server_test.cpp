/// The bench in a real browser: a number is edited, verified, and the report is another; nobody else can ask.
#include "cli/report/report_server.h"

#include <catch2/catch.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/process.h"
#include "testing/chromium.h"

namespace partscribe::testing {
namespace {

using namespace cli;

/// A bench that judges by one number of its script, served while this lives.
struct Served {
  Session session{SharedOptions{}, "0"};
  std::string address;
  std::thread thread;

  Served() {
    Workbench bench{
        "pin",
        "part.scad",
        "// diameter [mm]\nshank_d = 12;\ncylinder(d = shank_d);\n",
        {"<p id='page'>good page</p>", "verified", "It fits."},
        [](const std::string& script) -> Result<BenchAnswer> {
          if (script.find("shank_d") == std::string::npos) return bad_input("expected a shank & found <none>");
          if (script.find("shank_d = 13;") == std::string::npos)
            return BenchAnswer{"<p id='page'>good page</p>", "verified", "It fits."};
          return BenchAnswer{"<p id='page'>bad page</p>", "out_of_tolerance", "The shank is 1 mm too thick."};
        }};
    std::atomic<bool> up = false;
    thread = std::thread([this, bench, &up] {
      BenchPort::take(0)->serve(bench, session, [&](const std::string& where) { address = where, up = true; });
    });
    while (!up) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ~Served() {
    session.context.cancelled = true;
    thread.join();
  }
};

/// Types a value into the field of a dimension, as a person would, and presses Verify.
void edit_and_verify(Chromium& browser, const std::string& value) {
  browser.evaluate("(() => { const field = document.querySelector('input[name=shank_d]'); field.value = '" + value +
                   "'; field.dispatchEvent(new Event('input')); })()");
  browser.point_at("#verify", 0, 0, true);
}

const char* const shown_page = "document.querySelector('#report').contentDocument?.querySelector('#page')?.textContent";

}  // namespace

TEST_CASE("report server: an edited number is verified, and verdict and report are the new ones") {
  if (find_chromium().empty()) {
    std::cout << "skipped: no Chromium is installed; script/setup --with-browser installs one" << std::endl;
    return;
  }
  Served served;
  Chromium browser;
  browser.open_address(served.address, 1400, 900);
  CHECK(browser.wait_for(std::string(shown_page) + " === 'good page'"));
  CHECK(browser.evaluate("document.querySelector('#verdict').textContent") == "It fits.");
  CHECK(browser.evaluate("document.querySelector('#numbers tbody').textContent") == "shank_ddiameter [mm]");
  edit_and_verify(browser, "13");
  CHECK(browser.wait_for("document.querySelector('#verdict').className === 'out_of_tolerance'"));
  CHECK(browser.evaluate("document.querySelector('#verdict').textContent") == "The shank is 1 mm too thick.");
  CHECK(browser.wait_for(std::string(shown_page) + " === 'bad page'"));
  CHECK(
      browser.evaluate("document.querySelector('#script').value").get<std::string>().find("shank_d = 13;\ncylinder") !=
      std::string::npos);
  browser.point_at("#undo", 0, 0, true);
  browser.point_at("#verify", 0, 0, true);
  CHECK(browser.wait_for("document.querySelector('#verdict').className === 'verified'"));
  browser.evaluate("document.querySelector('#script').value = 'sphere(1);'");
  browser.point_at("#verify", 0, 0, true);
  CHECK(browser.wait_for("document.querySelector('#verdict').textContent === 'expected a shank & found <none>'"));
  // The refusal itself is noted by browsers; nothing else may be.
  for (const auto& complaint : browser.complaints()) CHECK(complaint.find("422") != std::string::npos);
}

TEST_CASE("report server: without the random word, by another name or on a taken port it is not to be had") {
  Served served;
  if (find_program("curl").empty()) {
    std::cout << "skipped: curl is not installed" << std::endl;
    return;
  }
  const auto code = [](std::vector<std::string> more) {
    std::vector<std::string> words = {"curl", "-s", "-o", "/dev/null", "-w", "%{http_code}"};
    words.insert(words.end(), more.begin(), more.end());
    Context context;
    const auto run = run_process(words, {.seconds = 20}, context);
    REQUIRE(run.ok());
    return run->out;
  };
  const std::string host = served.address.substr(0, served.address.find('/', 7) + 1);
  CHECK(code({served.address}) == "200");
  CHECK(code({host}) == "404");
  CHECK(code({host + std::string(32, '0') + "/"}) == "404");
  CHECK(code({"-H", "Host: elsewhere.example", served.address}) == "403");
  CHECK(code({"-d", "shank_d = 12;", "-H", "Content-Type: text/plain", served.address + "verify"}) == "200");
  CHECK(code({"-d", "shank_d = 12;", "-H", "Origin: http://elsewhere.example", served.address + "verify"}) == "403");
  CHECK(code({"-d", "shank_d = 12;", "-H", "Content-Type: text/plain", host + "verify"}) == "404");
  const int port = std::stoi(host.substr(host.rfind(':') + 1));
  const auto twice = BenchPort::take(port);
  REQUIRE_FALSE(twice.ok());
  CHECK(twice.error().kind == ErrorKind::usage);
}

}  // namespace partscribe::testing
