/// A verifier that never refused has verified nothing: damaged parts and damaged files, written by every backend and
/// run by its own program, against a scan of the true part; and edits that change nothing.
///
/// Here one damage of each kind goes through the backends in turn, on parts whose programs run in a fraction of a
/// second: every kind and every backend at least once. The full matrix is bench/damage.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <iostream>
#include <set>

#include "core/files.h"
#include "testing/damage/parts.h"
#include "testing/damage/suite.h"
#include "testing/models.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

std::size_t count_of(const std::vector<Mutation>& mutations, std::initializer_list<Mutation::Kind> kinds) {
  return static_cast<std::size_t>(std::count_if(mutations.begin(), mutations.end(), [&](const Mutation& m) {
    return std::find(kinds.begin(), kinds.end(), m.kind) != kinds.end();
  }));
}

void refuses(const std::string& part, const SuiteOptions& options, std::set<std::string>& kinds) {
  for (const auto& c : damage_part(part, options)) {
    INFO(line_of(c));
    CHECK(c.kept == c.harmless);
    if (!c.harmless) {
      CHECK(c.named);
      kinds.insert(c.kind);
    }
  }
}

}  // namespace

TEST_CASE("mutation: damages of a model are refused through every backend, and the right feature is named") {
  SuiteOptions options;
  options.files = false;
  options.most = 1;
  options.in_turn = true;
  std::set<std::string> kinds;
  for (const auto& part : {"block", "pin", "cowl"}) refuses(part, options, kinds);
  CHECK(kinds.size() >= 15);
}

TEST_CASE("mutation: so are those of all parts", "[.statistics]") {
  SuiteOptions options;
  options.files = false;
  options.most = 1;
  options.in_turn = true;
  std::set<std::string> kinds;
  for (const auto& part : {"block", "pin", "half_spaces", "tri_surface", "cowl", "cushion"})
    refuses(part, options, kinds);
  CHECK(kinds.size() >= 18);
}

TEST_CASE("mutation: damages of a file are refused, and the reason says what is wrong") {
  SuiteOptions options;
  options.models = false;
  options.most = 1;
  std::set<std::string> kinds;
  refuses("half_spaces", options, kinds);
  options.backends = {"openscad", "alpha1"};  // a triangulation's facets stand in these texts one by one
  refuses("tri_surface", options, kinds);
  CHECK(kinds.size() >= 15);
}

TEST_CASE("mutation: one coordinate of a STEP or IGES file that was changed is refused, though the reader mends it") {
  SuiteOptions options;
  options.models = false;
  options.most = 5;
  options.backends = {"iges", "step"};
  options.kinds = {"coordinate changed"};
  std::set<std::string> kinds;
  refuses("cone", options, kinds);
  CHECK(kinds.size() == 1);
}

TEST_CASE("mutation: every visible parameter is damaged, every bore can be missing, a chiral part has three mirrors") {
  using Kind = Mutation::Kind;
  const auto bracket = mutations_of(golden_part("bracket"));
  CHECK(count_of(bracket, {Kind::parameter}) == 7);        // all but the overshoot of the cuts
  CHECK(count_of(bracket, {Kind::feature_missing}) == 5);  // both plates, three bores
  CHECK(count_of(bracket, {Kind::mirrored}) == 2);         // it is its own mirror image across its width
  CHECK(count_of(bracket, {Kind::hole_size}) == 3);
  CHECK(count_of(bracket, {Kind::hole_added}) == 2);
  CHECK(count_of(mutations_of(golden_part("half_spaces")), {Kind::mirrored}) == 3);
  CHECK(count_of(mutations_of(golden_part("tie_bar")), {Kind::feature_missing, Kind::edge_missing}) == 2);
  CHECK(count_of(mutations_of(golden_part("sphere")), {Kind::mirrored}) == 0);
}

