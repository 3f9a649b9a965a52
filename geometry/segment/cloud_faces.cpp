/// Faces of a cloud: grown on even samples, coarse ones first and finer ones where nothing is explained yet, then all
/// points are given to them.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "core/ensure.h"
#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/normals/orient_normals.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/spatial_order.h"
#include "geometry/points/thin.h"
#include "geometry/segment/faces.h"
#include "geometry/segment/grow_faces.h"
#include "geometry/segment/label_faces.h"
#include "geometry/segment/merge_faces.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t wanted_samples = 40000;
constexpr int most_passes = 3;
constexpr std::size_t least_points = 50;
constexpr double seed_cell = 3;          // pitches: one seed is tried in each cube of this edge
constexpr double assigned_distance = 4;  // sigmas
constexpr double assigned_turn = 1.0;    // rad; near edges normals are means of both sides
constexpr std::size_t jackknife_groups = 12, least_jackknife = 120, most_jackknife = 8000;
constexpr std::size_t least_inner = 60;  // points that a face is fitted to without those at its border
constexpr double tangent_angle = 0.1;    // rad between surfaces that meet smoothly

/// What is known of the cloud by all passes.
struct Work {
  const PointCloud& cloud;
  bool oriented = false;
  double least_sigma = 0;
  int threads = 1;
  std::vector<GrownFace> faces;           // members: samples of their own pass
  std::vector<Vec3> places;               // samples of all passes that a face explains
  std::vector<std::uint32_t> place_face;  // their faces
  double pitch = 0, area = 0;             // of the first pass
  std::vector<std::uint32_t> label;       // of each point of the cloud
  std::vector<std::uint8_t> inner;        // of each point: all samples around it belong to one face
};

/// Samples by how flat their surroundings are, one of each small cube.
std::vector<std::uint32_t> seeds_of(const FaceSamples& samples) {
  std::vector<double> bend(samples.size(), 0);
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const auto near = samples.around(i);
    for (const auto j : near) bend[i] += 1 - std::abs(samples.normals[i].dot(samples.normals[j]));
    bend[i] = near.empty() ? 1 : bend[i] / static_cast<double>(near.size());
  }
  const double edge = seed_cell * samples.pitch;
  std::map<std::array<long, 3>, std::uint32_t> best;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const Vec3 q = samples.points[i] / edge;
    const std::array<long, 3> cell = {std::lround(q.x()), std::lround(q.y()), std::lround(q.z())};
    const auto [at, fresh] = best.try_emplace(cell, i);
    if (!fresh && bend[i] < bend[at->second]) at->second = i;
  }
  std::vector<std::uint32_t> seeds;
  for (const auto& [cell, i] : best) seeds.push_back(i);
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) { return bend[a] < bend[b]; });
  return seeds;
}

/// One pass: faces of these samples are added.
void find_faces(const FaceSamples& samples, Work& work, Context& context) {
  std::vector<GrownFace> faces;
  std::vector<std::uint8_t> taken(samples.size(), 0);
  std::vector<std::uint8_t> tried(samples.size(), 0);  // about seeds that led to nothing
  const auto seeds = seeds_of(samples);
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    if (taken[seeds[s]] || tried[seeds[s]] || context.cancelled) continue;
    context.report("faces", 0.8 * static_cast<double>(s) / static_cast<double>(seeds.size()));
    auto face = grow_face(samples, seeds[s], taken, work.threads);
    if (!face) {
      tried[seeds[s]] = 1;
      for (const auto j : samples.around(seeds[s])) tried[j] = 1;
      continue;
    }
    for (const auto i : face->members) taken[i] = 1;
    faces.push_back(std::move(*face));
  }
  auto label = label_samples(samples, faces);
  for (int round = 0; round < 3 && merge_faces(samples, faces, label, work.threads); ++round)
    label = label_samples(samples, faces);
  const auto first = static_cast<std::uint32_t>(work.faces.size());
  for (std::uint32_t i = 0; i < samples.size(); ++i)
    if (label[i] != no_face) work.places.push_back(samples.points[i]), work.place_face.push_back(first + label[i]);
  work.faces.insert(work.faces.end(), std::make_move_iterator(faces.begin()), std::make_move_iterator(faces.end()));
}

