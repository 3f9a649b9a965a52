#include "fit/evidence/face_ends.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "fit/refine/refine.h"
#include "geometry/points/kd_tree.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t neighbours = 10;

/// A plane face in the scan.
struct FacePlane {
  Vec3 normal, place;  // outward; the middle of what was seen
};

std::vector<FacePlane> planes_of(const Candidate& c) {
  const EvaluatedShape shape = evaluate(c.shape, values_of(c));
  std::vector<FacePlane> planes;
  const auto add = [&](const Vec3& normal, const Vec3& place) {
    planes.push_back({c.scan_from_part.rotation * normal, c.scan_from_part * place});
  };
  const auto add_along = [&](int axis, double high) {
    add(-Vec3::Unit(axis), Vec3::Zero());
    add(Vec3::Unit(axis), high * Vec3::Unit(axis));
  };
  if (const auto* box = std::get_if<BoxOf<double>>(&shape))
    add_along(0, box->size_x), add_along(1, box->size_y), add_along(2, box->size_z);
  if (const auto* plate = std::get_if<ExtrudeOf<double>>(&shape)) add_along(2, plate->height);
  if (const auto* wedge = std::get_if<WedgeOf<double>>(&shape)) {
    add_along(2, wedge->size_z), add_along(1, wedge->size_y);
    add(-Vec3::UnitX(), Vec3::Zero());
  }
  return planes;
}

/// A body of which it is asked whether a place lies inside.
struct Body {
  ModelDistance distance;
  Pose part_from_scan;
  explicit Body(const Candidate& c) : distance(bare_model(c)), part_from_scan(c.scan_from_part.inverse()) {}
  double operator()(const Vec3& p) const { return distance(part_from_scan * p).distance; }
};

/// What was seen of one plane face.
struct SeenFace {
  Mat3 frame;  // columns x, y, outward
  Vec3 origin;
  double depth = 0;          // mm below the face where bodies are asked
  std::vector<Vec3> points;  // z = 0
  Vec3 at(const Vec2& p) const { return origin + frame * Vec3(p.x(), p.y(), -depth); }
};

std::optional<SeenFace> seen_face(const FacePlane& plane, const FitInput& input) {
  constexpr double along = 0.9;
  const double thick = std::max(2.5 * input.sampling.sigma, input.tolerance);
  SeenFace face{rotation_onto_axis(plane.normal), plane.place, thick, {}};
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 q = face.frame.transpose() * (input.cloud.points[i] - plane.place);
    if (std::abs(q.z()) < thick && std::abs(input.cloud.normals[i].dot(plane.normal)) > along)
      face.points.emplace_back(q.x(), q.y(), 0);
  }
  if (face.points.size() < 4 * neighbours) return {};
  return face;
}

/// Nats for the places where the face of `ends` ends, one per stretch of `neighbours` points.
struct EndsSeen {
  double supported = 0, silent = 0, contradicted = 0;
};

