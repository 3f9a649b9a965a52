/// Scans whose points are far denser than their noise is thick: what is near a point is a ball of noise, no surface.
#include <catch2/catch.hpp>
#include <functional>

#include "testing/meshes.h"
#include "verify/compare/source.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double noise = 0.5;

TriangleMesh rod(double radius) { return turned({{0, 0}, {radius, 0}, {radius, 30}, {0, 30}}, 200); }

}  // namespace

TEST_CASE("verdict: a dense scan tells its noise, verifies the true part and refuses one off by twice the tolerance") {
  // Plates eight sigmas thick: the other side lies nearer than most of the points that noise has moved.
  const auto plate = [](double thickness) { return box({0, 0, 0}, {40, 30, thickness}); };
  struct Part {
    std::string name;
    TriangleMesh truth;
    std::function<TriangleMesh(double)> off_by;
  };
  const std::vector<Part> parts = {{"rod", rod(10), [&](double by) { return rod(10 + by); }},
                                   {"plate", plate(8 * noise), [&](double by) { return plate(8 * noise + by); }}};
  for (const Part& part : parts) {
    INFO(part.name);
    const Scan scan = scanned(part.truth, 16000, noise);
    Context context;
    const ScanSource source = prepare_source(scan, context);
    CHECK(source.noise == Approx(noise).epsilon(0.1));
    VerifyOptions options;
    options.tolerance = 1.0001 * smallest_honest_tolerance(source);
    CHECK(options.tolerance < 1.5 * noise);
    const Verdict verdict = verdict_on(part.truth, scan, options);
    INFO(all_reasons(verdict));
    CHECK(verdict.verdict == Outcome::verified);
    CHECK(verdict.artifacts[0].data_to_model.local_max < 0.6 * options.tolerance);
    for (const double by : {-2.0, 2.0}) {
      INFO("off by " << by << " tolerances");
      CHECK(verdict_on(part.off_by(by * options.tolerance), scan, options).verdict == Outcome::out_of_tolerance);
    }
  }
}

TEST_CASE("verdict: views of a dense scan that lie beside each other are found to") {
  constexpr double apart = 1;
  Scan scan = scanned(sphere(10), 20000, noise);
  scan.views.push_back({});
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    scan.cloud.view.push_back(static_cast<std::int32_t>(i % 2));
    if (i % 2 == 1) scan.cloud.points[i] *= (10 + apart) / 10;
  }
  Context context;
  CHECK(prepare_source(scan, context).disagreement == Approx(apart).epsilon(0.2));
}
