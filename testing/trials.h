/// Seeded repetitions of a measurement: views of a part with known truth and one kind of trouble at a time.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/random.h"
#include "fit/refine/refine.h"
#include "model/distance/distance.h"
#include "testing/models.h"

namespace partscribe::testing {

using namespace fit;

/// What is wrong with the data besides white noise along the line of sight.
enum class Trouble { none, uneven, correlated, poses, facets, filtered, outliers };

struct TrialOptions {
  int views = 8;
  int resolution = 40;   ///< pixels a side
  double sigma = 0.05;   ///< mm, along the normal
  double turn = 0.0005;  ///< rad about each axis, standard deviation of a disturbed pose
  double shift = 0.02;   ///< mm along each axis
  int filter = 1;        ///< pixels that a filter's mean takes in to each side
  double step = 1.5;     ///< pixels of range; what differs by more is kept out of the mean
  bool rays = true;      ///< false: the points do not know where they were seen from, nor in which view
};

/// A part of known size, where it stands, and which of its parameters are asked for.
struct TrialPart {
  std::string name;
  Model truth;  ///< in its own frame
  Pose scan_from_part;
};

inline std::vector<TrialPart> trial_parts() {
  const auto p = [](const char* name) { return Expr::of(name); };
  const Pose place{rotation_of({0.3, -0.5, 0.2}), {12, -7, 30}};
  Loop outline = polygon({{Expr(0), Expr(0)},
                          {p("width"), Expr(0)},
                          {p("width"), p("step_depth")},
                          {p("step_width"), p("step_depth")},
                          {p("step_width"), p("depth")},
                          {Expr(0), p("depth")}});
  return {
      {"sphere", model_with(Sphere{p("radius")}, {length("radius", 12)}), place},
      {"cylinder", model_with(Cylinder{p("radius"), p("height")}, {length("radius", 8), length("height", 25)}), place},
      {"cone",
       model_with(Cone{p("bottom_radius"), p("top_radius"), p("height")},
                  {length("bottom_radius", 12), length("top_radius", 5), length("height", 20)}),
       place},
      {"pin", pin(), place},
      {"block",
       model_with(Extrude{{{outline}}, p("height")},
                  {length("width", 40), length("depth", 30), length("step_width", 22), length("step_depth", 17),
                   length("height", 15)}),
       place}};
}

/// What one noise-free pixel sees, in the scan's frame.
struct Sighting {
  bool hit = false;
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  double cosine = 0;
};

struct TrialView {
  Vec3 ray;
  std::vector<Sighting> pixels;  ///< resolution squared
};

/// The noise-free views of a part; made once for all runs.
struct TrialScene {
  TrialPart part;
  TrialOptions options;
  std::vector<TrialView> views;
  Vec3 center = Vec3::Zero();
  double pitch = 0;
};

/// The truth's last object, without what else its model says.
inline Model only_shape_of(const Model& truth) {
  Candidate part;
  part.object_name = "part";
  part.shape = truth.objects.back().shape;
  part.parameters = truth.parameters;
  return bare_model(part);
}

inline TrialScene scene_of(const TrialPart& part, const TrialOptions& options) {
  TrialScene scene{part, options, {}, {}, 0};
  const ModelDistance distance(only_shape_of(part.truth));
  const Pose part_from_scan = part.scan_from_part.inverse();
  // Bounds by looking: the farthest place along each axis that is still inside.
  Box3 box;
  Random random(7);
  for (int i = 0; i < 200000; ++i) {
    const Vec3 q(random.uniform(-70, 70), random.uniform(-70, 70), random.uniform(-70, 70));
    if (distance(q).distance <= 0) box.add(q);
  }
  const double radius = 0.53 * box.diagonal();
  scene.center = part.scan_from_part * box.center();
  scene.pitch = 2 * radius / options.resolution;
  for (int v = 0; v < options.views; ++v) {
    const double z = 1 - (2.0 * v + 1) / options.views, r = std::sqrt(1 - z * z), a = 2.399963 * v;
    TrialView view;
    view.ray = -(rotation_of({0.31, 0.17, 0.05}) * Vec3(r * std::cos(a), r * std::sin(a), z));
    const Mat3 frame = rotation_onto_axis(view.ray);
    view.pixels.resize(std::size_t(options.resolution) * std::size_t(options.resolution));
    for (int row = 0; row < options.resolution; ++row)
      for (int column = 0; column < options.resolution; ++column) {
        const double half = 0.5 * (options.resolution - 1);
        const Vec3 start = scene.center - radius * view.ray +
                           scene.pitch * ((column - half) * frame.col(0) + (row - half) * frame.col(1));
        double t = 0, d = 0;
        for (int step = 0; step < 400 && t < 2 * radius; ++step) {
          d = distance(part_from_scan * (start + t * view.ray)).distance;
          if (d < 1e-9) break;
          t += d;
        }
        if (t >= 2 * radius || d > 1e-7) continue;
        const Vec3 hit = start + t * view.ray;
        Vec3 g;
        for (int k = 0; k < 3; ++k)
          g[k] = distance(part_from_scan * (hit + 1e-5 * Vec3::Unit(k))).distance -
                 distance(part_from_scan * (hit - 1e-5 * Vec3::Unit(k))).distance;
        g.normalize();
        const double cosine = -g.dot(view.ray);
        if (cosine < 0.25) continue;
        view.pixels[std::size_t(row * options.resolution + column)] = {true, hit, g, cosine};
      }
    scene.views.push_back(std::move(view));
  }
  return scene;
}

/// Standard normal numbers on an image, smoothed where asked (binomial 3 x 3, unit variance again).
inline std::vector<double> noise_image(int size, bool smooth, Random& random) {
  const int wide = size + 2;
  std::vector<double> raw(std::size_t(wide * wide)), result(std::size_t(size * size));
  for (auto& v : raw) v = random.normal();
  for (int r = 0; r < size; ++r)
    for (int c = 0; c < size; ++c) {
      double sum = 0;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          sum += (i == 1 ? 2 : 1) * (j == 1 ? 2 : 1) * raw[std::size_t((r + i) * wide + c + j)];
      result[std::size_t(r * size + c)] = smooth ? sum / 6 : raw[std::size_t((r + 1) * wide + c + 1)];
    }
  return result;
}

/// A chordal triangulation of a turned part: `segments` around, arcs of the profile cut into as fine pieces; corners
/// lie on the true surface. Only for shapes of revolution.
inline TriangleMesh faceted(const TrialPart& part, int segments, double phase) {
  const EvaluatedShape shape = evaluate(part.truth.objects.back().shape, values_of(part.truth));
  std::vector<Vec2> profile;  // radius, z; from the lower to the upper end of the axis
  auto arc = [&](const Vec2& center, double radius, double from, double to) {
    const int pieces = std::max(2, int(std::ceil(std::abs(to - from) / (2 * pi) * segments)));
    for (int i = 0; i <= pieces; ++i) {
      const double a = from + (to - from) * i / pieces;
      profile.emplace_back(center + radius * Vec2(std::cos(a), std::sin(a)));
    }
  };
  if (const auto* s = std::get_if<SphereOf<double>>(&shape)) arc({0, 0}, s->radius, -pi / 2, pi / 2);
  if (const auto* s = std::get_if<CylinderOf<double>>(&shape))
    profile = {{0, 0}, {s->radius, 0}, {s->radius, s->height}, {0, s->height}};
  if (const auto* s = std::get_if<ConeOf<double>>(&shape))
    profile = {{0, 0}, {s->bottom_radius, 0}, {s->top_radius, s->height}, {0, s->height}};
  if (const auto* s = std::get_if<RevolveOf<double>>(&shape))
    for (const auto& e : s->sketch.loops[0].elements) {
      if (const auto* q = std::get_if<SketchPointOf<double>>(&e)) profile.emplace_back(q->x, q->y);
      if (const auto* a = std::get_if<SketchArcOf<double>>(&e))
        arc({a->center_x, a->center_y}, a->radius, a->from, a->to);
    }
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(segments);
  for (const auto& q : profile)
    for (std::uint32_t k = 0; k < n; ++k) {
      const double a = phase + 2 * pi * k / segments;
      mesh.vertices.push_back(part.scan_from_part *
                              Vec3(std::max(q.x(), 0.0) * std::cos(a), std::max(q.x(), 0.0) * std::sin(a), q.y()));
    }
  for (std::uint32_t i = 0; i + 1 < profile.size(); ++i)
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t a = i * n + k, b = i * n + (k + 1) % n, c = a + n, d = b + n;
      if (profile[i].x() > 1e-9) mesh.triangles.push_back({a, b, d});
      if (profile[i + 1].x() > 1e-9) mesh.triangles.push_back({a, d, c});
    }
  return welded(mesh, 1e-9);
}

