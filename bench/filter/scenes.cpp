#include "bench/filter/scenes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "model/model.h"

namespace partscribe::filter_bench {
namespace {

Object object(const char* name, Shape shape, double x = 0, double y = 0, double z = 0, double rx = 0) {
  Object o;
  o.name = name, o.shape = std::move(shape);
  o.frame.x = x, o.frame.y = y, o.frame.z = z, o.frame.rx = rx;
  return o;
}

/// Flat faces, a boss and two bores.
Model bracket() {
  Model m;
  m.as_scanned = false;
  m.objects = {object("base", Box{60, 40, 10}),
               object("wall", Box{60, 10, 40}),
               object("boss", Cylinder{8, 20}, 40, 26, 0),
               object("body", Union{{"base", "wall", "boss"}}),
               object("bore", Cylinder{4, 60}, 40, 26, -5),
               object("window", Cylinder{9, 40}, 22, -10, 26, -1.5707963267948966),
               object("groove", Box{6, 60, 6}, 12, 12, 7),
               object("part", Difference{{"body", "bore", "window", "groove"}})};
  return m;
}

/// A sphere, a torus and a lying cylinder on a plate.
Model dome() {
  Model m;
  m.as_scanned = false;
  m.objects = {object("plate", Box{60, 60, 6}), object("ball", Sphere{18}, 20, 22, 4),
               object("ring", Torus{12, 5}, 44, 44, 6), object("bar", Cylinder{9, 50}, 50, 55, 6, 1.5707963267948966),
               object("part", Union{{"plate", "ball", "ring", "bar"}})};
  return m;
}

/// Origin and direction of a pixel's ray in the sensor's frame; the direction's z is 1.
std::pair<Vec3, Vec3> ray_of(const RangeImage& image, int row, int column) {
  if (image.projection == Projection::orthographic)
    return {{image.x0 + column * image.pitch_x, image.y0 + row * image.pitch_y, 0}, {0, 0, 1}};
  return {Vec3::Zero(), {(column - image.cx) / image.fx, (row - image.cy) / image.fy, 1}};
}

Truth truth_at(const Surface& surface, const RangeImage& image, const Vec3& origin, const Vec3& ray, double sigma) {
  const Pose& pose = image.world_from_view;
  const Vec3 direction = pose.rotation * ray.normalized();
  const auto hit = surface.first_hit(pose * origin, direction);
  Truth t;
  t.depth = hit ? hit->distance / ray.norm() : std::numeric_limits<double>::quiet_NaN();
  if (!hit) return t;
  t.normal = pose.rotation.transpose() * hit->normal;
  t.sigma = sigma / std::max(-hit->normal.dot(direction), 1.0 / 3);  // as the simulator adds it
  return t;
}

void mark_edges(Scene& scene) {
  const RangeImage& image = scene.image;
  const auto at = [&](int r, int c) -> Truth* {
    if (r < 0 || c < 0 || r >= image.height || c >= image.width) return nullptr;
    return &scene.truth[static_cast<std::size_t>(r) * static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(c)];
  };
  const auto point = [&](int r, int c) {
    const auto [origin, ray] = ray_of(image, r, c);
    return Vec3(origin + at(r, c)->depth * ray);
  };
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c) {
      Truth& own = *at(r, c);
      if (std::isnan(own.depth)) continue;
      const Vec3 p = point(r, c);
      for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) {
          const Truth* other = at(r + y, c + x);
          own.edge = own.edge || !other || std::isnan(other->depth) || other->normal.dot(own.normal) < 0.9 ||
                     std::abs(own.normal.dot(point(r + y, c + x) - p)) > 0.5 * image.pitch_x;
        }
    }
}

}  // namespace

double Scene::depth_at(double x, double y) const { return truth_at(surface, image, {x, y, 0}, {0, 0, 1}, 0).depth; }

Scene scene_of(const SceneOptions& options) {
  Scene scene;
  scene.surface = surface_of(options.part == "dome" ? dome() : bracket());
  SimulateOptions simulation;
  simulation.views = "cube";
  simulation.resolution = options.resolution;
  simulation.bits = options.bits;
  simulation.sigma = options.sigma;
  simulation.bit_error = options.bit_error;
  simulation.mixed = options.mixed, simulation.outliers = options.outliers;
  simulation.projection = options.projection;
  Context context;
  context.threads = 2;
  scene.image = simulate(scene.surface, simulation, context).views.front().image;
  for (int r = 0; r < scene.image.height; ++r)
    for (int c = 0; c < scene.image.width; ++c) {
      const auto [origin, ray] = ray_of(scene.image, r, c);
      scene.truth.push_back(truth_at(scene.surface, scene.image, origin, ray, options.sigma));
    }
  mark_edges(scene);
  return scene;
}

}  // namespace partscribe::filter_bench
