#include "geometry/images/deriche.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "testing/range_scenes.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

namespace {

std::vector<RangeEdge> edges_of(const RangeScene& s) {
  Context context;
  return range_edges(s.image, rlts_filter(s.image, {}, context), {});
}

/// Rows in which an edge of this kind is found within a pixel of a column, and edges anywhere else.
struct Found {
  int rows = 0, elsewhere = 0;
};

Found found(const RangeScene& s, RangeEdge kind, int column) {
  const auto edges = edges_of(s);
  Found f;
  for (int r = 0; r < s.image.height; ++r) {
    bool here = false;
    for (int c = 0; c < s.image.width; ++c) {
      const RangeEdge e = edges[static_cast<std::size_t>(r * s.image.width + c)];
      if (std::abs(c - column) <= 2)
        here = here || e == kind;
      else
        f.elsewhere += e != RangeEdge::none;
    }
    f.rows += here;
  }
  return f;
}

}  // namespace

TEST_CASE("deriche: a ramp has its own slope everywhere, ends and gaps included") {
  std::vector<double> values;
  for (int r = 0; r < 20; ++r)
    for (int c = 0; c < 30; ++c)
      values.push_back(c == 11 && r > 5 ? std::numeric_limits<double>::quiet_NaN() : 3 + 0.7 * c - 0.4 * r);
  for (const double alpha : {0.5, 1.0, 2.0}) {
    const Gradient g = deriche_gradient(values, 30, 20, alpha);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) {
        CHECK(std::isnan(g.x[i]));
        continue;
      }
      CHECK(g.x[i] == Approx(0.7).margin(1e-3));
      CHECK(g.y[i] == Approx(-0.4).margin(1e-3));
    }
  }
}

TEST_CASE("deriche: mirror the image and the derivative changes its sign, turn it and rows become columns") {
  Random random(3);
  const int n = 24;
  std::vector<double> values(n * n), mirrored(n * n), turned(n * n);
  for (double& v : values) v = random.normal();
  const auto at = [](int r, int c) { return static_cast<std::size_t>(r * 24 + c); };
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) mirrored[at(r, n - 1 - c)] = turned[at(c, r)] = values[at(r, c)];
  const Gradient g = deriche_gradient(values, n, n, 1), m = deriche_gradient(mirrored, n, n, 1),
                 t = deriche_gradient(turned, n, n, 1);
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      CHECK(m.x[at(r, n - 1 - c)] == Approx(-g.x[at(r, c)]).margin(1e-4));
      CHECK(t.y[at(c, r)] == Approx(g.x[at(r, c)]).margin(1e-12));
    }
}

TEST_CASE("range edges: steps from ten noise levels up are found where they are, and nothing else") {
  for (const double height : {0.2, 1.0, 20.0}) {
    const auto s = range_scene({}, [&](double x, double y) { return 30 + (x < 40 ? 0 : height) + 0.3 * x + 0.1 * y; });
    const Found f = found(s, RangeEdge::step, 40);
    INFO("height " << height);
    CHECK(f.rows >= 58);
    CHECK(f.elsewhere <= 3);
  }
}

TEST_CASE("range edges: roofs are found where they are, and next to nothing else") {
  for (const double slope : {0.2, 1.0}) {
    const auto s = range_scene({}, [&](double x, double y) { return 60 - slope * std::abs(x - 40) + 0.1 * y; });
    const Found f = found(s, RangeEdge::roof, 40);
    INFO("slope " << slope);
    CHECK(f.rows >= 57);
    CHECK(f.elsewhere <= 5);
  }
}

TEST_CASE("range edges: planes, balls, noise and bit errors have none") {
  const auto share = [](const RangeScene& s) {
    const auto edges = edges_of(s);
    return 1 - static_cast<double>(std::count(edges.begin(), edges.end(), RangeEdge::none)) /
                   static_cast<double>(edges.size());
  };
  CHECK(share(range_scene({}, [](double x, double y) { return 30 + 0.8 * x - 0.3 * y; })) < 0.002);
  CHECK(share(range_scene({.bit_error = 0.02}, [](double x, double y) { return 30 + 0.8 * x - 0.3 * y; })) < 0.01);
  CHECK(share(range_scene({}, [](double x, double y) {
          return 80 - std::sqrt(70 * 70 - (x - 40) * (x - 40) - (y - 30) * (y - 30));
        })) < 0.005);
}

TEST_CASE("range edges: bad images have answers too") {
  CHECK(edges_of(range_scene({.width = 0, .height = 0}, [](double, double) { return 1; })).empty());
  CHECK(edges_of(range_scene({.width = 1, .height = 1}, [](double, double) { return 10; })).front() == RangeEdge::none);
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  for (const RangeEdge e : edges_of(range_scene({}, [&](double, double) { return nothing; })))
    CHECK(e == RangeEdge::none);
}