/// Gives every usable point to the face near it that explains it best.
void assign_points(const std::vector<std::uint8_t>& usable, Work& work) {
  work.label.assign(work.cloud.size(), no_face);
  work.inner.assign(work.cloud.size(), 0);
  if (work.places.empty()) return;
  const KdTree tree(work.places);
  parallel_for(work.cloud.size(), work.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      if (!usable[i]) continue;
      const Vec3& p = work.cloud.points[i];
      const double sigma = std::max(work.least_sigma, static_cast<double>(work.cloud.sigma[i]));
      tree.nearest(p, 8, near);
      double best = 1e300;
      work.inner[i] = !near.empty() && std::all_of(near.begin(), near.end(), [&](const Neighbour& n) {
        return work.place_face[n.index] == work.place_face[near[0].index];
      });
      for (const auto& n : near) {
        if (n.sq_distance > 16 * work.pitch * work.pitch) break;
        const auto f = work.place_face[n.index];
        const GrownFace& face = work.faces[f];
        const double u = distance(face.surface, p) / sigma;
        double c = work.cloud.normals[i].dot(face.sense * surface_normal(face.surface, p));
        if (!work.oriented) c = std::abs(c);
        const double turn = std::acos(std::clamp(c, -1.0, 1.0));
        if (std::abs(u) > assigned_distance || turn > assigned_turn) continue;
        const double cost = label_cost(u, turn);
        if (cost < best) best = cost, work.label[i] = f;
      }
    }
  });
}

/// Gaps in the angles about the axis that are wider than the sampling leaves.
double covered_arc(std::vector<double> angles, double gap) {
  if (angles.empty()) return 0;
  std::sort(angles.begin(), angles.end());
  double open = 0;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double next = i + 1 < angles.size() ? angles[i + 1] : angles.front() + 2 * pi;
    if (next - angles[i] > gap) open += next - angles[i];
  }
  return std::max(0.0, 2 * pi - open);
}

void measure_along_axis(const Work& work, Face& face) {
  const Primitive& p = face.surface();
  const Mat3 frame = rotation_onto_axis(p.axis);
  std::vector<double> angles, along;
  for (const auto i : face.members) {
    const Vec3 q = frame.transpose() * (work.cloud.points[i] - p.point);
    angles.push_back(std::atan2(q.y(), q.x())), along.push_back(q.z());
  }
  const double reach = p.kind == PrimitiveKind::torus ? p.radius + p.tube : std::max(p.radius, work.pitch);
  face.arc = covered_arc(std::move(angles), std::clamp(3 * work.pitch / reach, 0.02, 1.5));
  place_half_way(face, quantile(along, 0.002), quantile(along, 0.998));
}

FaceKind face_kind(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::plane:
      return FaceKind::plane;
    case PrimitiveKind::cylinder:
      return FaceKind::cylinder;
    case PrimitiveKind::cone:
      return FaceKind::cone;
    case PrimitiveKind::sphere:
      return FaceKind::sphere;
    default:
      return FaceKind::torus;
  }
}