/// Along the ends of `ends` inside of `other`, in one face.
EndsSeen ends_seen(const SeenFace& face, const Body& ends, const Body& other) {
  constexpr int cells = 40;
  constexpr double slack = 0.25, strip = 0.35, abreast = 0.8;  // times the reach of the neighbours
  Vec2 low = Vec2::Constant(1e300), high = -low;
  for (const Vec3& p : face.points) low = low.cwiseMin(p.head<2>()), high = high.cwiseMax(p.head<2>());
  const double cell = (high - low).maxCoeff() / cells;
  EndsSeen seen;
  if (!(cell > 0)) return seen;
  low -= Vec2::Constant(cell), high += Vec2::Constant(cell);
  const auto nx = static_cast<int>((high.x() - low.x()) / cell) + 1,
             ny = static_cast<int>((high.y() - low.y()) / cell) + 1;
  const auto middle = [&](int x, int y) { return Vec2(low + cell * Vec2(x, y)); };
  std::vector<double> inside(static_cast<std::size_t>(nx * ny));
  const auto at = [&](int x, int y) { return inside[static_cast<std::size_t>(y * nx + x)]; };
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x) inside[static_cast<std::size_t>(y * nx + x)] = ends(face.at(middle(x, y)));
  const KdTree tree(face.points);
  std::vector<Neighbour> near;
  std::vector<std::pair<Vec2, double>> asked;
  const auto ask = [&](Vec2 in, Vec2 out) {
    for (int k = 0; k < 20; ++k) {
      const Vec2 m = 0.5 * (in + out);
      (ends(face.at(m)) < 0 ? in : out) = m;
    }
    const Vec2 place = 0.5 * (in + out);
    const double h = 0.05 * cell;
    Vec2 outward(ends(face.at(place + Vec2(h, 0))) - ends(face.at(place - Vec2(h, 0))),
                 ends(face.at(place + Vec2(0, h))) - ends(face.at(place - Vec2(0, h))));
    if (!(outward.norm() > h)) return;  // it ends in depth
    outward.normalize();
    tree.nearest(Vec3(place.x(), place.y(), 0), neighbours, near);
    const double reach = std::sqrt(near.back().sq_distance);
    if (!(other(face.at(place + reach * outward)) < 0) || !(other(face.at(place)) < 0)) return;
    for (const auto& [known, radius] : asked)
      if ((known - place).norm() < std::max(radius, reach)) return;
    asked.emplace_back(place, reach);
    int beyond = 0, before = 0;
    for (const auto& n : near) {
      const Vec2 d = face.points[n.index].head<2>() - place;
      const double u = d.dot(outward), v = outward.x() * d.y() - outward.y() * d.x();
      beyond += u > slack * reach, before += u <= slack * reach && u > -strip * reach && std::abs(v) < abreast * reach;
    }
    (beyond > 1 ? seen.contradicted : before > 1 ? seen.supported : seen.silent) += 1;
  };
  for (int y = 0; y + 1 < ny; ++y)
    for (int x = 0; x + 1 < nx; ++x)
      for (const auto& [i, k] : {std::pair{x + 1, y}, std::pair{x, y + 1}})
        if ((at(x, y) < 0) != (at(i, k) < 0))
          at(x, y) < 0 ? ask(middle(x, y), middle(i, k)) : ask(middle(i, k), middle(x, y));
  return seen;
}

/// Nats; nothing for borders that were hardly seen.
double value_of(const std::vector<EndsSeen>& faces) {
  constexpr double per_place = 1.4,
                   per_shadow = 12;  // its outline goes on into one of four directions; it begins at some place
  constexpr double most_silent = 1, least = 4;  // times the places that support it; places
  EndsSeen all;
  double shadows = 0;
  for (const EndsSeen& f : faces) {
    all.supported += f.supported, all.silent += f.silent, all.contradicted += f.contradicted;
    if (f.supported >= least) shadows += 1;
  }
  const double against = -2 * per_place * all.contradicted;
  if (all.silent + all.contradicted > most_silent * all.supported) return against;
  return against + per_place * all.supported + per_shadow * shadows;
}

}  // namespace

double face_ends_told(const Candidate& a, const Candidate& b, const FitInput& input) {
  std::vector<FacePlane> planes = planes_of(a);
  const double near = std::max(2.5 * input.sampling.sigma, input.tolerance);
  for (const FacePlane& p : planes_of(b)) {
    const auto same = [&](const FacePlane& q) {
      return p.normal.dot(q.normal) > 0.99 && std::abs(q.normal.dot(p.place - q.place)) < near;
    };
    if (std::none_of(planes.begin(), planes.end(), same)) planes.push_back(p);
  }
  const Body body(a), other(b);
  std::vector<EndsSeen> of_a, of_b;
  for (const FacePlane& plane : planes)
    if (const auto face = seen_face(plane, input)) {
      of_a.push_back(ends_seen(*face, body, other));
      of_b.push_back(ends_seen(*face, other, body));
    }
  return value_of(of_a) - value_of(of_b);
}

}  // namespace partscribe::fit
