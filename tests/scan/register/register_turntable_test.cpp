/// A turntable's axis and steps are found, and a sensor whose depths are wrong is found out.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing::registration;

namespace {

/// A table that turns a part before a sensor, which looks along z.
struct Table {
  Vec3 point, axis;
  Pose table_from_part;        ///< z of the table is the sensor's; at the first view
  std::vector<double> turned;  ///< rad, of each view against the first; first_from_view
  double depth_scale = 1;      ///< what the sensor makes of depths
  double sigma = 0;            ///< mm along z
  int pixels = 100;            ///< across 45 mm
};

/// `plate`: mm below the middle of the part, where the table's own surface ends what the sensor sees; 0: it does not
/// show.
std::vector<RegisterView> seen_on(const Table& table, const Surface& part, double plate = 0, double width = 45) {
  std::vector<RegisterView> views(table.turned.size());
  Random random(7);
  const Vec3 up = table.axis.z() < 0 ? table.axis : Vec3(-table.axis);  // towards the sensor
  const Vec3 foot = table.point - plate * up;
  for (std::size_t k = 0; k < views.size(); ++k) {
    // The part was turned backwards as seen from the next view.
    const Mat3 turn = rotation_of(-table.turned[k] * table.axis);
    const Pose view_from_part = Pose{turn, table.point - turn * table.point} * table.table_from_part;
    const Pose part_from_view = view_from_part.inverse();
    const int size = table.pixels;
    views[k].width = views[k].height = size;
    for (int pixel = 0; pixel < size * size; ++pixel) {
      const Vec3 from((pixel % size - 0.5 * (size - 1)) * width / size + 2,
                      (pixel / size - 0.5 * (size - 1)) * width / size, 0);
      const auto hit = part.first_hit(part_from_view * from, part_from_view.rotation * Vec3::UnitZ());
      double distance = hit ? hit->distance : 1e30;
      if (plate > 0) distance = std::min(distance, up.dot(foot - from) / up.z());
      if (distance > 1e29) continue;
      const double depth = distance + (table.sigma > 0 ? table.sigma * random.normal() : 0);
      views[k].cloud.points.push_back(from + table.depth_scale * depth * Vec3::UnitZ());
      views[k].cloud.pixel.push_back(pixel), views[k].cloud.rays.push_back(Vec3::UnitZ());
    }
  }
  return views;
}

RegisterOptions on_table(bool correct_depth = false) {
  RegisterOptions options;
  options.arrangement = Arrangement::turntable, options.correct_depth = correct_depth;
  return options;
}

/// A drum whose side is strewn with low bumps.
Surface rough_drum() {
  Random random(3);
  std::vector<Ball> bumps;
  for (int k = 0; k < 90; ++k) {
    const double angle = random.uniform(0, 2 * pi), z = random.uniform(-14, 14);
    bumps.push_back({Vec3(8.9 * std::cos(angle), 8.9 * std::sin(angle), z), random.uniform(1.3, 1.7)});
  }
  return drum_with(bumps, {11, 11, 16});
}

/// Stands upright in the sensor's y, half a millimetre beside the middle of a table that leans a little; turned by
/// unequal steps.
Table uneven_table() {
  const double degree = pi / 180;
  Table table{
      Vec3(2, 0, 40), Vec3(0.02, 1, -0.05).normalized(), {}, {0, 31 * degree, 55 * degree, 96 * degree, 123 * degree}};
  table.table_from_part = {rotation_of(Vec3(pi / 2 + 0.03, 0, 0)), table.point + Vec3(0.4, 0, 0.3)};
  table.sigma = 0.02, table.pixels = 200;
  return table;
}

void check_steps(const Registration& found, const Table& table, double degrees_off) {
  REQUIRE(found.turntable);
  REQUIRE(found.turntable->steps.size() + 1 == table.turned.size());
  CHECK(found.turntable->step_observed);
  const double sign = found.turntable->axis.dot(table.axis) < 0 ? -1 : 1;
  for (std::size_t k = 0; k + 1 < table.turned.size(); ++k)
    CHECK(sign * found.turntable->steps[k] * 180 / pi ==
          Approx((table.turned[k + 1] - table.turned[k]) * 180 / pi).margin(degrees_off));
}

}  // namespace

TEST_CASE("register: a turntable's axis and step are found from views without poses") {
  const Vec3 point(4, -3, 60), axis = Vec3(0.1, 0.95, 0.2).normalized();
  const double step = 35 * pi / 180;
  const Registration found = run(
      seen_on({point, axis, {Mat3::Identity(), Vec3(0, 0, 60)}, {0, step, 2 * step, 3 * step}}, balls()), on_table());
  REQUIRE(found.turntable);
  CHECK(found.turntable->step_observed);
  CHECK(found.turntable->steps.empty());
  CHECK(found.turntable->step * 180 / pi == Approx(35).margin(0.3));
  CHECK(found.turntable->axis.dot(axis) > 0.9999);
  CHECK((found.turntable->point - point).cross(axis).norm() < 0.2);
  CHECK(count(found, ViewStatus::registered) == 3);
}