/// Widens the sigmas of a fit to what it turns out to be when neighbouring points are left out together, a twelfth at a
/// time (delete-a-group jackknife): points side by side err alike, by more than their noise says.
void widen_sigmas(const std::vector<Vec3>& points, const std::vector<double>& sigmas, const Vec3& middle,
                  PrimitiveFit& fit) {
  if (points.size() < least_jackknife) return;
  const auto order = spatial_order(points, 1);
  const Primitive& all = fit.primitive;
  double radius = 0, tube = 0, half_angle = 0, place = 0, axis = 0;
  for (std::size_t group = 0; group < jackknife_groups; ++group) {
    const std::size_t begin = group * order.size() / jackknife_groups,
                      end = (group + 1) * order.size() / jackknife_groups;
    const std::size_t step = (order.size() - (end - begin)) / most_jackknife + 1;
    std::vector<Vec3> kept;
    std::vector<double> kept_sigmas;
    for (std::size_t k = 0; k < order.size(); k += step)
      if (k < begin || k >= end) kept.push_back(points[order[k]]), kept_sigmas.push_back(sigmas[order[k]]);
    PrimitiveFitOptions options;
    options.sigmas = &kept_sigmas, options.robust = 2.5, options.start = all;
    const auto other = fit_primitive(all.kind, kept, {}, options);
    if (!other) continue;
    const Primitive& p = other->primitive;
    const Vec3 away = p.point - all.point;
    const double along = away.dot(all.axis);
    const double sense = p.axis.dot(all.axis) < 0 ? -1 : 1;
    // Where both state the same thing: beside the middle of the points.
    const double t = (middle - p.point).dot(p.axis), u = (middle - all.point).dot(all.axis);
    const Vec3 there = p.point + t * p.axis, here = all.point + u * all.axis;
    switch (all.kind) {
      case PrimitiveKind::plane:
        place += std::pow(distance(p, middle) * sense - distance(all, middle), 2);
        break;
      case PrimitiveKind::cylinder:
      case PrimitiveKind::cone:
        place += (there - here - (there - here).dot(all.axis) * all.axis).squaredNorm();
        break;
      default:
        place += away.squaredNorm();
    }
    radius += std::pow(all.kind == PrimitiveKind::cone ? p.radius - along * std::tan(p.half_angle) - all.radius
                                                       : p.radius - all.radius,
                       2);
    tube += std::pow(p.tube - all.tube, 2), half_angle += std::pow(p.half_angle - all.half_angle, 2);
    axis += std::pow(std::atan2(p.axis.cross(all.axis).norm(), std::abs(p.axis.dot(all.axis))), 2);
  }
  const double factor = double(jackknife_groups - 1) / double(jackknife_groups);
  fit.sigma_radius = std::max(fit.sigma_radius, std::sqrt(factor * radius));
  fit.sigma_tube = std::max(fit.sigma_tube, std::sqrt(factor * tube));
  fit.sigma_half_angle = std::max(fit.sigma_half_angle, std::sqrt(factor * half_angle));
  fit.sigma_point = std::max(fit.sigma_point, std::sqrt(factor * place));
  if (all.kind != PrimitiveKind::sphere) fit.sigma_axis = std::max(fit.sigma_axis, std::sqrt(factor * axis));
}

/// Fitted to all its points.
Face described(const Work& work, const GrownFace& grown, std::vector<std::uint32_t> members) {
  Face face;
  face.members = std::move(members);
  std::vector<Vec3> points, normals;
  std::vector<double> sigmas;
  // Beside another face some points are taken for this one that are not: they would pull at it.
  const auto inner = static_cast<std::size_t>(
      std::count_if(face.members.begin(), face.members.end(), [&](std::uint32_t i) { return work.inner[i] != 0; }));
  const bool inner_only = inner >= least_inner && 5 * inner >= 2 * face.members.size();
  for (const auto i : face.members) {
    face.middle += work.cloud.points[i];
    if (inner_only && !work.inner[i]) continue;
    points.push_back(work.cloud.points[i]), normals.push_back(work.cloud.normals[i]);
    sigmas.push_back(std::max(work.least_sigma, static_cast<double>(work.cloud.sigma[i])));
  }
  face.middle /= static_cast<double>(face.members.size());
  for (const auto i : face.members) {
    const Vec3 d = work.cloud.points[i] - face.middle;
    face.spread += d * d.transpose() / static_cast<double>(face.members.size());
  }
  face.points = points.size();
  PrimitiveFitOptions options;
  options.sigmas = &sigmas, options.robust = 2.5, options.start = grown.surface;
  const auto fit = fit_primitive(grown.surface.kind, points, normals, options);
  if (fit)
    face.fit = *fit, widen_sigmas(points, sigmas, face.middle, face.fit);
  else
    face.fit.primitive = grown.surface, face.fit.determined = false;
  face.kind = face_kind(grown.surface.kind);
  double sense = 0;
  for (std::size_t i = 0; i < points.size(); ++i) sense += normals[i].dot(surface_normal(face.surface(), points[i]));
  Primitive& p = face.fit.primitive;
  if (p.kind == PrimitiveKind::plane) {
    if (sense < 0) p.axis = -p.axis;
    p.point = face.middle - distance(p, face.middle) * p.axis;
    return face;
  }
  face.hollow = sense < 0;
  if (p.kind == PrimitiveKind::sphere) return face;
  Eigen::Index along;
  p.axis.cwiseAbs().maxCoeff(&along);
  if (p.kind != PrimitiveKind::cone && p.axis[along] < 0) p.axis = -p.axis;
  measure_along_axis(work, face);
  return face;
}

