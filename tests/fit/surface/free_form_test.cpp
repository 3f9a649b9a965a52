#include "fit/surface/free_form.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "fit/evidence/evidence.h"
#include "fit/input/prepare.h"
#include "model/surface_patches.h"
#include "testing/free_forms.h"

using namespace partscribe::fit;

namespace {

struct Made {
  SurfaceSet set;
  CandidateEvidence evidence;
};

Made free_form_of(const TriangleMesh& mesh, double tolerance) {
  Context context;
  Scan scan = partscribe::testing::scan_of(mesh);
  const auto input = prepare(scan, tolerance, context);
  REQUIRE(input.ok());
  const auto candidate = free_form(mesh, *input, context);
  REQUIRE(candidate);
  CHECK(candidate->parameters.size() == (topology(mesh).closed() ? 0 : 1));
  const auto& set = std::get<SurfaceSet>(candidate->shape);
  for (const auto& patch : set.patches) CHECK_FALSE(complaint_about(patch));
  return {set, evidence_of(*candidate, *input, context)};
}

}  // namespace

TEST_CASE("free form: two sheets are two surfaces with edges of their own") {
  const auto one = partscribe::testing::hood();
  TriangleMesh two = one;
  const auto first = static_cast<std::uint32_t>(one.vertices.size());
  for (const Vec3& p : one.vertices) two.vertices.push_back(p + Vec3(0, 60, 10));
  for (const auto& t : one.triangles) two.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  const auto made = free_form_of(two, 0.1);
  CHECK_FALSE(made.set.closed);
  REQUIRE(made.set.patches.size() == 2);
  CHECK(made.set.patches[0].trims.front().edge == 1);
  CHECK(made.set.patches[1].trims.back().edge == 16);
  CHECK(made.evidence.local_max < 0.1);
}

TEST_CASE("free form: a closed lump and a ring are closed sets of surfaces within the tolerance") {
  for (const TriangleMesh& mesh : {partscribe::testing::pebble(40), partscribe::testing::wavy_ring(120)}) {
    const auto made = free_form_of(mesh, 0.2);
    CHECK(made.set.closed);
    CHECK(made.evidence.local_max < 0.2);
    const auto triangles = triangulated(trimmed_surfaces(made.set.patches), 0.02);
    CHECK(topology(triangles.mesh).closed());
    CHECK(volume(triangles.mesh) == Approx(volume(mesh)).epsilon(0.005));
  }
}
