#include "testing/recovery/cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/ensure.h"
#include "core/number.h"
#include "core/random.h"
#include "model/distance/distance.h"
#include "scan/read/read.h"
#include "testing/recovery/facets.h"
#include "testing/recovery/parts.h"

namespace partscribe::testing::recovery {

using namespace scan;

namespace {

constexpr double steepest = 1.36;  // rad from the normal; beyond, nothing returns
constexpr double thinning_angle = pi / 3;

Vec3 random_direction(Random& random) {
  Vec3 v{random.normal(), random.normal(), random.normal()};
  return v / std::max(v.norm(), 1e-12);
}

Mat3 random_rotation(Random& random) {
  return Eigen::Quaterniond{random.normal(), random.normal(), random.normal(), random.normal()}
      .normalized()
      .toRotationMatrix();
}

Pose random_place(Random& random) {
  return {random_rotation(random), 100 * Vec3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}};
}

struct Hit {
  Vec3 point, normal;
};

/// Looks at a part along rays, by sphere tracing on its exact distance.
class Target {
 public:
  Target(const Model& model, const Box3& bounds)
      : distance_(model), middle_(bounds.center()), radius_(0.5 * bounds.diagonal()) {}
  const Vec3& middle() const { return middle_; }
  double radius() const { return radius_; }

  /// Where the ray first meets the surface, from a place outside.
  std::optional<Hit> first_hit(const Vec3& origin, const Vec3& direction) const {
    const auto t = trace(origin, direction, 0);
    if (!t) return std::nullopt;
    const Vec3 p = origin + *t * direction;
    return Hit{p, normal(p)};
  }
  /// True if nothing stands between a place on the surface and a sensor far away.
  bool open_towards(const Hit& place, const Vec3& sensor) const {
    return !trace(place.point + 0.01 * radius_ * sensor, sensor, 0);
  }

 private:
  std::optional<double> trace(const Vec3& origin, const Vec3& direction, double t) const {
    const double along = (middle_ - origin).dot(direction);
    const double off = (origin + along * direction - middle_).squaredNorm(), reach = 1.02 * radius_;
    if (off > reach * reach) return std::nullopt;
    const double half = std::sqrt(reach * reach - off), end = along + half;
    double before = t = std::max(t, along - half);
    for (int i = 0; i < 300 && t <= end; ++i) {
      const double d = distance_(origin + t * direction).distance;
      if (d < 1e-7 * radius_) {
        // A step taken too far is halved back.
        double low = before, high = t;
        for (int k = 0; k < 50 && d < 0 && high - low > 1e-9 * radius_; ++k) {
          const double m = 0.5 * (low + high);
          (distance_(origin + m * direction).distance > 0 ? low : high) = m;
        }
        return d < 0 ? 0.5 * (low + high) : t;
      }
      before = t, t += std::max(d, 1e-5 * radius_);
    }
    return std::nullopt;
  }
  Vec3 normal(const Vec3& p) const {
    const double h = 1e-6 * radius_;
    Vec3 g;
    for (int k = 0; k < 3; ++k)
      g[k] = distance_(p + h * Vec3::Unit(k)).distance - distance_(p - h * Vec3::Unit(k)).distance;
    return g.norm() > 0 ? Vec3(g.normalized()) : Vec3(0, 0, 1);
  }

  ModelDistance distance_;
  Vec3 middle_;
  double radius_;
};

/// One orthographic view and the round shadows in it.
struct Sensor {
  Vec3 towards;  // from the part to the sensor
  struct Shadow {
    Vec3 centre;
    double radius;
  };
  std::vector<Shadow> shadows;

