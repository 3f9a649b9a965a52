#include "fit/propose/fillet.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "fit/input/prepare.h"
#include "fit/refine/refine.h"
#include "testing/models.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

FitInput prepared(Scan& scan, double tolerance) {
  Context context;
  auto input = prepare(scan, tolerance, context);
  REQUIRE(input);
  return std::move(*input);
}

/// Of the last candidate, that with two legs of its own, smaller first.
Vec3 sizes_of(const std::vector<Candidate>& candidates) {
  REQUIRE_FALSE(candidates.empty());
  const auto& p = candidates.back().parameters;
  REQUIRE(p.size() == 3);
  return {std::min(p[0].value, p[1].value), std::max(p[0].value, p[1].value), p[2].value};
}

}  // namespace

TEST_CASE("fillet: its concave side and little of its legs, among outliers") {
  for (const Vec3& from : {Vec3(0.9, -0.5, 0.4), Vec3(0.6, -0.7, 0.6), Vec3(-0.5, 0.8, -0.7)})
    for (const auto& [width, height] : {std::pair{24.0, 24.0}, std::pair{28.0, 18.0}}) {
      Scan scan = sampled(model_with(Fillet{width, height, 40}),
                          {.points = 2500, .noise = 0.15, .outliers = 0.04, .reach = 45, .seen_from = from, .seed = 3});
      Context context;
      const FitInput input = prepared(scan, 0.6);
      std::vector<Candidate> found = propose_fillets(input, context);
      INFO(from.transpose() << ", " << width << " x " << height);
      REQUIRE_FALSE(found.empty());
      CHECK((found.size() == 2) == (width == height));
      RefineOptions options;
      options.uncertainty = false;
      refine(found.back(), input, options, context);
      const Vec3 size = sizes_of(found);
      CHECK(size.x() == Approx(std::min(width, height)).margin(0.8));
      CHECK(size.y() == Approx(std::max(width, height)).margin(0.8));
      CHECK(size.z() == Approx(40).margin(1.5));
    }
}

TEST_CASE("fillet: without a point on its legs its ends show them, and without an end neither") {
  Scan scan = sampled(model_with(Fillet{24, 18, 40}), {.points = 6000, .noise = 0.1, .reach = 45, .seed = 8});
  std::erase_if(scan.cloud.points,
                [](const Vec3& p) { return p.z() > 39.5 || (std::min(p.x(), p.y()) < 0.5 && p.z() > 0.5); });
  Scan ends = scan, neither = scan;
  std::erase_if(neither.cloud.points, [](const Vec3& p) { return p.z() < 0.5; });
  Context context;
  REQUIRE(neither.cloud.points.size() > 1000);
  const FitInput input = prepared(ends, 0.4);
  std::vector<Candidate> found = propose_fillets(input, context);
  REQUIRE_FALSE(found.empty());
  RefineOptions options;
  options.uncertainty = false;
  refine(found.back(), input, options, context);
  const Vec3 size = sizes_of(found);
  CHECK(size.x() == Approx(18).margin(0.5));
  CHECK(size.y() == Approx(24).margin(0.5));
  CHECK(propose_fillets(prepared(neither, 0.4), context).empty());
}

TEST_CASE("fillet: none among the outliers around a block, nor on a rod") {
  for (const Shape& shape : {Shape(Box{30, 20, 40}), Shape(Cylinder{15, 40})}) {
    Scan scan =
        sampled(model_with(shape),
                {.points = 2500, .noise = 0.15, .outliers = 0.04, .reach = 45, .seen_from = {1, 0.8, 0.5}, .seed = 5});
    Context context;
    CHECK(propose_fillets(prepared(scan, 0.6), context).empty());
  }
}

TEST_CASE("fillet: a strip of a rod alone, of which nobody knows which side is outside, is none") {
  Scan scan = sampled(model_with(Cylinder{30, 30}), {.points = 30000, .noise = 0.15, .reach = 32, .seed = 6});
  PointCloud strip;
  for (const Vec3& p : scan.cloud.points)
    if (std::abs(std::atan2(p.y(), p.x())) < 0.3 && p.z() > 0.5 && p.z() < 29.5) strip.points.push_back(p);
  scan.cloud = strip;
  REQUIRE(strip.points.size() > 500);
  Context context;
  CHECK(propose_fillets(prepared(scan, 0.6), context).empty());
}

TEST_CASE("fillet: among many outliers a block may be one whose concave side was not seen, and no more than may be") {
  Scan scan =
      sampled(model_with(Box{30, 20, 40}),
              {.points = 2500, .noise = 0.15, .outliers = 0.04, .reach = 45, .seen_from = {1, 0.8, 0.5}, .seed = 5});
  Context context;
  FitInput input = prepared(scan, 0.6);
  input.outlier_share = 0.2;
  const auto found = propose_fillets(input, context);
  REQUIRE_FALSE(found.empty());
  for (const Candidate& c : found) CHECK_FALSE(c.unseen.empty());
}
