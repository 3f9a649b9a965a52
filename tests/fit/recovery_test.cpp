/// Hard scans of known parts: what is found is right, or says that it cannot tell.
#include <catch2/catch.hpp>

#include "bench/recovery/score.h"
#include "fit/build.h"
#include "fit/strays.h"
#include "sampled.h"

namespace partscribe {
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

}  // namespace

TEST_CASE("recovery: of thirty hard scans with a third unseen at least 28 give the right kind and numbers, none a wrong answer") {
  std::size_t runs = 0, right = 0, wrong = 0;
  std::string report;
  for (const auto& kind : {"sphere", "ellipsoid", "box", "wedge", "cylinder", "cone", "torus", "half_spaces", "revolve", "extrude"})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Case c = make_case(kind, standard_conditions(), seed);
      Context context;
      const Score score = recovered(c, context);
      ++runs, right += score.answer == Answer::right, wrong += score.answer == Answer::wrong;
      if (score.answer != Answer::right)
        report += std::string(kind) + " " + std::to_string(seed) + ": " + name_of(score.answer) + ", " + score.found + " " + score.why + "\n";
    }
  INFO(report);
  CHECK(runs == 30);
  CHECK(right >= 28);
  CHECK(wrong == 0);
}

TEST_CASE("recovery: a fillet of which the concave side was not seen is a block") {
  Scan scan = test::sampled(model_with(Box{30, 20, 10}), {.points = 3000, .noise = 0.05, .reach = 20, .seed = 4});
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
  for (std::size_t i = 0; i < c.exact.size(); i += 50) CHECK(std::abs(distance(part_from_scan * c.exact[i]).distance) < 1e-5 * c.size);
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
  Scan scan = test::sampled(model_with(Cone{10.02, 10, 30}), {.points = 3000, .noise = 0.1, .reach = 20, .seed = 4});
  Context context;
  const auto model = build_model(scan, {.tolerance = 0.5}, context);
  REQUIRE(model);
  INFO(reasons(**model));
  CHECK(kind_of((*model)->objects.back().shape) == "cylinder");
  CHECK(reasons(**model).find("the data cannot tell it from a cone: half angle") != std::string::npos);
}

TEST_CASE("rivals: a cone that the data show is not called undecided") {
  Scan scan = test::sampled(model_with(Cone{12, 10, 30}), {.points = 3000, .noise = 0.05, .reach = 20, .seed = 4});
  Context context;
  const auto model = build_model(scan, {.tolerance = 0.25}, context);
  REQUIRE(model);
  INFO(reasons(**model));
  CHECK(kind_of((*model)->objects.back().shape) == "cone");
  CHECK(reasons(**model).find("cannot tell") == std::string::npos);
}

}  // namespace partscribe