  bool lit(const Vec3& p) const {
    return std::none_of(shadows.begin(), shadows.end(), [&](const Shadow& s) {
      const Vec3 d = p - s.centre;
      return (d - towards * towards.dot(d)).norm() < s.radius;
    });
  }
};

/// Views from one side that see the share that is asked for.
std::vector<Sensor> placed_sensors(const Target& target, double wanted, Random& random, double& seen) {
  std::vector<Hit> places;  // random lines find every place of a convex body equally often
  for (int i = 0; i < 20000 && places.size() < 1200; ++i) {
    const Vec3 direction = random_direction(random), u = random_direction(random).cross(direction).normalized();
    const Vec3 offset = target.radius() * std::sqrt(random.uniform()) * u;
    const auto hit = target.first_hit(target.middle() + offset - 2 * target.radius() * direction, direction);
    if (hit) places.push_back(*hit);
  }
  const auto visible = [&](const Vec3& towards) {
    std::vector<char> v(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      v[i] = places[i].normal.dot(towards) > std::cos(1.25) && target.open_towards(places[i], towards);
    return v;
  };
  const auto share = [&](const std::vector<Sensor>& sensors, const std::vector<std::vector<char>>& view) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
      for (std::size_t s = 0; s < sensors.size(); ++s)
        if (view[s][i] && sensors[s].lit(places[i].point)) {
          ++count;
          break;
        }
    return double(count) / double(std::max<std::size_t>(places.size(), 1));
  };
  std::vector<Sensor> best;
  std::vector<std::vector<char>> best_view;
  seen = 0;
  for (int attempt = 0; attempt < 60 && seen < wanted; ++attempt) {
    std::vector<Sensor> sensors = {{random_direction(random), {}}};
    std::vector<std::vector<char>> view = {visible(sensors[0].towards)};
    double now = share(sensors, view);
    for (int more = 0; more < 2 && now < wanted; ++more) {
      // From the same side: no sensor looks against the first.
      Vec3 next = random_direction(random);
      for (int k = 0; k < 200 && !(next.dot(sensors[0].towards) > -0.2 && next.dot(sensors[0].towards) < 0.7); ++k)
        next = random_direction(random);
      sensors.push_back({next, {}});
      view.push_back(visible(next));
      now = share(sensors, view);
    }
    if (now > seen) seen = now, best = sensors, best_view = view;
  }
  for (int attempt = 0; attempt < 100 && seen > wanted + 0.02; ++attempt) {
    const Hit& place = places[random.below(places.size())];
    const Sensor::Shadow shadow{place.point, random.uniform(0.1, 0.5) * target.radius()};
    auto trial = best;
    for (auto& s : trial) s.shadows.push_back(shadow);
    const double now = share(trial, best_view);
    if (now > wanted - 0.02 && now < seen) best = trial, seen = now;
  }
  return best;
}

/// Looks at what lies about the x axis, somewhat from above or below.
Sensor sensor_before_arc(Random& random) {
  const double y = random.uniform(-0.2, 0.2), z = random.uniform(-0.6, 0.6);
  return {Vec3(1, y, z).normalized(), {}};
}

/// A coarse mesh as it is read from a file: corners in single precision, and samples where they are far apart.
void scan_mesh(Case& c, const Part& part, const Conditions& conditions, Random& random) {
  const int around =
      conditions.least_facets +
      static_cast<int>(random.below(static_cast<std::uint64_t>(conditions.most_facets - conditions.least_facets + 1)));
  TriangleMesh mesh = coarse_mesh(part.model, around);
  c.noise = std::max(sagitta_of(mesh, part.model), 1e-4 * c.size);
  const double wanted = std::max(c.noise, 1e-3 * c.size);
  c.tolerance = snapped(wanted, power_of_ten_below(wanted / 10));
  c.close = c.noise;
  const Vec3 towards = random_direction(random);
  const double whole = area(mesh);
  if (random.uniform() < 0.5) mesh = without_far_side(mesh, towards, 1 - conditions.seen);
  c.seen = area(mesh) / whole;
  c.scan.mesh = transformed(mesh, c.scan_from_part);
  for (Vec3& v : c.scan.mesh.vertices) v = v.cast<float>().cast<double>();
  c.scan.cloud.points = c.scan.mesh.vertices;
  c.scan.cloud.normals = vertex_normals(c.scan.mesh);
  const SurfaceSamples samples = sample_coarse_mesh(c.scan.mesh);
  c.scan.cloud.points.insert(c.scan.cloud.points.end(), samples.points.begin(), samples.points.end());
  c.scan.cloud.normals.insert(c.scan.cloud.normals.end(), samples.normals.begin(), samples.normals.end());
  c.scan.files = {"simulated"};
  c.scan.views.push_back({"simulated", {}, false, 0, 0});
  // The true places below some of the points.
  const ModelDistance distance(part.model);
  const Pose part_from_scan = c.scan_from_part.inverse();
  const std::size_t step = std::max<std::size_t>(1, c.scan.cloud.size() / conditions.points);
  const double h = 1e-6 * c.size;
  for (std::size_t i = 0; i < c.scan.cloud.size(); i += step) {
    Vec3 p = part_from_scan * c.scan.cloud.points[i];
    for (int round = 0; round < 3; ++round) {
      Vec3 g;
      for (int k = 0; k < 3; ++k)
        g[k] = (distance(p + h * Vec3::Unit(k)).distance - distance(p - h * Vec3::Unit(k)).distance) / (2 * h);
      p -= g * distance(p).distance;
    }
    if (std::abs(distance(p).distance) > 1e-4 * c.size) continue;
    c.exact.push_back(c.scan_from_part * p);
    c.sigma.push_back(c.noise);
  }
}

}  // namespace

