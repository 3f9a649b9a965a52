/// Hard scans of known parts: what is found is right, or says that it cannot tell.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "bench/recovery/facets.h"
#include "bench/recovery/parts.h"
#include "bench/recovery/score.h"
#include "core/number.h"
#include "core/random.h"
#include "fit/build.h"
#include "fit/outliers/strays.h"
#include "fit/propose/supertoroid.h"
#include "fit/search/rivals.h"
#include "sampled.h"

namespace partscribe::testing {

using namespace fit;

namespace {

using namespace recovery;

Model model_with(Shape shape) {
  Model model;
  model.as_scanned = false;
  model.objects.push_back({"part", std::move(shape), {}, {}, {}});
  return model;
}

std::string reasons(const Model& model) {
  std::string text;
  for (const auto& rival : model.rivals) text += rival.procedure + ": " + rival.reason + "\n";
  return text;
}

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

}  // namespace

TEST_CASE(
    "recovery: of thirty hard scans with a third unseen at least 28 give the right kind and numbers, none a wrong "
    "answer") {
  std::size_t runs = 0, right = 0, wrong = 0;
  std::string report;
  for (const auto& kind :
       {"sphere", "ellipsoid", "box", "wedge", "cylinder", "cone", "torus", "half_spaces", "revolve", "extrude"})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Case c = make_case(kind, standard_conditions(), seed);
      Context context;
      const Score score = recovered(c, context);
      ++runs, right += score.answer == Answer::right, wrong += score.answer == Answer::wrong;
      if (score.answer != Answer::right)
        report += std::string(kind) + " " + std::to_string(seed) + ": " + name_of(score.answer) + ", " + score.found +
                  " " + score.why + "\n";
    }
  INFO(report);
  CHECK(runs == 30);
  CHECK(right >= 28);
  CHECK(wrong == 0);
}