/// Corners and evenly spread points of a mesh, as a reader of coarse files delivers them.
inline Scan scan_of(TriangleMesh mesh, std::size_t count, Random& random) {
  Scan scan;
  scan.cloud.points = mesh.vertices;
  scan.cloud.normals = vertex_normals(mesh);
  std::vector<double> sum;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    sum.push_back((sum.empty() ? 0 : sum.back()) + a);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto t =
        static_cast<std::size_t>(std::lower_bound(sum.begin(), sum.end(), random.uniform() * sum.back()) - sum.begin());
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    scan.cloud.points.push_back(mesh.corner(t, 0) + u * (mesh.corner(t, 1) - mesh.corner(t, 0)) +
                                v * (mesh.corner(t, 2) - mesh.corner(t, 0)));
    scan.cloud.normals.push_back(triangle_normal(mesh, t));
  }
  scan.mesh = std::move(mesh);
  return scan;
}

/// Standard deviation along the normal that a pixel of view `v` has.
inline double level_of(const TrialScene& scene, Trouble trouble, std::size_t v, const Sighting& pixel) {
  if (trouble != Trouble::uneven) return scene.options.sigma;
  return scene.options.sigma * (v % 2 ? 0.4 : 1.6) * (1 + 0.3 * (1 / std::pow(std::max(pixel.cosine, 0.1), 2) - 1));
}

