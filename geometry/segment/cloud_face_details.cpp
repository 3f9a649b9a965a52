#include "geometry/segment/cloud_face_details.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/number.h"
#include "core/statistics.h"
#include "geometry/points/spatial_order.h"
#include "geometry/segment/grow_faces.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t jackknife_groups = 12, least_jackknife = 120, most_jackknife = 8000;
constexpr std::size_t least_inner = 60;  // points that a face is fitted to without those at its border
constexpr double tangent_angle = 0.1;    // rad between surfaces that meet smoothly
constexpr double widest_gap = 1.75;      // rad between neighbours of a sample; wider ones are the end of the face
constexpr double border_width = 1.6;     // pitches on either side of a border in which samples have links across it

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
    const auto other = robust_fit(all.kind, kept, {}, kept_sigmas, all);
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

void measure_along_axis(const LabelledCloud& labelled, Face& face) {
  const Primitive& p = face.surface();
  const Mat3 frame = rotation_onto_axis(p.axis);
  std::vector<double> angles, along;
  for (const auto i : face.members) {
    const Vec3 q = frame.transpose() * (labelled.cloud.points[i] - p.point);
    angles.push_back(std::atan2(q.y(), q.x())), along.push_back(q.z());
  }
  const double reach = p.kind == PrimitiveKind::torus ? p.radius + p.tube : std::max(p.radius, labelled.pitch);
  face.arc = covered_arc(std::move(angles), std::clamp(3 * labelled.pitch / reach, 0.02, 1.5));
  place_half_way(face, quantile(along, 0.002), quantile(along, 0.998));
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

/// The share of a full turn about sample `i` in which there are samples of its face; `near`: these.
double surrounded(const FaceSamples& samples, std::uint32_t i, const std::vector<std::uint32_t>& near) {
  const Mat3 frame = rotation_onto_axis(samples.normals[i]);
  std::vector<double> angles;
  for (const auto j : near) {
    const Vec3 q = frame.transpose() * (samples.points[j] - samples.points[i]);
    angles.push_back(std::atan2(q.y(), q.x()));
  }
  return covered_arc(std::move(angles), widest_gap) / (2 * pi);
}

/// Faces that samples side by side belong to.
struct Border {
  std::size_t links = 0, samples = 0;  // samples: on either side, with links across
  double below = 0, turned = 0;
};

}  // namespace

Face described(const LabelledCloud& labelled, const Primitive& start, std::vector<std::uint32_t> members) {
  Face face;
  face.members = std::move(members);
  std::vector<Vec3> points, normals;
  std::vector<double> sigmas;
  // Beside another face some points are taken for this one that are not: they would pull at it.
  const auto inner = static_cast<std::size_t>(
      std::count_if(face.members.begin(), face.members.end(), [&](std::uint32_t i) { return labelled.inner[i] != 0; }));
  const bool inner_only = inner >= least_inner && 5 * inner >= 2 * face.members.size();
  for (const auto i : face.members) {
    face.middle += labelled.cloud.points[i];
    if (inner_only && !labelled.inner[i]) continue;
    points.push_back(labelled.cloud.points[i]), normals.push_back(labelled.cloud.normals[i]);
    sigmas.push_back(std::max(labelled.least_sigma, static_cast<double>(labelled.cloud.sigma[i])));
  }
  face.middle /= static_cast<double>(face.members.size());
  for (const auto i : face.members) {
    const Vec3 d = labelled.cloud.points[i] - face.middle;
    face.spread += d * d.transpose() / static_cast<double>(face.members.size());
  }
  face.points = points.size();
  const auto fit = robust_fit(start.kind, points, normals, sigmas, start);
  if (fit)
    face.fit = *fit, widen_sigmas(points, sigmas, face.middle, face.fit);
  else
    face.fit.primitive = start, face.fit.determined = false;
  face.kind = face_kind(start.kind);
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
  measure_along_axis(labelled, face);
  return face;
}

void measure_areas(const FaceSamples& samples, const std::vector<std::uint32_t>& label, std::vector<Face>& faces) {
  std::vector<double> count(faces.size(), 0);
  std::vector<std::uint32_t> near;
  double total = 0, points = 0;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    if (label[i] == no_face) continue;
    near.clear();
    for (const auto j : samples.around(i))
      if (label[j] == label[i]) near.push_back(j);
    if (near.size() < 3) continue;
    const double reach = (samples.points[near.back()] - samples.points[i]).squaredNorm();
    const double share = surrounded(samples, i, near);
    faces[label[i]].area += pi * reach * share / (static_cast<double>(near.size()) - 0.5 + share);
    count[label[i]] += 1;
  }
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (count[f] > 0) total += faces[f].area, points += static_cast<double>(faces[f].members.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    // Found among finer samples only: as many points per area as elsewhere.
    if (count[f] < 12 && points > 0) faces[f].area = total / points * static_cast<double>(faces[f].members.size());
    faces[f].coverage = share_of_turn(faces[f]);
  }
}

void find_neighbours(const FaceSamples& samples, const std::vector<std::uint32_t>& label, Faces& faces) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Border> borders;
  std::vector<std::uint32_t> met;  // faces that one sample has links to
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    met.clear();
    for (const auto j : samples.around(i)) {
      const auto f = label[i], g = label[j];
      if (f == no_face || g == no_face || f == g) continue;
      const Vec3 d = samples.points[j] - samples.points[i];
      const Vec3 place = samples.points[i] + 0.5 * d;
      const Face &a = faces.faces[f], &b = faces.faces[g];
      const Vec3 n = outward_normal(a, place), m = outward_normal(b, place);
      Border& border = borders[{std::min(f, g), std::max(f, g)}];
      if (std::find(met.begin(), met.end(), g) == met.end()) met.push_back(g), ++border.samples;
      ++border.links, border.turned += std::atan2(n.cross(m).norm(), n.dot(m));
      border.below += d.dot(n) < 0 ? 1 : -1;
    }
  }
  for (const auto& [pair, border] : borders) {
    if (border.links < 4) continue;
    const double angle = border.turned / static_cast<double>(border.links);
    const EdgeKind edge = angle < tangent_angle ? EdgeKind::tangent
                          : border.below > 0    ? EdgeKind::convex
                                                : EdgeKind::concave;
    const double length = static_cast<double>(border.samples) / (2 * border_width) * std::sqrt(samples.area);
    faces.faces[pair.first].neighbours.push_back({pair.second, edge, angle, length});
    faces.faces[pair.second].neighbours.push_back({pair.first, edge, angle, length});
  }
}

}  // namespace partscribe::geometry
