#include "fit/surface/chart_pieces.h"

#include <catch2/catch.hpp>

#include "fit/input/prepare.h"
#include "testing/free_forms.h"

using namespace partscribe::fit;

TEST_CASE("chart pieces: a piece reaches beyond its chart, holds its points, and is fitted once") {
  Context context;
  Scan scan = partscribe::testing::scan_of(partscribe::testing::pebble(40));
  const auto input = prepare(scan, 0.2, context);
  REQUIRE(input.ok());
  ChartPieces pieces(scan.mesh, *input, context);
  const Charts charts = charts_of(pieces.mesh(), 1, context);
  for (int c = 0; c < charts.count; ++c) {
    const auto piece = pieces.fitted(charts, c);
    REQUIRE(piece);
    CHECK(pieces.fitted(charts, c) == piece);
    std::size_t own = 0, held = 0;
    for (const int of : charts.of) own += of == c;
    for (const auto t : piece->triangles) held += charts.of[t] == c;
    CHECK(held == own);
    CHECK(piece->triangles.size() > own + own / 20);
    for (std::size_t i = 0; i < piece->data.points.size(); ++i) {
      const Vec2 uv = piece->data.places[i];
      CHECK((piece->surface.at(uv.x(), uv.y()) - piece->data.points[i]).norm() < 0.3);
    }
  }
}