/// One measurement of the scene.
inline Scan measured(const TrialScene& scene, Trouble trouble, std::uint64_t seed) {
  Random random(seed * 7919 + 13);
  const auto& o = scene.options;
  if (trouble == Trouble::facets) {
    const int segments = 20 + static_cast<int>(random.below(30));
    return scan_of(faceted(scene.part, segments, random.uniform(0, 2 * pi)), 4000, random);
  }
  Scan scan;
  scan.views.resize(scene.views.size());
  const int size = o.resolution;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const auto& view = scene.views[v];
    const auto white = noise_image(size, trouble == Trouble::correlated, random);
    Vec3 turn = Vec3::Zero(), shift = Vec3::Zero();
    for (int k = 0; k < 3; ++k) turn[k] = o.turn * random.normal(), shift[k] = o.shift * random.normal();
    if (trouble != Trouble::poses) turn = shift = Vec3::Zero();
    const Mat3 rotation = rotation_of(turn);
    std::vector<double> along(view.pixels.size());  // range error
    for (std::size_t i = 0; i < along.size(); ++i) {
      const double level = level_of(scene, trouble, v, view.pixels[i]);
      along[i] = level * white[i] / std::max(view.pixels[i].cosine, 1e-3);
    }
    if (trouble == Trouble::filtered) {
      const auto raw = along;
      auto range = [&](std::size_t i) { return (view.pixels[i].point - scene.center).dot(view.ray) + raw[i]; };
      for (int r = 0; r < size; ++r)
        for (int c = 0; c < size; ++c) {
          const auto i = std::size_t(r * size + c);
          if (!view.pixels[i].hit) continue;
          double sum = 0, count = 0;
          for (int a = std::max(r - o.filter, 0); a <= std::min(r + o.filter, size - 1); ++a)
            for (int b = std::max(c - o.filter, 0); b <= std::min(c + o.filter, size - 1); ++b) {
              const auto j = std::size_t(a * size + b);
              if (view.pixels[j].hit && std::abs(range(j) - range(i)) < o.step * scene.pitch)
                sum += range(j), count += 1;
            }
          along[i] = sum / count - (range(i) - raw[i]);
        }
    }
    for (std::size_t i = 0; i < along.size(); ++i) {
      if (!view.pixels[i].hit) continue;
      Vec3 p = view.pixels[i].point + along[i] * view.ray;
      if (trouble == Trouble::outliers && random.uniform() < 0.1) p += view.ray * random.uniform(-1, 1) * 10;
      p = rotation * (p - scene.center) + scene.center + shift;
      scan.cloud.points.push_back(p);
      if (!o.rays) continue;
      scan.cloud.rays.push_back(view.ray);
      scan.cloud.view.push_back(static_cast<std::int32_t>(v));
      scan.cloud.pixel.push_back(static_cast<std::int32_t>(i));
      scan.cloud.normals.push_back(view.pixels[i].normal);
    }
  }
  return scan;
}

