#include "scan/filter/filter.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "scan/simulate/simulate.h"

using namespace partscribe::scan;

namespace {

struct Ball {
  SimulatedScan scan;
  std::vector<RangeImage> images;
};

constexpr double radius = 20, sigma = 0.04;

Ball scanned_ball(Projection projection) {
  Context context;
  SimulateOptions options;
  options.resolution = 96, options.sigma = sigma, options.outliers = 0.01, options.projection = projection;
  Surface surface;
  surface.bounds.add(Vec3::Constant(-radius)), surface.bounds.add(Vec3::Constant(radius));
  surface.first_hit = [](const Vec3& origin, const Vec3& direction) -> std::optional<SurfaceHit> {
    const double middle = -origin.dot(direction), sq_off = (origin + middle * direction).squaredNorm();
    if (sq_off >= radius * radius) return {};
    const double t = middle - std::sqrt(radius * radius - sq_off);
    return SurfaceHit{t, (origin + t * direction) / radius};
  };
  Ball ball{simulate(surface, options, context), {}};
  for (const auto& view : ball.scan.views) ball.images.push_back(view.image);
  return ball;
}

double off(const Vec3& p) { return std::abs(p.norm() - radius); }

}  // namespace

TEST_CASE("filter: outliers are found and stay where they were") {
  Ball ball = scanned_ball(Projection::orthographic);
  Context context;
  Scan scan = ball.scan.merged;
  const FilterSummary summary = filter_views(scan, ball.images, context);
  CHECK(summary.views == ball.images.size());
  std::size_t bad = 0, caught = 0, good = 0, lost = 0;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const bool outlier = off(ball.scan.merged.cloud.points[i]) > 12 * sigma;
    if (scan.cloud.rejected[i]) CHECK(scan.cloud.points[i] == ball.scan.merged.cloud.points[i]);
    (outlier ? bad : good) += 1;
    if (scan.cloud.rejected[i]) (outlier ? caught : lost) += 1;
  }
  REQUIRE(bad > 100);
  CHECK(double(caught) > 0.95 * double(bad));
  CHECK(double(lost) < 0.03 * double(good));
}

TEST_CASE("filter: outliers can be flagged alone, by the published profile as well, and no place moves") {
  Ball ball = scanned_ball(Projection::orthographic);
  Context context;
  for (const RltsForm form : {RltsForm::combined, RltsForm::profile}) {
    Scan scan = ball.scan.merged;
    const FilterSummary summary = flag_outliers(scan, ball.images, form, context);
    CHECK(summary.views == ball.images.size());
    CHECK(scan.cloud.points == ball.scan.merged.cloud.points);
    CHECK(scan.cloud.normals.empty());
    std::size_t bad = 0, caught = 0, flagged = 0;
    for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
      flagged += scan.cloud.rejected[i];
      if (off(scan.cloud.points[i]) < 12 * sigma) continue;
      ++bad, caught += scan.cloud.rejected[i];
    }
    CHECK(flagged == summary.rejected);
    CHECK(double(caught) > 0.9 * double(bad));
    CHECK(double(flagged) < 0.1 * double(scan.cloud.size()));
  }
}

TEST_CASE("filter: values lie nearer to the surface, with normals that face out") {
  for (const Projection projection : {Projection::orthographic, Projection::pinhole}) {
    Ball ball = scanned_ball(projection);
    Context context;
    Scan scan = ball.scan.merged;
    filter_views(scan, ball.images, context);
    double before = 0, after = 0;
    std::size_t count = 0, known = 0;
    for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
      if (scan.cloud.rejected[i]) continue;
      ++count;
      before += std::pow(off(ball.scan.merged.cloud.points[i]), 2), after += std::pow(off(scan.cloud.points[i]), 2);
      if (scan.cloud.normals[i].isZero()) continue;
      ++known;
      CHECK(scan.cloud.normals[i].dot(scan.cloud.points[i].normalized()) > 0.6);
    }
    CHECK(known > 0.9 * double(count));
    CHECK(after < 0.4 * before);
  }
}

TEST_CASE("filter: what hides in the noise is part of a place's sigma, and no part of its noise") {
  Ball ball = scanned_ball(Projection::orthographic);
  Context context;
  Scan place = ball.scan.merged, noise = ball.scan.merged;
  filter_views(place, ball.images, context), filter_views(noise, ball.images, context, FilterSigma::of_noise);
  CHECK(place.cloud.points == noise.cloud.points);
  std::size_t larger = 0;
  for (std::size_t i = 0; i < place.cloud.size(); ++i) {
    CHECK(place.cloud.sigma[i] >= noise.cloud.sigma[i]);
    larger += place.cloud.sigma[i] > 1.01f * noise.cloud.sigma[i];
  }
  CHECK(larger > place.cloud.size() / 20);
  const std::vector<RegisterView> views = views_to_register(ball.scan.merged, ball.images, context);
  CHECK(views[0].cloud.sigma == std::vector<float>(noise.cloud.sigma.begin(),
                                                   noise.cloud.sigma.begin() + std::ptrdiff_t(views[0].cloud.size())));
}

TEST_CASE("filter: points without images stay as they are") {
  Context context;
  Scan scan;
  scan.cloud.points = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
  scan.views.resize(1);
  CHECK(filter_views(scan, {}, context).views == 0);
  CHECK(scan.cloud.points[1] == Vec3(1, 0, 0));
}
