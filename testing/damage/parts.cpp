#include "testing/damage/parts.h"

#include <cmath>
#include <set>
#include <stdexcept>

#include "core/files.h"
#include "core/number.h"
#include "core/random.h"
#include "geometry/points/kd_tree.h"
#include "model/json.h"
#include "scan/simulate/simulate.h"
#include "testing/places.h"
#include "verify/mutate/mutate.h"

namespace partscribe::testing {

using namespace scan;
using namespace verify;

namespace {

Expr p(const char* name) { return Expr::of(name); }

Model machined(const std::string& name, const std::string& note) {
  Model m;
  m.name = name;
  m.tolerance = 0.2;
  m.scan_from_part = {-8.25, 14.5, 22, radians(20), radians(-35), radians(50)};
  Object part;
  part.name = name;
  part.note = note;
  m.objects.push_back(part);
  return m;
}

void length(Model& m, const std::string& name, double value, const std::string& note) {
  Parameter q;
  q.name = name;
  q.value = q.fitted = value;
  q.sigma = q.sigma_noise = 0.004;
  q.points = 500;
  q.note = note;
  m.parameters.push_back(q);
}

/// Puts an object before the part.
void step(Model& m, const std::string& name, Shape shape, Frame frame = {}) {
  Object o;
  o.name = name;
  o.shape = std::move(shape);
  o.frame = frame;
  m.objects.insert(m.objects.end() - 1, o);
}

Model plate() {
  Model m = machined("plate", "a plate with five holes");
  length(m, "plate_length", 80, "along x");
  length(m, "plate_width", 50, "along y");
  length(m, "thickness", 8, "along z");
  length(m, "hole_radius", 3.5, "of the holes in the corners");
  length(m, "center_radius", 9, "of the hole in the middle");
  length(m, "margin", 8, "of the holes in the corners from the edges");
  step(m, "slab", Box{p("plate_length"), p("plate_width"), p("thickness")});
  const Expr through = p("thickness") + Expr(2), far_x = p("plate_length") - p("margin"),
             far_y = p("plate_width") - p("margin");
  const std::vector<std::pair<Expr, Expr>> corners = {
      {p("margin"), p("margin")}, {far_x, p("margin")}, {far_x, far_y}, {p("margin"), far_y}};
  std::vector<std::string> names = {"slab"};
  for (const auto& [x, y] : corners) {
    names.push_back("hole_" + print_number(double(names.size())));
    step(m, names.back(), Cylinder{p("hole_radius"), through}, {x, y, -1, 0, 0, 0});
  }
  names.push_back("center_hole");
  step(m, "center_hole", Cylinder{p("center_radius"), through},
       {p("plate_length") / Expr(2), p("plate_width") / Expr(2), -1, 0, 0, 0});
  m.objects.back().shape = Difference{names};
  return m;
}

Model block() {
  Model m = machined("block", "a block with a boss and a blind hole");
  length(m, "block_length", 50, "along x");
  length(m, "block_width", 40, "along y");
  length(m, "block_height", 20, "along z");
  length(m, "boss_radius", 10, "of the boss");
  length(m, "boss_height", 12, "above the block");
  length(m, "bore_radius", 5, "of the blind hole");
  length(m, "bore_depth", 18, "from the top of the boss");
  step(m, "base", Box{p("block_length"), p("block_width"), p("block_height")});
  step(m, "boss", Cylinder{p("boss_radius"), p("boss_height") + Expr(4)},
       {18, 17, p("block_height") - Expr(4), 0, 0, 0});
  step(m, "body", Union{{"base", "boss"}});
  step(m, "bore", Cylinder{p("bore_radius"), p("bore_depth") + Expr(1)},
       {18, 17, p("block_height") + p("boss_height") - p("bore_depth"), 0, 0, 0});
  m.objects.back().shape = Difference{{"body", "bore"}};
  return m;
}

Model flange() {
  Model m = machined("flange", "a flange with a hub and a bolt circle");
  length(m, "flange_radius", 38, "of the disc");
  length(m, "flange_height", 9, "of the disc");
  length(m, "hub_radius", 16, "of the hub");
  length(m, "hub_height", 24, "of the hub, from the bottom");
  length(m, "bore_radius", 10, "of the bore");
  length(m, "bolt_radius", 3.5, "of the bolt holes");
  length(m, "bolt_circle", 27, "radius of the circle of bolt holes");
  step(m, "disc", Cylinder{p("flange_radius"), p("flange_height")});
  step(m, "hub", Cylinder{p("hub_radius"), p("hub_height")});
  step(m, "body", Union{{"disc", "hub"}});
  step(m, "bore", Cylinder{p("bore_radius"), p("hub_height") + Expr(2)}, {0, 0, -1, 0, 0, 0});
  std::vector<std::string> names = {"body", "bore"};
  for (int i = 0; i < 5; ++i) {
    const double a = radians(10 + 72.0 * i);  // five holes, none on an axis: no mirror leaves the part as it is
    names.push_back("bolt_" + print_number(i + 1));
    step(m, names.back(), Cylinder{p("bolt_radius"), p("flange_height") + Expr(2)},
         {p("bolt_circle") * Expr(snapped(std::cos(a), 1e-6)), p("bolt_circle") * Expr(snapped(std::sin(a), 1e-6)), -1,
          0, 0, 0});
  }
  m.objects.back().shape = Difference{names};
  return m;
}

Model keyed_shaft() {
  Model m = machined("keyed_shaft", "a stepped shaft with a keyway and a centre hole");
  length(m, "shaft_radius", 12, "of the thick end");
  length(m, "shaft_length", 45, "of the thick end");
  length(m, "neck_radius", 8, "of the thin end");
  length(m, "neck_length", 25, "of the thin end");
  length(m, "key_width", 6, "of the keyway");
  length(m, "key_length", 26, "of the keyway");
  length(m, "key_depth", 3.5, "of the keyway");
  length(m, "center_radius", 3, "of the hole in the end");
  length(m, "center_depth", 10, "of the hole in the end");
  step(m, "shaft", Cylinder{p("shaft_radius"), p("shaft_length")});
  step(m, "neck", Cylinder{p("neck_radius"), p("shaft_length") + p("neck_length")});
  step(m, "body", Union{{"shaft", "neck"}});
  step(m, "keyway", Box{p("key_width"), p("key_depth") + Expr(3), p("key_length")},
       {-p("key_width") / Expr(2), p("shaft_radius") - p("key_depth"), 9, 0, 0, 0});
  step(m, "center_hole", Cylinder{p("center_radius"), p("center_depth") + Expr(1)}, {0, 0, -1, 0, 0, 0});
  m.objects.back().shape = Difference{{"body", "keyway", "center_hole"}};
  return m;
}

Model tray() {
  Model m = machined("tray", "an open box with two standoffs and a slot");
  length(m, "tray_length", 70, "along x, outside");
  length(m, "tray_width", 46, "along y, outside");
  length(m, "tray_height", 18, "along z, outside");
  length(m, "wall", 4, "thickness of walls and floor");
  length(m, "post_radius", 5, "of the standoffs");
  length(m, "post_height", 11, "of the standoffs, from the floor");
  length(m, "slot_width", 14, "of the slot in the front wall");
  step(m, "outside", Box{p("tray_length"), p("tray_width"), p("tray_height")});
  step(m, "inside",
       Box{p("tray_length") - Expr(2) * p("wall"), p("tray_width") - Expr(2) * p("wall"), p("tray_height")},
       {p("wall"), p("wall"), p("wall"), 0, 0, 0});
  step(m, "slot", Box{p("slot_width"), 8, 10}, {20, -2, 9, 0, 0, 0});
  step(m, "shell", Difference{{"outside", "inside", "slot"}});
  step(m, "post_1", Cylinder{p("post_radius"), p("post_height") + Expr(2)}, {18, 28, p("wall") - Expr(2), 0, 0, 0});
  step(m, "post_2", Cylinder{p("post_radius"), p("post_height") + Expr(2)}, {50, 20, p("wall") - Expr(2), 0, 0, 0});
  m.objects.back().shape = Union{{"shell", "post_1", "post_2"}};
  return m;
}

}  // namespace

Model golden_part(const std::string& part) {
  static const std::set<std::string> coarser = {"ellipsoid", "handle",         "nurbs_vase",
                                                "sphere",    "superellipsoid", "torus"};
  const Path file = source_file("tests/golden/" + part + "/model.json");
  const auto text = read_file(file);
  if (!text.ok()) throw std::runtime_error(text.error().message);
  auto model = read_model_json(*text, file.string());
  if (!model.ok()) throw std::runtime_error(model.error().message);
  model->tolerance = coarser.count(part) ? 0.4 : std::max(0.2, model->tolerance);
  return std::move(model).value();
}

std::vector<Model> machined_parts() { return {plate(), block(), flange(), keyed_shaft(), tray()}; }

Model part_named(const std::string& name) {
  for (auto& model : machined_parts())
    if (model.name == name) return model;
  return golden_part(name);
}

Scan scan_of(const Model& model, const ScanConditions& conditions) {
  Context context;
  context.threads = 2;
  const double sigma = conditions.sigma * model.tolerance;
  SimulateOptions options;
  options.views = "icosahedron";
  options.resolution = conditions.resolution;
  options.sigma = sigma;
  options.outliers = conditions.outliers;
  options.seed = 5;
  // A sheet has no outside: it is touched all over.
  const bool open = is_sheet(model.objects.back().shape);
  Scan scan;
  if (!open) scan = simulate(surface_of(model), options, context).merged;
  // Where no view reaches: even points, of a view without rays.
  const auto touched = surface_points(model, 8000, 5);
  const std::vector<Vec3> returned = scan.cloud.points;
  const KdTree seen(returned);
  Box3 box;
  for (const auto& p : touched) box.add(p.point);
  const double reach = 2.5 * box.diagonal() / conditions.resolution;
  Random random(3);
  const auto view = static_cast<std::int32_t>(scan.views.size());
  scan.views.push_back({});
  for (const auto& p : touched) {
    if (!open && seen.nearest_one(p.point).sq_distance < reach * reach) continue;
    scan.cloud.points.push_back(p.point + sigma * random.normal() * p.normal);
    if (!scan.cloud.rays.empty()) scan.cloud.rays.push_back(Vec3::Zero());
    if (!scan.cloud.normals.empty()) scan.cloud.normals.push_back(Vec3::Zero());
    if (!scan.cloud.sigma.empty()) scan.cloud.sigma.push_back(0);
    if (!scan.cloud.view.empty()) scan.cloud.view.push_back(view);
    if (!scan.cloud.pixel.empty()) scan.cloud.pixel.push_back(-1);
    if (!scan.cloud.rejected.empty()) scan.cloud.rejected.push_back(0);
  }
  return scan;
}

}  // namespace partscribe::testing