const std::vector<std::string>& kinds() {
  static const std::vector<std::string> list = {"sphere",      "ellipsoid", "superellipsoid", "box",         "wedge",
                                                "cylinder",    "cone",      "torus",          "supertoroid", "fillet",
                                                "half_spaces", "revolve",   "extrude"};
  return list;
}

const std::vector<std::string>& degenerate_kinds() {
  static const std::vector<std::string> list = {"cone_1deg", "cylinder_30deg", "torus_fat", "torus_patch",
                                                "ellipsoid_round"};
  return list;
}

Conditions standard_conditions() { return {}; }

Conditions clean_conditions() {
  Conditions c;
  c.least_outliers = c.most_outliers = 0;
  return c;
}

Conditions hardest_conditions() {
  Conditions c;
  c.least_noise = c.most_noise = 0.01;
  c.least_outliers = c.most_outliers = 0.3;
  c.seen = 1.0 / 3;
  return c;
}

Conditions facet_conditions() {
  Conditions c;
  c.least_noise = c.most_noise = c.least_outliers = c.most_outliers = 0;
  c.least_facets = 20, c.most_facets = 50;
  return c;
}

Case make_case(const std::string& kind, const Conditions& conditions, std::uint64_t seed) {
  Random random(seed * 7919 + 17);
  for (int i = 0; i < 4; ++i) random.next();
  Case c;
  const auto& nearly = degenerate_kinds();
  const bool degenerate = std::find(nearly.begin(), nearly.end(), kind) != nearly.end();
  c.kind = kind.substr(0, degenerate ? kind.find('_') : kind.size());
  const Part part = degenerate ? degenerate_part(kind, random) : random_part(kind, random);
  c.truth = part.model;
  c.size = part.bounds.size().maxCoeff();
  if (conditions.least_facets > 0) {
    c.scan_from_part = random_place(random);
    scan_mesh(c, part, conditions, random);
    return c;
  }
  c.noise =
      c.size * conditions.least_noise * std::pow(conditions.most_noise / conditions.least_noise, random.uniform());
  c.tolerance = snapped(3 * c.noise, power_of_ten_below(c.noise / 10));
  c.close = 0.3 * c.noise;
  c.scan_from_part = random_place(random);
  const double wanted = random.uniform(conditions.least_outliers, conditions.most_outliers);
  const bool with_rays = random.uniform() < 0.5;

  const Target target(part.model, part.bounds);
  const double r = target.radius();
  const std::vector<Sensor> sensors =
      part.arc > 0 ? std::vector{sensor_before_arc(random)} : placed_sensors(target, conditions.seen, random, c.seen);
  const Vec3 dense = random_direction(random);
  const auto surface_count = static_cast<std::size_t>(double(conditions.points) * (1 - wanted));
  struct Return {
    Vec3 point, ray;
    int view;
  };
  std::vector<Return> returns;
  std::vector<Vec3> edges, edge_rays;  // places beside which the ray sees farther
  const auto start_of = [&](const Sensor& s, const Vec3& p) {
    return Vec3(p + (2 * r - (p - target.middle()).dot(s.towards)) * s.towards);
  };
  for (std::size_t attempt = 0; attempt < 100 * surface_count && c.exact.size() < surface_count; ++attempt) {
    const auto v = attempt % sensors.size();
    const Sensor& s = sensors[v];
    const Vec3 u = s.towards.unitOrthogonal(), w = s.towards.cross(u);
    const double angle = 2 * pi * random.uniform(), radius = r * std::sqrt(random.uniform());
    const Vec3 origin = start_of(s, target.middle() + radius * (std::cos(angle) * u + std::sin(angle) * w));
    const double keep = random.uniform(), thin = random.uniform(), noise = random.normal();
    const auto hit = target.first_hit(origin, -s.towards);
    if (!hit || !s.lit(hit->point)) continue;
    if (part.arc > 0 && std::abs(std::atan2(hit->point.y(), hit->point.x())) > part.arc / 2) continue;
    const double place = std::clamp(0.5 + (hit->point - target.middle()).dot(dense) / c.size, 0.0, 1.0);
    if (keep > std::pow(conditions.density_ratio, place - 1)) continue;
    const double cosine = hit->normal.dot(s.towards), incidence = std::acos(std::clamp(cosine, -1.0, 1.0));
    if (incidence > steepest ||
        (incidence > thinning_angle && thin < (incidence - thinning_angle) / (steepest - thinning_angle)))
      continue;
    const double along = c.noise / std::max(cosine, 1.0 / 3);
    c.exact.push_back(c.scan_from_part * hit->point);
    c.sigma.push_back(along * cosine);
    returns.push_back({hit->point - noise * along * s.towards, -s.towards, static_cast<int>(v)});
    c.measured.push_back(c.scan_from_part * returns.back().point);
    if (incidence > 1.1) edges.push_back(hit->point), edge_rays.push_back(-s.towards);
  }
  // Outliers: anywhere in a larger box, in clusters, behind edges, and with one bit of the range flipped.
  const std::size_t good = returns.size();
  const auto count = static_cast<std::size_t>(std::round(double(good) * wanted / (1 - wanted)));
  struct Cluster {
    Vec3 centre;
    double width;
  };
  std::vector<Cluster> clusters;
  for (int i = 0; i < 3; ++i)
    clusters.push_back({target.middle() + 1.3 * r * random_direction(random), c.size * random.uniform(0.01, 0.05)});
  for (std::size_t i = 0; i < count; ++i) {
    const double which = i / double(count);
    const Return& near = returns[random.below(good)];
    Return outlier = near;
    if (which < 0.45) {
      for (int k = 0; k < 3; ++k)
        outlier.point[k] = target.middle()[k] + 0.7 * part.bounds.size()[k] * random.uniform(-1, 1);
    } else if (which < 0.6) {
      const Cluster& cluster = clusters[random.below(clusters.size())];
      outlier.point = cluster.centre + cluster.width * Vec3{random.normal(), random.normal(), random.normal()};
    } else if (which < 0.8 && !edges.empty()) {
      const auto e = random.below(edges.size());
      outlier.point = edges[e] + edge_rays[e] * random.uniform(0.02, 0.6) * c.size, outlier.ray = edge_rays[e];
    } else {
      const double bit = std::pow(0.5, 1 + double(random.below(8)));
      outlier.point += (random.uniform() < 0.5 ? -1 : 1) * bit * 2 * r * outlier.ray;
    }
    returns.push_back(outlier);
  }
  c.outliers = double(count) / double(returns.size());
  // No order to lean on.
  for (std::size_t i = returns.size(); i > 1; --i) std::swap(returns[i - 1], returns[random.below(i)]);
  c.scan.files = {"simulated"};
  for (const auto& p : returns) {
    c.scan.cloud.points.push_back(c.scan_from_part * p.point);
    if (!with_rays) continue;
    c.scan.cloud.rays.push_back(c.scan_from_part.rotation * p.ray);
    c.scan.cloud.view.push_back(p.view);
  }
  for (std::size_t v = 0; v < (with_rays ? sensors.size() : 1); ++v)
    c.scan.views.push_back({"simulated", {}, false, 0, 0});
  return c;
}

}  // namespace partscribe::testing::recovery
