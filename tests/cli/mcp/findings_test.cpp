/// A verdict becomes tasks: faults alone, with the numbers of the feature that are off.
#include "cli/mcp/findings.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

namespace partscribe::testing {

using namespace cli;

TEST_CASE("findings: a fault is a task with its place and the dimensions that are off, the rest is none") {
  Verdict verdict;
  auto& bad = verdict.artifacts.emplace_back();
  bad.file = "part.scad", bad.verdict = Outcome::out_of_tolerance;
  auto& hole = bad.objects.emplace_back();
  hole.name = "hole 1";
  hole.dimensions = {{"diameter", Quantity::length, 18, 16.00005, 0.004, -2, false},
                     {"tilt", Quantity::angle, 0, pi / 2, pi / 180, 0, false},
                     {"position x", Quantity::length, 3, 3.01, 0.004, 0.01, true}};
  auto& fault = bad.findings.emplace_back();
  fault.kind = Finding::Kind::displaced, fault.feature = "hole 1", fault.text = "hole 1: diameter 18, the scan says 16";
  fault.place = {1, 2, 3}, fault.deviation = 1.00004;
  auto& unseen = bad.findings.emplace_back();
  unseen.kind = Finding::Kind::not_scanned, unseen.feature = "hole 1";
  auto& good = verdict.artifacts.emplace_back();
  good.file = "part.step", good.verdict = Outcome::verified;
  good.findings.push_back(fault);
  auto& silent = verdict.artifacts.emplace_back();
  silent.file = "part.igs", silent.verdict = Outcome::not_run, silent.reasons = {"its program is missing"};

  const auto tasks = tasks_of(verdict);
  REQUIRE(tasks.size() == 2);
  CHECK(tasks[0]["artifact"] == "part.scad");
  CHECK(tasks[0]["feature"] == "hole 1");
  CHECK(tasks[0]["kind"] == "displaced");
  CHECK(tasks[0]["text"] == "hole 1: diameter 18, the scan says 16");
  CHECK(tasks[0]["place"] == nlohmann::json({1, 2, 3}));
  CHECK(tasks[0]["deviation"] == 1);
  REQUIRE(tasks[0]["dimensions"].size() == 2);
  CHECK(tasks[0]["dimensions"][0]["artifact_says"] == 18);
  CHECK(tasks[0]["dimensions"][0]["scan_measures"] == 16.0001);
  CHECK(tasks[0]["dimensions"][1]["unit"] == "degrees");
  CHECK(tasks[0]["dimensions"][1]["scan_measures"] == 90);
  CHECK(tasks[1]["artifact"] == "part.igs");
  CHECK(tasks[1]["text"] == "its program is missing");
}

}  // namespace partscribe::testing