TEST_CASE("register: a table that shows in every view tells no step, the part on it does") {
  const double step = 35 * pi / 180;
  Table table{Vec3(4, -3, 60),
              Vec3(0.05, 0.7, -0.7).normalized(),
              {Mat3::Identity(), Vec3(0, 0, 60)},
              {0, step, 2 * step, 3 * step}};
  table.sigma = 0.02;
  const Registration found = run(seen_on(table, balls(), 12, 90), on_table());
  REQUIRE(found.turntable);
  CHECK(found.turntable->step_observed);
  CHECK(std::abs(found.turntable->step) * 180 / pi == Approx(35).margin(0.5));
  CHECK(std::abs(found.turntable->axis.dot(table.axis)) > 0.9995);
  CHECK((found.turntable->point - table.point).cross(table.axis).norm() < 0.3);
  CHECK(count(found, ViewStatus::registered) == 3);
  CHECK(std::any_of(found.warnings.begin(), found.warnings.end(),
                    [](const auto& w) { return w.find("stands still") != std::string::npos; }));
}

TEST_CASE("register: a table with nothing on it, or with what looks alike from all sides, is no turntable of steps 0") {
  const double step = 35 * pi / 180;
  Table table{Vec3(4, -3, 60), Vec3(0.05, 0.7, -0.7).normalized(), {}, {0, step, 2 * step, 3 * step}};
  table.sigma = 0.02, table.table_from_part.translation = table.point;
  for (const Surface& part : {ball(0.1), ball(10)}) {
    Context context;
    const auto found = register_views(seen_on(table, part, 5, 90), on_table(), context);
    if (!found.ok())
      CHECK(found.error().message.find("no such axis") != std::string::npos);
    else
      CHECK_FALSE(found->turntable->step_observed);
  }
}

TEST_CASE("register: the relief of a round part tells unequal steps of its turntable") {
  const Table table = uneven_table();
  const Registration found = run(seen_on(table, rough_drum()), on_table());
  check_steps(found, table, 0.3);
  CHECK(count(found, ViewStatus::registered) == 4);
  CHECK(std::abs(found.turntable->axis.dot(table.axis)) > 0.9999);
  CHECK_FALSE(found.depth);
  for (const auto& warning : found.warnings) CHECK(warning.find("depths") == std::string::npos);
}

TEST_CASE("register: a smooth round part does not tell the steps of its turntable, and that is said") {
  Table table = uneven_table();
  table.axis = Vec3::UnitY(), table.table_from_part = {rotation_of(Vec3(pi / 2, 0, 0)), table.point};  // in its middle
  const Registration found = run(seen_on(table, cylinder()), on_table());
  REQUIRE(found.turntable);
  CHECK_FALSE(found.turntable->step_observed);
  CHECK(found.turntable->steps.empty());
}

TEST_CASE("register: depths that do not fit widths are named, and corrected only on request") {
  Table table = uneven_table();
  table.depth_scale = 1.2;
  const auto views = seen_on(table, rough_drum());
  const auto names_depths = [](const Registration& r) {
    return std::any_of(r.warnings.begin(), r.warnings.end(), [](const auto& w) {
      return w.find("depths and widths of this scanner do not agree") != std::string::npos;
    });
  };
  const Registration raw = run(views, on_table());
  CHECK(names_depths(raw));
  CHECK_FALSE(raw.depth);
  const Registration found = run(views, on_table(true));
  CHECK(names_depths(found));
  REQUIRE(found.depth);
  CHECK(1 + found.depth->stretch == Approx(1 / 1.2).margin(0.01));
  CHECK(std::abs(found.depth->shear) < 0.01);
  check_steps(found, table, 0.5);
  CHECK(count(found, ViewStatus::registered) == 4);
  // Points go where they were before the sensor stretched them.
  Scan scan;
  scan.views.resize(views.size()), scan.cloud = views[0].cloud, scan.cloud.view.assign(scan.cloud.size(), 0);
  const std::vector<Vec3> before = scan.cloud.points;
  place_views(found, scan);
  REQUIRE(scan.cloud.size() == before.size());
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    most = std::max(most, ((scan.cloud.points[i] - scan.cloud.points[0]) -
                           (before[i] - before[0]).cwiseProduct(Vec3(1, 1, 1 / 1.2)))
                              .norm());
  CHECK(most < 0.3);
}
