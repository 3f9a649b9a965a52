/// report --serve judges the script that the browser sends, and ends with Ctrl-C.
#include <catch2/catch.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "testing/program.h"

namespace partscribe::testing {

TEST_CASE("serve: an edited script is run and judged against the scan, and the file stays as it is") {
  if (find_program("curl").empty()) {
    std::cout << "skipped: curl is not installed" << std::endl;
    return;
  }
  const TemporaryDirectory folder;
  const Path f = folder.path();
  const std::string script = "include <size.scad>\nheight = 10;\ncube([width, 30, height]);\n";
  REQUIRE(write_file(f / "size.scad", "width = 40;\n").ok());
  REQUIRE(write_file(f / "block.scad", script).ok());
  REQUIRE(run_partscribe({"simulate", "block.scad", "--out", "scan", "--resolution", "64"}, f).exit_code == 0);
  REQUIRE(write_file(f / "thick.scad", "include <size.scad>\ncube([width, 30, 11]);\n").ok());
  REQUIRE(
      write_file(f / "talk.sh",
                 "\"$1\" report block.scad scan/scan.json --tolerance 0.1 --serve --json > address.json 2> log &\n"
                 "while ! grep -q address address.json; do sleep 0.1; done\n"
                 "address=$(sed 's/.*\"\\(http[^\"]*\\)\".*/\\1/' address.json)\n"
                 "curl -s \"$address\" > page.html\n"
                 "curl -s --data-binary @thick.scad -H 'Content-Type: text/plain' \"${address}verify\" > thick.json\n"
                 "curl -s \"${address}report\" > report.html\n"
                 "curl -s --data-binary @block.scad -H 'Content-Type: text/plain' \"${address}verify\" > again.json\n"
                 "kill -INT $!\nwait $!\n")
          .ok());
  Context context;
  const auto talk = run_process({"sh", "talk.sh", program().string()}, {.seconds = 120}, context, f);
  REQUIRE(talk.ok());
  CHECK(talk->exit_code == 0);
  CHECK(bytes_of(f / "page.html").find("cube([width, 30, height]);") != std::string::npos);
  CHECK(nlohmann::json::parse(bytes_of(f / "thick.json"))["outcome"] == "out_of_tolerance");
  CHECK(bytes_of(f / "report.html").find("Out of tolerance") != std::string::npos);
  CHECK(nlohmann::json::parse(bytes_of(f / "again.json"))["outcome"] == "verified");
  CHECK(bytes_of(f / "block.scad") == script);
}

}  // namespace partscribe::testing
