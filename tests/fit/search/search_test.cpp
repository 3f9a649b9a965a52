/// What is said of rivals follows from what they cost and from what keeps them from being chosen.
#include "fit/search/search.h"

#include <catch2/catch.hpp>

#include "fit/build.h"
#include "testing/models.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

Judged costs(const std::string& procedure, double misfit, double description) {
  Judged j;
  j.candidate.procedure = procedure, j.candidate.shape = Box{1, 2, 3};
  j.evidence.misfit = misfit, j.evidence.description = description, j.evidence.local_max = 0.5;
  j.meets = true;
  return j;
}

std::string said(const Judged& winner, const Judged& rival, double outliers = 0) {
  FitInput input;
  input.tolerance = 1, input.outlier_share = outliers;
  Context context;
  return reason_of(winner, rival, input, context);
}

}  // namespace

TEST_CASE(
    "search: a rival of another procedure that costs hardly more may be the truth, one that costs much more not") {
  const Judged winner = costs("box", 100, 16);
  CHECK(said(winner, costs("wedge", 105, 20)) == "the data cannot tell: costs 9 nats more in all");
  CHECK(said(winner, costs("wedge", 150, 20)) == "costs 54 nats more in all");
  CHECK(said(winner, costs("box", 105, 20)) == "costs 9 nats more in all");  // other numbers, no other procedure
}

TEST_CASE("search: a rival whose defining face was not seen may be the truth if it costs no more") {
  const Judged winner = costs("box", 100, 16);
  Judged rival = costs("fillet", 100, 12);
  rival.meets = false, rival.open = true, rival.reason = "its concave side was hardly seen";
  CHECK(said(winner, rival) == "the data cannot tell: its concave side was hardly seen");
  rival.evidence.misfit = 200;
  CHECK(said(winner, rival) == "its concave side was hardly seen");
}

TEST_CASE("search: what is off at one place among outliers, and costs no more in all, may be the truth") {
  const Judged winner = costs("extrusion", 100, 44);
  Judged rival = costs("box", 110, 16);
  rival.meets = false, rival.reason = "deviates by 4 mm", rival.evidence.local_max = 4;
  CHECK(said(winner, rival, 0.2).find("the data cannot tell whether what it leaves out are outliers") == 0);
  CHECK(said(winner, rival) == "deviates by 4 mm");
  rival.evidence.misfit = 200;
  CHECK(said(winner, rival, 0.2) == "deviates by 4 mm");
  rival.evidence.far_out = 70;  // by points that may be outliers
  CHECK(said(winner, rival, 0.2).find("the data cannot tell") == 0);
  rival.evidence.description = 0;  // one that makes no sense was not measured
  CHECK(said(winner, rival, 0.2) == "deviates by 4 mm");
}

namespace {

/// What a build says in its log, and its model.
struct Told {
  std::string log;
  Model model;
};

Told built(Model truth) {
  truth.as_scanned = false;
  Scan scan = sampled(truth, {.points = 12000, .noise = 0.02, .reach = 45, .seed = 4});
  Told told;
  Context context;
  context.log = [&](const std::string& line) { told.log += line + "\n"; };
  BuildOptions options;
  options.tolerance = 0.15;
  auto model = build_model(scan, options, context);
  if (model) told.model = **model;
  return told;
}

bool says(const Told& told, const std::string& words) { return told.log.find(words) != std::string::npos; }

}  // namespace

TEST_CASE("search: a ball that the hypothesis calls is all that is tried") {
  const Told told = built(model_with(Sphere{20}));
  REQUIRE(told.model.objects.size() == 1);
  CHECK(std::holds_alternative<Sphere>(told.model.objects[0].shape));
  CHECK(told.model.hypothesis->suggests == "sphere");
  CHECK(says(told, "the hypothesis, sphere, explains all"));
  CHECK_FALSE(says(told, "extrude:"));
}

TEST_CASE("search: where the hypothesis is wrong the others are tried") {
  // A block without a corner: to the hypothesis it is a block.
  const Told told = built(model_with(Extrude{{{polygon({{0, 0}, {40, 0}, {40, 24}, {33, 30}, {0, 30}})}}, 20}));
  REQUIRE_FALSE(told.model.objects.empty());
  CHECK(told.model.hypothesis->suggests == "box");
  CHECK_FALSE(says(told, "explains all"));
  CHECK(says(told, "extrude:"));
  CHECK_FALSE(told.model.fallback);
  CHECK_FALSE(std::holds_alternative<Box>(told.model.objects.back().shape));
}