double share_of_turn(const Face& face) {
  const Primitive& p = face.surface();
  switch (face.kind) {
    case FaceKind::sphere:
      return std::min(1.0, face.area / (4 * pi * p.radius * p.radius));
    case FaceKind::cylinder:
      return std::min(1.0, face.area / (2 * pi * p.radius * std::max(face.high - face.low, 1e-9)));
    case FaceKind::cone:
      return std::min(1.0, face.area * std::cos(p.half_angle) /
                               (2 * pi * std::max(p.radius, 1e-9) * std::max(face.high - face.low, 1e-9)));
    case FaceKind::torus:
      return face.arc / (2 * pi);
    default:
      return 1;
  }
}

/// Faces that samples side by side belong to.
struct Border {
  double links = 0, below = 0, turned = 0;
};

void find_neighbours(const FaceSamples& samples, const std::vector<std::uint32_t>& label, Faces& faces) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Border> borders;
  for (std::uint32_t i = 0; i < samples.size(); ++i)
    for (const auto j : samples.around(i)) {
      const auto f = label[i], g = label[j];
      if (f == no_face || g == no_face || f == g) continue;
      const Vec3 d = samples.points[j] - samples.points[i];
      const Vec3 place = samples.points[i] + 0.5 * d;
      const Face &a = faces.faces[f], &b = faces.faces[g];
      const Vec3 n = (a.hollow ? -1 : 1) * surface_normal(a.surface(), place);
      const Vec3 m = (b.hollow ? -1 : 1) * surface_normal(b.surface(), place);
      Border& border = borders[{std::min(f, g), std::max(f, g)}];
      border.links += 1, border.turned += std::atan2(n.cross(m).norm(), n.dot(m));
      border.below += d.dot(n) < 0 ? 1 : -1;
    }
  for (const auto& [pair, border] : borders) {
    if (border.links < 4) continue;
    const double angle = border.turned / border.links;
    const EdgeKind edge = angle < tangent_angle ? EdgeKind::tangent
                          : border.below > 0    ? EdgeKind::convex
                                                : EdgeKind::concave;
    // Each sample at the border has about three links across it, from either side.
    const double length = border.links / 6 * samples.pitch;
    faces.faces[pair.first].neighbours.push_back({pair.second, edge, angle, length});
    faces.faces[pair.second].neighbours.push_back({pair.first, edge, angle, length});
  }
}

}  // namespace

/// Turns normals outward where no rays tell the side: those of even samples as orient_normals does, all others as the
/// samples beside them.
void turn_outward(const std::vector<std::uint8_t>& usable, PointCloud& cloud, Context& context) {
  std::vector<std::uint8_t> left_out(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) left_out[i] = !usable[i];
  PointCloud samples;
  for (const auto i : thinned(cloud.points, left_out, spacing_for_count(cloud.points, left_out, wanted_samples)))
    samples.points.push_back(cloud.points[i]), samples.normals.push_back(cloud.normals[i]);
  samples.sigma.assign(samples.size(), 0), samples.rejected.assign(samples.size(), 0);
  orient_normals(samples, 12, context);
  const KdTree tree(samples.points);
  parallel_for(cloud.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      if (!usable[i]) continue;
      tree.nearest(cloud.points[i], 4, near);
      double most = 0;
      for (const auto& n : near) {
        const double c = cloud.normals[i].dot(samples.normals[n.index]);
        if (std::abs(c) > std::abs(most)) most = c;
      }
      if (most < 0) cloud.normals[i] = -cloud.normals[i];
    }
  });
}

