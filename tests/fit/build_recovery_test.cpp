/// Hard scans of known parts: what is found is right, or says that it cannot tell.
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"
#include "fit/build.h"
#include "testing/models.h"
#include "testing/recovery/facets.h"
#include "testing/recovery/parts.h"
#include "testing/recovery/score.h"
#include "testing/sampled.h"

namespace partscribe::testing {

using namespace fit;

namespace {

using namespace recovery;
using partscribe::testing::model_with, partscribe::testing::reasons;

/// One simulated scan of a known part.
struct Run {
  const char* kind;
  Conditions conditions;
  std::uint64_t seed;
};

void check_right(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    Context context;
    const Score score = recovered(make_case(run.kind, run.conditions, run.seed), context);
    INFO(run.kind << " " << run.seed << ": " << score.found << " " << score.why);
    CHECK(score.answer == Answer::right);
  }
}

/// Of plates among outliers another body may be told, as long as the plate is named beside it.
void check_not_wrong(const std::vector<std::uint64_t>& seeds) {
  for (const std::uint64_t seed : seeds) {
    Context context;
    const Score score = recovered(make_case("extrude", hardest_conditions(), seed), context);
    INFO(seed << ": " << score.found << " " << score.why);
    CHECK(score.answer != Answer::wrong);
  }
}

/// Hard scans of ten kinds with each of the seeds, of which all but `spared` are to be right and none wrong.
void check_kinds(std::uint64_t seeds, std::size_t spared) {
  std::size_t runs = 0, right = 0, wrong = 0;
  std::string report;
  for (const auto& kind :
       {"sphere", "ellipsoid", "box", "wedge", "cylinder", "cone", "torus", "half_spaces", "revolve", "extrude"})
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const Case c = make_case(kind, standard_conditions(), seed);
      Context context;
      const Score score = recovered(c, context);
      ++runs, right += score.answer == Answer::right, wrong += score.answer == Answer::wrong;
      if (score.answer != Answer::right)
        report += std::string(kind) + " " + std::to_string(seed) + ": " + name_of(score.answer) + ", " + score.found +
                  " " + score.why + "\n";
    }
  INFO(report);
  CHECK(runs == 10 * seeds);
  CHECK(right + spared >= runs);
  CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("recovery: of a hard scan of each kind with a third unseen at most one is undecided, none a wrong answer") {
  check_kinds(1, 1);
}

TEST_CASE(
    "recovery: of thirty hard scans with a third unseen at least 28 give the right kind and numbers, none a wrong "
    "answer",
    "[.statistics]") {
  check_kinds(3, 2);
}

TEST_CASE("recovery: among 30 % outliers, two thirds hidden, plates keep their holes and rounded bodies their axes") {
  check_right({{"extrude", hardest_conditions(), 12}, {"superellipsoid", hardest_conditions(), 3}});
}

TEST_CASE("recovery: two faces of a polyhedron may be a rounded block, and the model says what else") {
  const Case c = make_case("half_spaces", hardest_conditions(), 20);
  Context context;
  const Score score = recovered(c, context);
  REQUIRE(score.model);
  const std::string said = reasons(**score.model);
  INFO(said);
  CHECK(score.answer == Answer::cannot_tell);
  CHECK(said.find("convex polyhedron: the data cannot tell: 2 plane faces hold nearly all points") !=
        std::string::npos);
}

TEST_CASE("recovery: the end of a plate that nobody saw lies where its walls end, not where the last outlier does") {
  const Case c = make_case("extrude", hardest_conditions(), 15);
  Context context;
  const Score score = recovered(c, context);
  REQUIRE(score.model);
  const Model& model = **score.model;
  const auto height = std::find_if(model.parameters.begin(), model.parameters.end(),
                                   [](const Parameter& p) { return p.name == "height" || p.name == "thickness"; });
  REQUIRE(height != model.parameters.end());
  CHECK(height->fitted == Approx(c.truth.parameters.back().value).margin(1.5));
  CHECK(height->note.find("not scanned") != std::string::npos);
  CHECK(height->sigma > 0);
}

TEST_CASE("recovery: a block is none whose side is folded into a wing that meets itself at a corner") {
  // Within the noise a fold has three sheets, which follow one face's points more closely than the face does.
  Context context;
  const Score score = recovered(make_case("box", standard_conditions(), 39), context);
  INFO(score.found << " " << score.why);
  CHECK(score.answer == Answer::right);
  CHECK(score.found == "box");
}

TEST_CASE("recovery: a face of a polyhedron that few points show is one, and no side that nobody saw cuts across it") {
  // Of one face 24 points of 3,900 are about.
  check_right({{"half_spaces", standard_conditions(), 152}});
}

TEST_CASE("recovery: the step of a turned part that 63 points of 3,800 show is no heap of outliers") {
  // So sparse that no local plane holds its neighbours: all of them pass for outliers, and a plain rod is within
  // tolerance of the others.
  check_right({{"revolve", standard_conditions(), 204}});
}

TEST_CASE("recovery: the wall of a thin step is no piece of the axis") {
  // Its end was hardly seen: the wall goes no further, not on to where it would meet the axis, 640 mm away.
  check_right({{"revolve", standard_conditions(), 242}});
}

TEST_CASE("recovery: a neck between two collars that 24 points of 3,700 show is one") {
  check_right({{"revolve", standard_conditions(), 121}});
}

TEST_CASE("recovery: an angle of which no wall of the notch was seen is not said to be a block and nothing else") {
  Context context;
  CHECK(recovered(make_case("extrude", standard_conditions(), 98), context).answer != Answer::wrong);
}

TEST_CASE("recovery: outliers that fill a box hardly thicker than the noise is wide are outliers") {
  // Outliers in so flat a box hold one another: hardly a tenth of the points seemed to be any, and what is sparse was
  // kept.
  check_right({{"extrude", hardest_conditions(), 143}});
}

TEST_CASE("recovery: sides of a plate that its rounds tell move with them") {
  check_right({{"extrude", standard_conditions(), 37}});
}

TEST_CASE("recovery: the end of a block that nobody saw stays where the data end") {
  // The slope of this wedge was not seen. Outliers beside the end of what else was drew the block's end in, across five
  // points of its foot.
  const Case c = make_case("wedge", standard_conditions(), 62);
  Context context;
  const Score score = recovered(c, context);
  REQUIRE(score.model);
  INFO(score.found << " " << score.why);
  CHECK(score.answer == Answer::cannot_tell);
  const Model& model = **score.model;
  const ModelDistance surface(model);
  double farthest = 0;
  for (const Vec3& p : c.exact) farthest = std::max(farthest, std::abs(surface(p).distance));
  CHECK(farthest < 0.25);
  const auto end = std::max_element(model.parameters.begin(), model.parameters.end(),
                                    [](const Parameter& a, const Parameter& b) { return a.sigma < b.sigma; });
  CHECK(end->fitted == Approx(c.truth.parameters[0].value).margin(0.05));
  CHECK(end->sigma > 0.5 * std::abs(end->fitted - c.truth.parameters[0].value));
  CHECK(end->sigma < 3);
  CHECK(end->note.find("not scanned") != std::string::npos);
}

TEST_CASE(
    "recovery: a curtain of outliers behind the edges of a plate leaves its end open, and does not make another "
    "plate") {
  const Case c = make_case("extrude", hardest_conditions(), 55);
  Context context;
  const Score score = recovered(c, context);
  REQUIRE(score.model);
  CHECK(score.answer == Answer::right);
  const Model& model = **score.model;
  const auto height = std::find_if(model.parameters.begin(), model.parameters.end(),
                                   [](const Parameter& p) { return p.name == "height" || p.name == "thickness"; });
  REQUIRE(height != model.parameters.end());
  const double true_height = c.truth.parameters.back().value;
  CHECK(height->fitted > true_height);
  CHECK(height->sigma > 0.5 * (height->fitted - true_height));
}

TEST_CASE("recovery: a ring with corners and a fillet come back from hard scans, a fillet from a coarse mesh") {
  check_right({{"supertoroid", standard_conditions(), 1},
               {"fillet", standard_conditions(), 5},
               {"fillet", facet_conditions(), 2}});
}

TEST_CASE("recovery: what is claimed of one hard scan holds for others of its kind", "[.statistics]") {
  check_right({{"extrude", hardest_conditions(), 28},
               {"extrude", hardest_conditions(), 49},
               {"superellipsoid", hardest_conditions(), 8},
               {"half_spaces", standard_conditions(), 129},
               {"revolve", standard_conditions(), 223},
               {"revolve", hardest_conditions(), 77},
               {"extrude", standard_conditions(), 198},
               {"extrude", hardest_conditions(), 168}});
  // A box is 5 nats ahead of the plate, which ends better than another box, which is 3 ahead of the first.
  check_right({{"extrude", standard_conditions(), 141}});
  // The last steps led a plate that was swept across another way to one that costs 90 nats more than the right one.
  check_right({{"extrude", hardest_conditions(), 140}});
  // Of ring 54 an extrusion is within the tolerance too, though only just; so is one of hard ring 84, and a polyhedron
  // of 37, as outliers go. Of fillet 200 a rod of no radius is proposed. Of 38 and 83 no leg was seen, of 51 an
  // extrusion with a folded leg follows the noise, and of 116 the points of one end were taken for outliers.
  check_right({{"supertoroid", standard_conditions(), 54},
               {"supertoroid", hardest_conditions(), 37},
               {"supertoroid", hardest_conditions(), 84},
               {"fillet", standard_conditions(), 38},
               {"fillet", standard_conditions(), 51},
               {"fillet", standard_conditions(), 83},
               {"fillet", standard_conditions(), 116},
               {"fillet", standard_conditions(), 200}});
}

TEST_CASE("recovery: parts that are nearly of another kind are told from it, or the model says that it cannot tell") {
  for (const auto& [kind, seed, answer] :
       {std::tuple{"torus_fat", 1, Answer::right}, std::tuple{"cylinder_30deg", 3, Answer::cannot_tell},
        std::tuple{"ellipsoid_round", 4, Answer::cannot_tell}}) {
    Context context;
    const Score score = recovered(make_case(kind, standard_conditions(), static_cast<std::uint64_t>(seed)), context);
    INFO(kind << " " << seed << ": " << score.found << " " << score.why);
    CHECK(score.answer == answer);
  }
}

TEST_CASE("recovery: coarse meshes are closed, with their corners on the part and as far below it as their bends say") {
  for (const auto& kind : kinds()) {
    Random random(11);
    const Part part = random_part(kind, random);
    const TriangleMesh mesh = coarse_mesh(part.model, 24);
    INFO(kind);
    CHECK(topology(mesh).closed());
    const ModelDistance distance(part.model);
    double off = 0;
    for (const Vec3& v : mesh.vertices) off = std::max(off, std::abs(distance(v).distance));
    CHECK(off < 1e-6);
    CHECK(sagitta_of(mesh, part.model) < 0.05 * part.bounds.diagonal());
    CHECK(area(without_far_side(mesh, {1, 2, 3}, 1.0 / 3)) < 0.8 * area(mesh));
  }
}

TEST_CASE("recovery: a fillet of which the concave side was not seen is a block") {
  Scan scan = sampled(model_with(Box{30, 20, 10}), {.points = 3000, .noise = 0.05, .reach = 20, .seed = 4});
  // Only two faces of the block and a strip of the third.
  for (std::size_t i = scan.cloud.size(); i-- > 0;) {
    const Vec3& p = scan.cloud.points[i];
    if (p.x() > 1 && p.y() > 1) scan.cloud.points.erase(scan.cloud.points.begin() + static_cast<std::ptrdiff_t>(i));
  }
  Context context;
  BuildOptions options;
  options.tolerance = 0.25, options.force = "fillet", options.triangulate = false;
  CHECK_FALSE(build_model(scan, options, context));
}

TEST_CASE("recovery: the same seed makes the same scan, another one another") {
  const Case a = make_case("torus", hardest_conditions(), 3), b = make_case("torus", hardest_conditions(), 3);
  REQUIRE(a.scan.cloud.size() == b.scan.cloud.size());
  CHECK(a.scan.cloud.points[17] == b.scan.cloud.points[17]);
  CHECK(make_case("torus", hardest_conditions(), 4).scan.cloud.points[17] != a.scan.cloud.points[17]);
}

TEST_CASE("recovery: a hard scan holds what its conditions say") {
  const Case c = make_case("cylinder", hardest_conditions(), 2);
  CHECK(c.outliers == Approx(0.3).margin(0.01));
  CHECK(c.seen == Approx(1.0 / 3).margin(0.05));
  CHECK(c.noise == Approx(0.01 * c.size));
  // All exact places lie on the part.
  const ModelDistance distance(c.truth);
  const Pose part_from_scan = c.scan_from_part.inverse();
  for (std::size_t i = 0; i < c.exact.size(); i += 50)
    CHECK(std::abs(distance(part_from_scan * c.exact[i]).distance) < 1e-5 * c.size);
}

TEST_CASE("recovery: the densest wall of a plate among 30 % outliers is no outlier") {
  check_right({{"extrude", hardest_conditions(), 155}});
}

TEST_CASE("recovery: a plate of which the floor, the top and the wall of a step were seen lies below them") {
  check_right({{"extrude", hardest_conditions(), 206}});
}

TEST_CASE("recovery: outliers beside a face are no fin of a plate, 0.9 +- 1.1 mm thick") {
  Context context;
  const Score score = recovered(make_case("extrude", hardest_conditions(), 172), context);
  INFO(score.found << " " << score.why);
  CHECK(score.answer != Answer::wrong);
}

TEST_CASE("recovery: among outliers the rivals name the plate that was taken for another body") {
  // A wedge leans its slope on the wall of a hole and outliers.
  check_not_wrong({173});
}

TEST_CASE("recovery: so they do of other plates", "[.statistics]") {
  // Of 143 a polyhedron is four times as far off as noise; of 181 a cone has a face of 2,700 points and three of a
  // hundred.
  check_not_wrong({143, 181});
}

TEST_CASE("recovery: a cone whose radii are far larger than the data is none") {
  Context context;
  const Score score = recovered(make_case("half_spaces", hardest_conditions(), 108), context);
  INFO(score.found << " " << score.why);
  CHECK(score.found != "cone");
}

TEST_CASE("recovery: a ball with a curtain of outliers about its limb is one, or the model says that it may be one") {
  Context context;
  const Score score = recovered(make_case("sphere", hardest_conditions(), 210), context);
  INFO(score.found << " " << score.why);
  CHECK(score.answer != Answer::wrong);
}

}  // namespace partscribe::testing