TEST_CASE(
    "mutation: each copy of a pattern can be missing, its count be wrong, a size that follows from others be off") {
  const auto flange = mutations_of(golden_part("flange"));
  auto has = [&](const std::string& name) {
    return std::any_of(flange.begin(), flange.end(), [&](const Mutation& m) { return m.name.rfind(name, 0) == 0; });
  };
  for (int copy = 1; copy <= 6; ++copy) CHECK(has("without bolt_holes_" + std::to_string(copy)));
  CHECK(has("bolts one fewer"));
  CHECK(has("bolts one more"));
  CHECK(has("bolt_circle_r "));
  CHECK(has("bolt_step "));
}

TEST_CASE("mutation: a draft is damaged like other sizes, and the walls that lean are named") {
  const Loop outline = polygon({{0, 0}, {30, 0}, {30, 20}, {0, 20}});
  const Loop bore{"bore", {SketchArc{12, 8, 3, 2 * pi, 0, "bore", ""}}};
  Model plug = model_with(Extrude{{{outline, bore}}, 12, 0, Expr::of("draft")}, {length("draft", 0.1)});
  plug.parameters[0].quantity = Quantity::angle;
  plug.tolerance = 0.1;
  int found = 0;
  for (const auto& m : mutations_of(plug)) {
    if (m.kind != Mutation::Kind::parameter) continue;
    INFO(m.name);
    CHECK(m.moved > 1.5 * plug.tolerance);
    const auto harm = harm_of(plug, m.model, plug.tolerance);
    CHECK(std::count(harm.faces.begin(), harm.faces.end(), "bore") == 1);
    CHECK(std::count(harm.faces.begin(), harm.faces.end(), "bottom") == 0);
    ++found;
  }
  CHECK(found == 1);
}

TEST_CASE("mutation: a damage moves the surface by as much as it says") {
  const Model pin = golden_part("pin");
  for (const auto& m : mutations_of(pin)) {
    INFO(m.name);
    if (m.kind == Mutation::Kind::harmless)
      CHECK(m.moved < 0.15 * pin.tolerance);
    else
      CHECK(m.moved > 1.5 * pin.tolerance);
  }
  // Half a percent about the middle of a bar of 80 mm: 0.2 mm at its ends.
  Model cylinder = golden_part("cylinder");
  cylinder.tolerance = 0.1;
  const auto bar = mutations_of(cylinder);
  const auto scaled =
      std::find_if(bar.begin(), bar.end(), [](const Mutation& m) { return m.kind == Mutation::Kind::scaled; });
  REQUIRE(scaled != bar.end());
  CHECK(scaled->name == "scaled by 1.005");
  CHECK(scaled->moved == Approx(0.2).epsilon(0.01));
}

TEST_CASE("mutation: a damage knows the faces it hits") {
  const Model bracket = golden_part("bracket");
  for (const auto& m : mutations_of(bracket)) {
    if (m.kind == Mutation::Kind::harmless || (m.name != "without eye" && m.name.rfind("height", 0) != 0)) continue;
    const auto harm = harm_of(bracket, m.model, bracket.tolerance);
    INFO(m.name);
    REQUIRE(!harm.faces.empty());
    if (m.name == "without eye") CHECK(harm.faces[0] == "eye side");
    if (m.kind == Mutation::Kind::parameter) CHECK(std::count(harm.faces.begin(), harm.faces.end(), "wall top") == 1);
  }
}

TEST_CASE("mutation: points of a surface are as dense everywhere as its area says") {
  const Model bar = golden_part("cylinder");  // radius 12, length 80
  const Pose part_from_scan = evaluate(bar.scan_from_part, values_of(bar)).inverse();
  const auto points = surface_points(bar, 20000, 1);
  std::size_t ends = 0;
  for (const auto& p : points) {
    const Vec3 q = part_from_scan * p.point;
    const bool on_end = std::abs(q.z()) < 1e-6 || std::abs(q.z() - 80) < 1e-6;
    ends += on_end;
    if (!on_end) CHECK(std::hypot(q.x(), q.y()) == Approx(12).epsilon(1e-8));
  }
  CHECK(double(ends) / 20000 == Approx(12.0 / (12 + 80)).epsilon(0.06));
}