Faces faces_of_cloud(const PointCloud& given, const FaceOptions& options, Context& context) {
  Faces result;
  result.face_of.assign(given.size(), no_face);
  std::vector<std::uint8_t> usable(given.size(), 0);
  std::vector<double> sigmas;
  ensure(given.normals.size() == given.size() && given.sigma.size() == given.size(), "a cloud with normals and noise");
  for (std::size_t i = 0; i < given.size(); ++i) {
    usable[i] = !(given.rejected.size() == given.size() && given.rejected[i]) && !given.normals[i].isZero() &&
                given.points[i].allFinite();
    if (usable[i]) sigmas.push_back(given.sigma[i]);
  }
  PointCloud turned;
  const bool rays = given.rays.size() == given.size();
  if (!rays) {
    turned = given;
    turn_outward(usable, turned, context);
  }
  const PointCloud& cloud = rays ? given : turned;
  if (sigmas.size() < least_points) return result;
  result.noise = median_in_place(sigmas);
  const double size = cloud.bounds().diagonal();
  Work work{cloud,
            true,
            std::max({1e-6 * size, 0.02 * options.tolerance, 0.5 * result.noise}),
            context.threads,
            {},
            {},
            {},
            0,
            0,
            {}};
  work.label.assign(cloud.size(), no_face);
  std::vector<std::uint8_t> open = usable;
  FaceSamples first;
  for (int pass = 0; pass < most_passes; ++pass) {
    const FaceSamples samples = face_samples(cloud, open, true, work.least_sigma, wanted_samples, context.threads);
    if (pass == 0) work.pitch = samples.pitch, work.area = samples.area, first = samples;
    if (samples.size() < 100) break;
    find_faces(samples, work, context);
    assign_points(usable, work);
    std::size_t left = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) left += open[i] = usable[i] && work.label[i] == no_face;
    if (left == 0 || samples.source.size() * 10 > 9 * static_cast<std::size_t>(sigmas.size()) || left < 100) break;
  }
  if (context.cancelled) return result;
  std::vector<std::vector<std::uint32_t>> members(work.faces.size());
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (work.label[i] != no_face) members[work.label[i]].push_back(i);
  std::vector<double> samples_of(work.faces.size(), 0);
  for (const auto i : first.source)
    if (work.label[i] != no_face) samples_of[work.label[i]] += 1;
  std::vector<Face> faces;
  for (std::uint32_t f = 0; f < work.faces.size(); ++f) {
    if (members[f].size() < 12) continue;
    faces.push_back(described(work, work.faces[f], std::move(members[f])));
    faces.back().area = work.area * std::max(1.0, samples_of[f]);
    faces.back().coverage = share_of_turn(faces.back());
  }
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.area != b.area ? a.area > b.area : a.points > b.points;
  });
  result.faces = std::move(faces);
  for (std::uint32_t f = 0; f < result.faces.size(); ++f)
    for (const auto i : result.faces[f].members) result.face_of[i] = f;
  std::vector<std::uint32_t> label;
  for (const auto i : first.source) label.push_back(result.face_of[i]);
  find_neighbours(first, label, result);
  context.report("faces", 1);
  return result;
}

Faces faces_of(const Scan& scan, const FaceOptions& options, Context& context) {
  if (!scan.mesh.empty()) {
    Faces faces = faces_of_mesh(scan.mesh, options, context);
    double known = 0, all = 0;
    for (const auto& face : faces.faces) {
      all += face.area;
      if (face.kind != FaceKind::free_form) known += face.area;
    }
    if (known > 0.5 * all) return faces;
  }
  return faces_of_cloud(scan.cloud, options, context);
}

}  // namespace partscribe::geometry