TEST_CASE("recovery: among 30 % strays, two thirds hidden, plates keep their holes and rounded bodies their axes") {
  for (const auto& [kind, seed] : {std::pair{"extrude", 12}, std::pair{"extrude", 28}, std::pair{"extrude", 49},
                                   std::pair{"superellipsoid", 3}, std::pair{"superellipsoid", 8}}) {
    const Case c = make_case(kind, hardest_conditions(), static_cast<std::uint64_t>(seed));
    Context context;
    const Score score = recovered(c, context);
    INFO(kind << " " << seed << ": " << score.found << " " << score.why);
    CHECK(score.answer == Answer::right);
  }
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

TEST_CASE("recovery: the end of a plate that nobody saw lies where its walls end, not where the last stray does") {
  const Case c = make_case("extrude", hardest_conditions(), 15);
  Context context;
  const Score score = recovered(c, context);
  REQUIRE(score.model);
  const Model& model = **score.model;
  const auto height = std::find_if(model.parameters.begin(), model.parameters.end(),
                                   [](const Parameter& p) { return p.name == "height"; });
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
  // Of one face 49 points of 3,900 are about, of the other 24.
  check_right({{"half_spaces", standard_conditions(), 129}, {"half_spaces", standard_conditions(), 152}});
}

TEST_CASE("recovery: the step of a turned part that 63 or 132 points of 3,800 show is no heap of strays") {
  // So sparse that no local plane holds its neighbours: all of them pass for strays, and a plain rod is within
  // tolerance of the others.
  check_right({{"revolve", standard_conditions(), 204}, {"revolve", standard_conditions(), 223}});
}

TEST_CASE("recovery: the wall of a thin step is no piece of the axis") {
  // Of 242 its end was hardly seen: the wall goes no further, not on to where it would meet the axis, 640 mm away.
  check_right({{"revolve", hardest_conditions(), 77}, {"revolve", standard_conditions(), 242}});
}

TEST_CASE("recovery: a neck between two collars that 24 points of 3,700 show is one") {
  check_right({{"revolve", standard_conditions(), 121}});
}

TEST_CASE("recovery: an angle of which no wall of the notch was seen is one where its end faces show it") {
  check_right({{"extrude", standard_conditions(), 98}, {"extrude", standard_conditions(), 198}});
}

TEST_CASE("recovery: strays that fill a box hardly thicker than the noise is wide are strays") {
  // Strays in so flat a box hold one another: hardly a tenth of the points seemed to be any, and what is sparse was
  // kept.
  check_right({{"extrude", hardest_conditions(), 143}, {"extrude", hardest_conditions(), 168}});
}

TEST_CASE("recovery: sides of a plate that its rounds tell move with them") {
  check_right({{"extrude", standard_conditions(), 37}});
}

TEST_CASE(
    "recovery: where of three bodies each ends better than the next, the last that is not clearly behind is taken") {
  // A plate's faces end where the points do better than this wedge's, another plate's better than the first one's, the
  // wedge's better than those. The second case: a box is 5 nats ahead of the plate, which ends better than another box,
  // which is 3 ahead of the first.
  check_right({{"wedge", standard_conditions(), 111}, {"extrude", standard_conditions(), 141}});
}

TEST_CASE("recovery: the end of a block that nobody saw stays where the data end") {
  // The slope of this wedge was not seen. Strays beside the end of what else was drew the block's end in, across five
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
    "recovery: a curtain of strays behind the edges of a plate leaves its end open, and does not make another plate") {
  const Case c = make_case("extrude", hardest_conditions(), 55);
  Context context;
  const Score score = recovered(c, context);
  REQUIRE(score.model);
  CHECK(score.answer == Answer::right);
  const Model& model = **score.model;
  const auto height = std::find_if(model.parameters.begin(), model.parameters.end(),
                                   [](const Parameter& p) { return p.name == "height"; });
  REQUIRE(height != model.parameters.end());
  const double true_height = c.truth.parameters.back().value;
  CHECK(height->fitted > true_height);
  CHECK(height->sigma > 0.5 * (height->fitted - true_height));
}

TEST_CASE("recovery: a ring with corners and a fillet come back from hard scans, a fillet from a coarse mesh") {
  // Of ring 54 an extrusion is within the tolerance too, though only just; so is one of hard ring 84, and a polyhedron
  // of 37, as strays go. Of fillet 200 a rod of no radius is proposed. Of 38 and 83 no leg was seen, of 51 an extrusion
  // with a folded leg follows the noise, and of 116 the points of one end were taken for strays.
  check_right({{"supertoroid", standard_conditions(), 1},
               {"supertoroid", standard_conditions(), 54},
               {"supertoroid", hardest_conditions(), 37},
               {"supertoroid", hardest_conditions(), 84},
               {"fillet", standard_conditions(), 5},
               {"fillet", standard_conditions(), 38},
               {"fillet", standard_conditions(), 51},
               {"fillet", standard_conditions(), 83},
               {"fillet", standard_conditions(), 116},
               {"fillet", standard_conditions(), 200},
               {"fillet", facet_conditions(), 2}});
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

TEST_CASE("supertoroid: a start from half of a soiled ring is near the truth") {
  const Supertoroid truth{30, 10, 8, 0.6, 0.5};
  Scan scan =
      sampled(model_with(truth),
              {.points = 2000, .noise = 0.1, .outliers = 0.05, .reach = 42, .seen_from = {1, 0.5, 1.5}, .seed = 4});
  Context context;
  const SupertoroidFit fit =
      recover_supertoroid(scan.cloud.points, {{{1, -2, 3}, Vec3(0.05, 0.02, 1).normalized(), 1}}, context);
  CHECK(fit.shape.major_radius == Approx(30).margin(0.3));
  CHECK(fit.shape.minor_radius == Approx(10).margin(0.3));
  CHECK(fit.shape.half_height == Approx(8).margin(0.3));
  CHECK(fit.shape.e1 == Approx(0.6).margin(0.08));
  CHECK(fit.shape.e2 == Approx(0.5).margin(0.05));
  CHECK(fit.miss < 0.15);
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

TEST_CASE("strays: most are found among a third of them, few points of the surface are taken for one") {
  const Case c = make_case("box", hardest_conditions(), 5);
  Context context;
  const SurfacePoints found = surface_points_of(c.scan.cloud.points, c.scan.cloud.rays, 1.5 * c.noise, context);
  const ModelDistance distance(c.truth);
  const Pose part_from_scan = c.scan_from_part.inverse();
  std::size_t strays = 0, strays_found = 0, surface = 0, surface_lost = 0;
  for (std::size_t i = 0; i < c.scan.cloud.size(); ++i) {
    const double d = std::abs(distance(part_from_scan * c.scan.cloud.points[i]).distance);
    if (d > 6 * c.noise) ++strays, strays_found += found.stray[i];
    if (d < 2 * c.noise) ++surface, surface_lost += found.stray[i];
  }
  CHECK(strays_found > 0.6 * double(strays));
  CHECK(surface_lost < 0.06 * double(surface));
  CHECK(found.sigma == Approx(c.noise).epsilon(0.2));
}

TEST_CASE("rivals: a cone that noise hides is a cylinder, and the model says that the data cannot tell") {
  Scan scan = sampled(model_with(Cone{10.02, 10, 30}), {.points = 3000, .noise = 0.1, .reach = 20, .seed = 4});
  Context context;
  const auto model = build_model(scan, {.tolerance = 0.5}, context);
  REQUIRE(model);
  INFO(reasons(**model));
  CHECK(kind_of((*model)->objects.back().shape) == "cylinder");
  CHECK(reasons(**model).find("the data cannot tell it from a cone: half angle") != std::string::npos);
}

TEST_CASE("rivals: a cone that the data show is not called undecided") {
  Scan scan = sampled(model_with(Cone{12, 10, 30}), {.points = 3000, .noise = 0.05, .reach = 20, .seed = 4});
  Context context;
  const auto model = build_model(scan, {.tolerance = 0.25}, context);
  REQUIRE(model);
  INFO(reasons(**model));
  CHECK(kind_of((*model)->objects.back().shape) == "cone");
  CHECK(reasons(**model).find("cannot tell") == std::string::npos);
}

TEST_CASE(
    "rivals: a cone with its tip far beyond the data is a cylinder, an ellipsoid of equal axes a ball, as far as "
    "sigmas tell") {
  const auto with = [](Shape shape, std::vector<std::array<double, 2>> sizes) {
    Candidate c;
    c.shape = std::move(shape);
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      Parameter p;
      p.name = "size_" + std::to_string(k), p.value = p.fitted = sizes[k][0], p.sigma = sizes[k][1];
      c.parameters.push_back(p);
    }
    return simpler_kind(c);
  };
  const Cone tip{Expr::of("size_0"), 0, Expr::of("size_1")};
  CHECK(with(tip, {{12, 0.4}, {1500, 900}}) == "cylinder");
  CHECK(with(tip, {{12, 0.4}, {60, 3}}).empty());
  const Ellipsoid body{Expr::of("size_0"), Expr::of("size_1"), Expr::of("size_2")};
  CHECK(with(body, {{28.4, 1}, {28.3, 0.5}, {27.2, 1}}) == "sphere");
  CHECK(with(body, {{28.4, 0.2}, {28.3, 0.1}, {27.2, 0.2}}).empty());
  CHECK(with(body, {{28.4, 0}, {28.4, 0}, {28.4, 0}}).empty());
}

TEST_CASE("rivals: what is off at one place among strays, but costs less in all, may be the truth") {
  FitInput input;
  input.tolerance = 1, input.stray_share = 0.2;
  CandidateEvidence winner, rival;
  winner.misfit = 1000, winner.description = 100, winner.local_max = 0.5;
  rival.misfit = 900, rival.description = 20, rival.local_max = 4;
  CHECK(off_where_strays_are(winner, rival, input).find("180 nats less") != std::string::npos);
  rival.misfit = 1200;
  CHECK(off_where_strays_are(winner, rival, input).empty());
  rival.misfit = rival.description = 0;  // one that makes no sense was not measured
  CHECK(off_where_strays_are(winner, rival, input).empty());
  rival.misfit = 900, rival.description = 20, input.stray_share = 0.02;
  CHECK(off_where_strays_are(winner, rival, input).empty());
}

TEST_CASE(
    "rivals: a body of another kind that costs hardly more, or hardly less, may be the truth among strays or where "
    "noise explains neither") {
  FitInput input;
  input.tolerance = 1, input.stray_share = 0.25;
  input.cloud.points.resize(3000);  // a choice between kinds takes 95 nats
  CandidateEvidence winner, rival;
  winner.misfit = 800, winner.description = 30, rival.misfit = 850, rival.description = 40;
  CHECK(hardly_told_apart(winner, rival, input) ==
        "the data cannot tell: costs 60 nats more in all, as strays may have it");
  rival.misfit = 770;
  CHECK(hardly_told_apart(winner, rival, input) ==
        "the data cannot tell: costs 20 nats less in all, as strays may have it");
  rival.misfit = 900;
  CHECK(hardly_told_apart(winner, rival, input).empty());
  rival.misfit = 850, input.stray_share = 0;
  CHECK(hardly_told_apart(winner, rival, input).empty());
  input.strays_left = 0.25;  // they are still about
  CHECK_FALSE(hardly_told_apart(winner, rival, input).empty());
  input.strays_left = 0, winner.misfit = 3400,
  rival.misfit = 3450;  // four times as much as noise: 90 nats are worth 20
  CHECK(hardly_told_apart(winner, rival, input) ==
        "the data cannot tell: costs 60 nats more in all, where neither follows them as closely as noise allows");
  rival.misfit = 3500;
  CHECK(hardly_told_apart(winner, rival, input).empty());
}

TEST_CASE("rivals: a round body whose radius may be anything is none") {
  const auto with = [](double radius, double sigma) {
    Candidate c;
    c.shape = Ellipsoid{30, 20, Expr::of("radius_z")};
    Parameter p;
    p.name = "radius_z", p.value = p.fitted = radius, p.sigma = sigma;
    c.parameters = {p};
    return unknown_radius(c);
  };
  CHECK(with(230, 4800) == "its radius 200 +- 4800 mm is not known");
  CHECK(with(230, 40).empty());
}

TEST_CASE("rivals: a plate with a wall that may as well be of no thickness is none") {
  const auto with = [](double edge, double sigma, bool slanted, std::size_t points = 250) {
    Loop outline;
    outline.name = "outline";
    const Expr y = Expr::of("edge_y");
    outline.elements = {SketchPoint{0, 0, ""}, SketchPoint{56, 0, ""}, SketchPoint{56, 36, ""},
                        SketchPoint{30, 36, ""}};
    if (!slanted) outline.elements.push_back(SketchPoint{30, y, ""});
    outline.elements.push_back(SketchPoint{0, y, ""});
    Candidate c;
    c.shape = Extrude{{{outline}}, 32};
    Parameter p;
    p.name = "edge_y", p.value = p.fitted = edge, p.sigma = sigma, p.points = points;
    c.parameters = {p};
    return unknown_wall(c);
  };
  CHECK(with(0.86, 1.1, false) == "a wall of 0.9 +- 1.1 mm may be none");
  CHECK(with(0.86, 0.2, false).empty());
  CHECK(with(0.86, 1.1, true).empty());   // a corner beside another, no wall
  CHECK(with(20, 25, false, 3).empty());  // a side that was not seen
}

TEST_CASE("rivals: a rod with a fin that may as well be of no thickness is none") {
  // The outline of a rod, a fin along its tangent: between two arcs no side has corners at both ends.
  const auto with = [](double thickness) {
    Loop outline;
    outline.name = "outline";
    const Expr y = Expr::of("width");
    outline.elements = {SketchPoint{20, 0, ""}, SketchPoint{20, y, ""}, SketchArc{5, y + 10, 10, -pi / 2, pi / 2, ""},
                        SketchArc{5, 10, 10, pi / 2, 1.5 * pi, ""}};
    Candidate c;
    c.shape = Extrude{{{outline}}, 32};
    Parameter p;
    p.name = "width", p.value = p.fitted = thickness, p.sigma = 0.1, p.points = 250;
    c.parameters = {p};
    return unknown_wall(c);
  };
  CHECK(with(0.03) == "a wall of 0.03 +- 0.1 mm may be none");
  CHECK(with(0.3).empty());
}

TEST_CASE(
    "recovery: plates among 30 % strays: dense walls are no strays, what is printed is no dearer than what else was "
    "found") {
  // Of 155 the densest wall passed for strays; of 140 the last steps led a plate that was swept across another way to
  // one that costs 90 nats more than the right one.
  check_right({{"extrude", hardest_conditions(), 140}, {"extrude", hardest_conditions(), 155}});
}

TEST_CASE("recovery: a plate of which the floor, the top and the wall of a step were seen lies below them") {
  check_right({{"extrude", hardest_conditions(), 206}});
}

TEST_CASE("recovery: strays beside a face are no fin of a plate, 0.9 +- 1.1 mm thick") {
  Context context;
  const Score score = recovered(make_case("extrude", hardest_conditions(), 172), context);
  INFO(score.found << " " << score.why);
  CHECK(score.answer != Answer::wrong);
}

TEST_CASE("recovery: among strays the rivals name the plate that was taken for another body") {
  // Of 143 a polyhedron is four times as far off as noise; of 173 a wedge leans its slope on the wall of a hole and
  // strays; of 181 a cone has a face of 2,700 points and three of a hundred.
  for (const std::uint64_t seed : {143, 173, 181}) {
    Context context;
    const Score score = recovered(make_case("extrude", hardest_conditions(), seed), context);
    INFO(seed << ": " << score.found << " " << score.why);
    CHECK(score.answer != Answer::wrong);
  }
}

TEST_CASE("recovery: a cone whose radii are far larger than the data is none") {
  Context context;
  const Score score = recovered(make_case("half_spaces", hardest_conditions(), 108), context);
  INFO(score.found << " " << score.why);
  CHECK(score.answer != Answer::wrong);
  CHECK(score.found != "cone");
}

TEST_CASE(
    "rivals: a shorter one that leaves out few points beside the strays may be the truth, however far they lie from "
    "it") {
  FitInput input;
  input.tolerance = 1, input.stray_share = 0.25;
  input.cloud.points.resize(3000);  // 750 strays were set aside
  CandidateEvidence winner, rival;
  winner.misfit = 1400, winner.description = 130, winner.local_max = 0.5, winner.unexplained = 5;
  rival.misfit = 1650, rival.description = 20, rival.local_max = 25, rival.unexplained = 95;
  CHECK(leaves_out_strays(winner, rival, input).find("the 90 points that it leaves out are strays") !=
        std::string::npos);
  const auto empty_with = [&](const auto& change) {
    CandidateEvidence other = rival;
    FitInput scan = input;
    change(other, scan);
    return leaves_out_strays(winner, other, scan).empty();
  };
  CHECK(empty_with([](CandidateEvidence& r, FitInput&) { r.misfit = 2200; }));  // it is off elsewhere as well
  CHECK_FALSE(empty_with(
      [](CandidateEvidence& r, FitInput&) { r.misfit = 2200, r.far_out = 800; }));  // by points farther off than noise
  CHECK(empty_with([](CandidateEvidence& r, FitInput&) { r.unexplained = 160; }));  // too many to be strays
  CHECK(empty_with([](CandidateEvidence& r, FitInput&) { r.unexplained = 5; }));    // it leaves out none
  CHECK(empty_with([](CandidateEvidence& r, FitInput&) { r.description = 140; }));
  CHECK(empty_with([](CandidateEvidence&, FitInput& scan) { scan.stray_share = 0.05; }));
}

TEST_CASE("evidence: what points beyond noise cost more is no lead among strays, and one among few") {
  FitInput input;
  CandidateEvidence ahead, other;
  ahead.misfit = 820, ahead.far_out = 200, ahead.unexplained = 10;
  other.misfit = 1080, other.far_out = 460, other.unexplained = 34;
  input.stray_share = 0.05;
  CHECK(gained_by_strays(ahead, other, input) == Approx(24 * nats_per_stray));
  input.stray_share = 0.25;
  CHECK(gained_by_strays(ahead, other, input) == Approx(260));
  CHECK(gained_by_strays(other, ahead, input) == 0);
}

TEST_CASE("recovery: a ball with a curtain of strays about its limb is a ball, no ball on a rod") {
  Context context;
  const Score score = recovered(make_case("sphere", hardest_conditions(), 210), context);
  INFO(score.found << " " << score.why);
  CHECK(score.answer == Answer::right);
}

TEST_CASE("rivals: those that may be the truth are named however many others there are") {
  std::vector<Rival> all;
  for (int i = 0; i < 20; ++i)
    all.push_back({"extrusion " + std::to_string(i), true, 0.1, 100, "describes the part in 8 nats more"});
  all.push_back({"fillet", false, 0.1, 90, "the data cannot tell: its concave side was hardly seen"});
  const auto named = worth_naming(all);
  REQUIRE(named.size() == 12);
  CHECK(named[10].procedure == "extrusion 10");
  CHECK(named[11].procedure == "fillet");
  // One of each procedure comes before a second of the same.
  all.assign(20, {"cylinder", true, 0.1, 100, "fits as well, takes 0 nats more to describe"});
  all.push_back({"fillet", false, 0.1, 90, "the data cannot tell: its concave side was hardly seen"});
  const auto kinds = worth_naming(all);
  REQUIRE(kinds.size() == 12);
  CHECK(kinds[10].procedure == "cylinder");
  CHECK(kinds[11].procedure == "fillet");
}

TEST_CASE("rivals: a flat body on one bent sheet names the cylinder, on a flat sheet it does not") {
  const auto sheet = [](double radius) {
    FitInput input;
    Random random(5);
    for (int i = 0; i < 3000; ++i) {
      const double x = random.uniform(-10, 10), y = random.uniform(-20, 20), noise = 0.1 * random.normal();
      input.cloud.points.emplace_back(x, y, noise + (radius > 0 ? radius - std::sqrt(radius * radius - x * x) : 0));
      input.cloud.normals.push_back(radius > 0 ? Vec3(-x, 0, std::sqrt(radius * radius - x * x)).normalized()
                                               : Vec3(0, 0, 1));
    }
    input.bounds = input.cloud.bounds();
    return input;
  };
  Candidate box;
  box.shape = Box{20, 40, 10};
  const std::string bent = bent_sheet(box, sheet(40));
  CHECK(bent.find("the data cannot tell it from 2") == 0);
  const auto at = bent.find("cylinder of radius ");
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(bent.substr(at + 19)) == Approx(40).margin(1.5));
  CHECK(bent_sheet(box, sheet(0)).empty());
  box.shape = Sphere{20};
  CHECK(bent_sheet(box, sheet(40)).empty());
}

TEST_CASE("strays: a dot of points that stands apart is one heap of them") {
  Random random(11);
  const double sigma = 1;
  std::vector<Vec3> points;
  const auto near = [&](double width) { return Vec3(width * Vec3(random.normal(), random.normal(), random.normal())); };
  for (int i = 0; i < 2500; ++i)
    points.push_back(Vec3(random.uniform(-50, 50), random.uniform(-50, 50), sigma * random.normal()));
  const std::size_t surface = points.size();
  for (int i = 0; i < 120; ++i) points.push_back(Vec3(0, 0, 40) + near(1.8));
  const std::size_t dot = points.size();
  for (int i = 0; i < 700; ++i)
    points.push_back({random.uniform(-70, 70), random.uniform(-70, 70), random.uniform(-70, 70)});
  Context context;
  const SurfacePoints found = surface_points_of(points, {}, sigma, context);
  const auto strays = [&](std::size_t from, std::size_t to) {
    return std::count(found.stray.begin() + std::ptrdiff_t(from), found.stray.begin() + std::ptrdiff_t(to), 1);
  };
  CHECK(strays(surface, dot) > 110);
  CHECK(strays(0, surface) < 100);
}

}  // namespace partscribe::testing
