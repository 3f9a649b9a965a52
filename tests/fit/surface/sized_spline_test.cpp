#include "fit/surface/sized_spline.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "geometry/images/rlts_filter.h"
#include "testing/range_scenes.h"

using namespace partscribe::geometry;
using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

constexpr int width = 120, height = 60;

struct Relief {
  PatchCounts counts;
  PlaceGrid grid;  // without the noise that the patches were counted in
};

/// A row of `humps` sharp ridges and valleys, lying along y.
Relief relief(int humps) {
  const auto scene = range_scene({.width = width, .height = height}, [&](double x, double) {
    return 40 + 2.5 * std::sin(std::numbers::pi * humps * (x + 0.5) / width);
  });
  Context context;
  const auto filtered = rlts_filter(scene.image, {}, context);
  const auto graph = surface_graph(scene.image, filtered, {});
  const auto patches = grow_patches(graph, characterize(graph, {}, context), {}, context);
  Relief result{most_patches(patches.label, width, height), {width, height, {}}};
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c)
      result.grid.places.emplace_back(c, r, scene.truth[std::size_t(r) * width + std::size_t(c)]);
  return result;
}

}  // namespace

TEST_CASE("sized spline: three control points for each patch, and as many as the order at the least") {
  const NetSize size = net_size({5, 1});
  CHECK(size.columns == 15);
  CHECK(size.rows == 4);
  CHECK(net_size({2, 3}, 3, 3).columns == 6);
  CHECK(net_size({0, 0}).columns == 4);
}

TEST_CASE("sized spline: characters of a surface tell how many control points its spline needs") {
  constexpr double tolerance = 0.01;
  int before = 0;
  for (const int humps : {1, 3, 6}) {
    INFO(humps << " humps");
    const Relief r = relief(humps);
    const NetSize size = net_size(r.counts);
    INFO(size.columns << " x " << size.rows);
    CHECK(size.columns > before);
    before = size.columns;
    // Nothing bends along y, but borders of patches are ragged.
    CHECK(size.rows <= 9);
    const auto sized = sized_surface(r.grid, r.counts, Parameters::uniform, tolerance);
    CHECK(sized.worst <= tolerance);
    // The number is near what is needed: few are added, and a third of it would not do.
    CHECK(sized.surface.u.count() <= 1.4 * size.columns + 2);
    if (humps == 1) continue;
    const auto third = published_surface(r.grid, equal_spans(std::max(4, size.columns / 3)), equal_spans(size.rows),
                                         Parameters::uniform);
    CHECK(third.worst > tolerance);
  }
}
