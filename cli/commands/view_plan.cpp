/// views: from where to scan.
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "core/json_text.h"
#include "core/number.h"
#include "scan/simulate/simulate.h"
#include "scan/views/next_views.h"

namespace partscribe::cli {
namespace {

constexpr const char* view_plan_help =
    R"(Examples
  partscribe views                                 six views, as through the faces of a cube
  partscribe views --plan dodecahedron             twenty views for a part with many recesses
  partscribe views --scan folder/scan.json         what is still unseen, and from where it is seen best

Directions point from the part to the sensor: azimuth in the xy plane from x, elevation above it, in degrees. The
corners of the regular polyhedra see all sides alike: 4, 6, 8, 12 or 20 views. With --scan the views so far are taken
into account: space that no view looked into may hold more of the part, and views are named until they add less than
half a percent.)";

struct ViewPlanArguments {
  std::string plan = "octahedron";
  Path scan;
};

struct Row {
  Vec3 direction;
  double gain = 0, overlap = 0;
};

double tenths_of_degrees(double angle) { return snapped(angle * 180 / pi, 0.1) + 0.0; }

double azimuth(const Vec3& d) {
  return tenths_of_degrees(std::hypot(d.x(), d.y()) < 1e-9 ? 0 : std::atan2(d.y(), d.x()));
}
double elevation(const Vec3& d) { return tenths_of_degrees(std::atan2(d.z(), std::hypot(d.x(), d.y()))); }

void print(const std::vector<Row>& rows, bool measured, Session& session) {
  nlohmann::ordered_json json;
  json["views"] = nlohmann::ordered_json::array();
  std::string table = measured ? "azimuth  elevation  sees unseen mm2  known share\n" : "azimuth  elevation\n";
  const auto column = [](const std::string& text, std::size_t width) {
    return std::string(width - std::min(width, text.size()), ' ') + text;
  };
  for (const auto& row : rows) {
    table += column(print_number(azimuth(row.direction)), 7) + column(print_number(elevation(row.direction)), 11);
    nlohmann::ordered_json entry = {{"azimuth_deg", azimuth(row.direction)},
                                    {"elevation_deg", elevation(row.direction)},
                                    {"direction", {row.direction.x(), row.direction.y(), row.direction.z()}}};
    if (measured) {
      table += column(readable(row.gain), 17) + column(print_number(snapped(row.overlap, 0.01)), 13);
      entry["gain_mm2"] = row.gain, entry["overlap"] = row.overlap;
    }
    table += "\n";
    json["views"].push_back(entry);
  }
  session.print(table);
  session.print_json(json_text(json));
}

Result<int> run_view_plan(const ViewPlanArguments& given, Session& session) {
  std::vector<Row> rows;
  if (given.scan.empty()) {
    const auto plan = viewpoints(given.plan);
    if (!plan)
      return usage_error(
          "--plan: expected tetrahedron, octahedron, cube, icosahedron, dodecahedron or a number, found '" +
          given.plan + "'");
    for (const Vec3& d : *plan) rows.push_back({d});
    print(rows, false, session);
    return 0;
  }
  if (auto ok = session.stage("read"); !ok) return ok.error();
  auto scan = read_scans({given.scan}, session);
  if (!scan) return scan.error();
  if (scan->cloud.rays.size() != scan->cloud.size())
    return bad_input(given.scan.string() + ": expected viewing rays, as of range images with poses, found none");
  if (auto ok = session.stage("views"); !ok) return ok.error();
  const NextViews next = next_views(*scan, {}, session.context);
  session.finish_stage();
  for (const auto& view : next.views) rows.push_back({view.direction, view.gain, view.overlap});
  session.print("Seen " + readable(next.seen) + " mm2; border of unseen space " + readable(next.unseen) +
                " mm2, of which no view sees " + readable(next.hidden) + " mm2\n");
  if (rows.empty())
    session.print("No further view would add half a percent.\n");
  else
    print(rows, true, session);
  return 0;
}

}  // namespace

Command views_command() {
  auto given = std::make_shared<ViewPlanArguments>();
  return {"views", "name the directions to scan from, or to scan from next", view_plan_help,
          [given](Arguments& a) {
            a.text(given->plan, "--plan", "SET",
                   "tetrahedron, octahedron, cube, icosahedron, dodecahedron or a number (default octahedron)");
            a.path(given->scan, "--scan", "SCAN", "range images so far: where to look next");
          },
          [given](Session& session) { return run_view_plan(*given, session); }};
}

}  // namespace partscribe::cli