/// The Cramer-Rao bound of every parameter for white noise on the scene's points, by central differences at the truth.
inline std::vector<double> cramer_rao(const TrialScene& scene, Trouble trouble) {
  const auto& parameters = scene.part.truth.parameters;
  const auto n = static_cast<Eigen::Index>(parameters.size());
  const Model model = only_shape_of(scene.part.truth);
  const Pose part_from_scan = scene.part.scan_from_part.inverse();
  std::vector<ModelDistance> up, down;
  const double h = 1e-5;
  for (const auto& p : parameters) {
    Values v = values_of(model);
    v[p.name] += h, up.emplace_back(model, v);
    v[p.name] -= 2 * h, down.emplace_back(model, v);
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n + 6, n + 6);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    for (const auto& pixel : scene.views[v].pixels) {
      if (!pixel.hit) continue;
      const Vec3 q = part_from_scan * pixel.point;
      Eigen::VectorXd row(n + 6);
      for (Eigen::Index k = 0; k < n; ++k)
        row[k] = (up[std::size_t(k)](q).distance - down[std::size_t(k)](q).distance) / (2 * h);
      row.segment<3>(n) = -pixel.normal;
      row.segment<3>(n + 3) = -(pixel.point - scene.center).cross(pixel.normal) / 20;
      information += row * row.transpose() / std::pow(level_of(scene, trouble, v, pixel), 2);
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  Eigen::VectorXd inverse = eigen.eigenvalues();
  for (auto& v : inverse) v = v > 1e-9 * information.trace() / double(n + 6) ? 1 / v : 0;
  const Eigen::MatrixXd covariance = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
  std::vector<double> bound;
  for (Eigen::Index k = 0; k < n; ++k) bound.push_back(std::sqrt(covariance(k, k)));
  return bound;
}

/// What many runs say of one parameter, mm or rad.
struct TrialNumber {
  std::string name;
  double bias = 0;   ///< mean error
  double error = 0;  ///< rms
  double noise = 0;  ///< rms of sigma_noise
  double sigma = 0;  ///< rms
  double held = 0;   ///< share of 95 % intervals from sigma that hold the truth
};

/// What many runs say of one scene and trouble, over all parameters.
struct TrialSummary {
  int runs = 0;
  double efficiency = 0;  ///< rms error / Cramer-Rao bound of white noise, quadratic mean over the parameters
  double worst_efficiency = 0;
  double noise_coverage = 0;  ///< share of 95 % intervals from sigma_noise that hold the truth
  double total_coverage = 0;  ///< from sigma
  double worst_coverage = 1;  ///< of the parameter that does worst, from sigma
  /// rms of sigma_noise / rms error, quadratic mean; parameters a tenth of the bound exact left out
  double noise_ratio = 0;
  double total_ratio = 0;      ///< rms of sigma / rms error
  double worst_ratio = 0;      ///< of the parameter with the widest intervals
  double effective_share = 0;  ///< independent points / points, mean
  std::vector<TrialNumber> numbers;
};

inline Candidate trial_start(const TrialScene& scene, Random& random) {
  Candidate c;
  c.object_name = "part";
  c.shape = scene.part.truth.objects.back().shape;
  c.parameters = scene.part.truth.parameters;
  for (auto& p : c.parameters) p.value *= 1 + 0.01 * random.normal();
  c.scan_from_part = scene.part.scan_from_part;
  c.scan_from_part.rotation =
      rotation_of({0.01 * random.normal(), 0.01 * random.normal(), 0.01 * random.normal()}) * c.scan_from_part.rotation;
  c.scan_from_part.translation += 0.2 * Vec3(random.normal(), random.normal(), random.normal());
  return c;
}

inline TrialSummary trials(const TrialScene& scene, Trouble trouble, int runs, const RefineOptions& options,
                           Context& context) {
  const auto& truth = scene.part.truth.parameters;
  const auto bound = cramer_rao(scene, trouble);
  std::vector<double> sum(truth.size(), 0), square(sum), noise(sum), total(sum), held(sum);
  TrialSummary s;
  s.runs = runs;
  for (int run = 0; run < runs; ++run) {
    const Scan scan = measured(scene, trouble, static_cast<std::uint64_t>(run) + 1);
    FitInput input;
    input.scan = &scan;
    input.cloud = scan.cloud;
    input.bounds = scan.cloud.bounds();
    input.sampling.sigma = trouble == Trouble::facets ? 0 : scene.options.sigma;
    input.sampling.spacing = input.thin_spacing = scene.pitch;
    if (scan.cloud.size() > 20000) {
      // As prepare() does with large scans: makers see a tenth of the points, the scan keeps them all.
      input.cloud = {};
      for (std::size_t i = 0; i < scan.cloud.size(); i += 10) input.cloud.points.push_back(scan.cloud.points[i]);
      input.thin_spacing = std::sqrt(10.0) * scene.pitch;
    }
    Random random(static_cast<std::uint64_t>(run) + 1000);
    Candidate c = trial_start(scene, random);
    s.effective_share += 1 / refine(c, input, options, context).points_per_independent / runs;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const auto& p = c.parameters[k];
      const double e = p.value - truth[k].value;
      sum[k] += e / runs, square[k] += e * e / runs, noise[k] += p.sigma_noise * p.sigma_noise / runs,
          total[k] += p.sigma * p.sigma / runs;
      s.noise_coverage += std::abs(e) <= 1.959964 * p.sigma_noise ? 1.0 / (runs * double(truth.size())) : 0;
      held[k] += std::abs(e) <= 1.959964 * p.sigma ? 1.0 / runs : 0;
    }
  }
  const double count = double(truth.size());
  double counted = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double efficiency = std::sqrt(square[k]) / bound[k], ratio = std::sqrt(total[k] / square[k]);
    s.efficiency += efficiency * efficiency / count;
    s.worst_efficiency = std::max(s.worst_efficiency, efficiency);
    if (efficiency > 0.1) {
      s.noise_ratio += noise[k] / square[k], s.total_ratio += total[k] / square[k], counted += 1;
      s.worst_ratio = std::max(s.worst_ratio, ratio);
    }
    s.total_coverage += held[k] / count;
    s.worst_coverage = std::min(s.worst_coverage, held[k]);
    s.numbers.push_back(
        {truth[k].name, sum[k], std::sqrt(square[k]), std::sqrt(noise[k]), std::sqrt(total[k]), held[k]});
  }
  s.efficiency = std::sqrt(s.efficiency), s.noise_ratio = std::sqrt(s.noise_ratio / std::max(counted, 1.0));
  s.total_ratio = std::sqrt(s.total_ratio / std::max(counted, 1.0));
  return s;
}

}  // namespace partscribe::testing
