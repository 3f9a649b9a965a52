#include "fit/surface/spline_charts.h"

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "fit/surface/chart_joints.h"
#include "fit/surface/chart_pieces.h"
#include "fit/surface/charts.h"

namespace partscribe::fit {

std::vector<TrimmedSurface> spline_charts(const TriangleMesh& mesh, const FitInput& input, Context& context) {
  ChartPieces pieces(mesh, input, context);
  Charts charts = charts_of(pieces.mesh(), std::pow(5 * input.tolerance, 2), context);
  const int most = 2 * charts.count;
  while (charts.count > 0 && !context.cancelled) {
    context.say("free form: " + std::to_string(charts.count) + " charts, " + std::to_string(charts.borders.size()) +
                " borders");
    std::vector<std::shared_ptr<const ChartPiece>> fitted;
    for (int c = 0; c < charts.count && fitted.size() == std::size_t(c); ++c)
      if (auto piece = pieces.fitted(charts, c)) fitted.push_back(std::move(piece));
    const auto failed = static_cast<int>(fitted.size());
    if (failed == charts.count) {
      std::vector<ChartPiece> to_join;
      for (const auto& piece : fitted) to_join.push_back(*piece);
      return joined(pieces.mesh(), charts, std::move(to_join), input, context);
    }
    Charts more = with_chart_split(pieces.mesh(), charts, failed);
    if (more.of == charts.of || more.count > most) break;  // what is cut off goes back to where it was
    charts = std::move(more);
  }
  return {};
}

}  // namespace partscribe::fit
