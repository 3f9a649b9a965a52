#include "model/distance/tree.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace partscribe::model {
namespace {

double distance_to(const Box3& box, const Vec3& p) { return (box.low - p).cwiseMax(p - box.high).cwiseMax(0.0).norm(); }

}  // namespace

/// What is inside where some leaves are taken as holding the place or not.
struct ModelDistance::Tree::Probe {
  const Vec3& place;
  std::array<int, 3> leaves{-1, -1, -1};  // those taken
  unsigned inside = 0;                    // bit i: leaves[i] holds the place
  bool ambiguous = false;                 // another leaf's surface passes through the place
};

bool ModelDistance::Tree::holds(const Node& node, Probe& probe) const {
  if (distance_to(node.bounds, probe.place) > small) return false;
  switch (node.operation) {
    case Node::Operation::leaf: {
      for (std::size_t i = 0; i < probe.leaves.size(); ++i)
        if (probe.leaves[i] == node.leaf) return (probe.inside >> i) & 1;
      const Leaf& leaf = leaves[static_cast<std::size_t>(node.leaf)];
      const double d = leaf.solid->hit(leaf.leaf_from_part * probe.place).distance;
      probe.ambiguous = probe.ambiguous || std::abs(d) <= small;
      return d < 0;
    }
    case Node::Operation::join:
      return std::any_of(node.operands.begin(), node.operands.end(), [&](const Node& n) { return holds(n, probe); });
    case Node::Operation::common:
      return std::all_of(node.operands.begin(), node.operands.end(), [&](const Node& n) { return holds(n, probe); });
    case Node::Operation::cut:
      return holds(node.operands[0], probe) && std::none_of(node.operands.begin() + 1, node.operands.end(),
                                                            [&](const Node& n) { return holds(n, probe); });
  }
  return false;
}

bool ModelDistance::Tree::inside(const Vec3& p) const {
  Probe probe{p};
  return holds(root, probe);
}

/// A place on the surfaces of all these faces is surface of the whole if what is inside hangs on one of their solids.
bool ModelDistance::Tree::on_surface(const Vec3& q, const Vec3& normal, const Face* faces, int count) const {
  Probe probe{q};
  int taken = 0;
  for (int i = 0; i < count; ++i)
    if (std::find(probe.leaves.begin(), probe.leaves.begin() + taken, faces[i].leaf) == probe.leaves.begin() + taken)
      probe.leaves[static_cast<std::size_t>(taken++)] = faces[i].leaf;
  const bool with_none = holds(root, probe);
  bool differs = false;
  for (probe.inside = 1; probe.inside < (1u << taken) && !differs; ++probe.inside)
    differs = holds(root, probe) != with_none;
  if (!probe.ambiguous) return differs;
  // Others touch here: is there material on one side of the place and none on the other, or around it?
  const bool one_side = inside(q + small * normal);
  if (inside(q - small * normal) != one_side) return true;
  constexpr int directions = 48;
  for (int k = 0; k < directions; ++k) {
    const double z = (2 * k + 1.0) / directions - 1, turn = 2.39996322972865332 * (k + 0.37), r = std::sqrt(1 - z * z);
    if (inside(q + 2 * small * Vec3(r * std::cos(turn), r * std::sin(turn), z)) != one_side) return true;
  }
  return false;
}

/// Signed, and no larger than the distance: the largest or least of the operands', and whose face it is.
ModelDistance::Tree::Bound ModelDistance::Tree::bound(const Node& node, const Vec3& p) const {
  if (node.operation == Node::Operation::leaf) {
    const Leaf& leaf = leaves[static_cast<std::size_t>(node.leaf)];
    const LocalHit h = leaf.solid->hit(leaf.leaf_from_part * p);
    return {h.distance, {node.leaf, h.face}};
  }
  Bound best = bound(node.operands[0], p);
  for (std::size_t i = 1; i < node.operands.size(); ++i) {
    // Operands whose box is farther than what is known change nothing.
    const double box = distance_to(node.operands[i].bounds, p);
    if (node.operation == Node::Operation::join && box > 0 && box >= best.distance) continue;
    if (node.operation == Node::Operation::cut && box > 0 && -box <= best.distance) continue;
    Bound other = bound(node.operands[i], p);
    if (node.operation == Node::Operation::cut) other.distance = -other.distance;
    if (node.operation == Node::Operation::join ? other.distance < best.distance : other.distance > best.distance)
      best = other;
  }
  return best;
}

Foot ModelDistance::Tree::foot(const Face& face, const Vec3& p) const {
  const Leaf& leaf = leaves[static_cast<std::size_t>(face.leaf)];
  Foot f = leaf.solid->foot(leaf.leaf_from_part * p, face.face);
  f.point = leaf.part_from_leaf * f.point;
  f.normal = leaf.part_from_leaf.rotation * f.normal;
  return f;
}

/// A point that two or three faces have in common, nearest to p as far as small steps from `start` tell.
std::optional<Vec3> ModelDistance::Tree::meeting_point(const Face* faces, int count, const Vec3& p,
                                                       const Vec3& start) const {
  const double close = 1e-3 * small;
  std::array<Vec3, 3> towards;
  // Newton's method for being on all faces at once: the shortest step onto their tangent planes.
  auto project = [&](Vec3& x) {
    for (int round = 0; round < 30; ++round) {
      Mat3 normals = Mat3::Zero();
      Vec3 gaps = Vec3::Zero();
      double worst = 0;
      for (int i = 0; i < count; ++i) {
        const Foot f = foot(faces[i], x);
        const Vec3 gap = f.point - x;
        towards[static_cast<std::size_t>(i)] = f.distance > close ? Vec3(gap / f.distance) : f.normal;
        normals.row(i) = towards[static_cast<std::size_t>(i)];
        gaps[i] = f.distance > close ? f.distance : 0;
        worst = std::max(worst, f.distance);
      }
      if (worst <= close) return true;
      if (count == 2) {
        const double c = normals.row(0).dot(normals.row(1)), determinant = 1 - c * c;
        if (determinant < 1e-6) return false;
        const double a = (gaps[0] - c * gaps[1]) / determinant, b = (gaps[1] - c * gaps[0]) / determinant;
        x += a * normals.row(0).transpose() + b * normals.row(1).transpose();
      } else {
        if (std::abs(normals.determinant()) < 1e-4) return false;
        x += normals.inverse() * gaps;
      }
    }
    return false;
  };
  Vec3 x = start;
  if (!project(x)) return {};
  if (count == 3) return x;
  if (towards[0].cross(towards[1]).norm() < 1e-3) return {};  // they touch there and do not cross
  // Along the curve towards p, by shorter and shorter steps.
  double share = 1;
  for (int round = 0; round < 40 && share > 1e-2; ++round) {
    const Vec3 along = towards[0].cross(towards[1]);
    const Vec3 step = along * along.dot(p - x) / along.squaredNorm();
    if (share * step.norm() < small) break;
    Vec3 next = x + share * step;
    const auto before = towards;
    if (project(next) && (next - p).squaredNorm() < (x - p).squaredNorm()) {
      x = next;
    } else {
      share *= 0.5, towards = before;
    }
  }
  return x;
}

ModelHit ModelDistance::Tree::nearest(const Vec3& p) const {
  if (root.operation == Node::Operation::leaf) {
    const LocalHit h = leaves[0].solid->hit(leaves[0].leaf_from_part * p);
    return {h.distance, leaves[0].first_face + h.face};
  }
  // Where the bound is reached by a visible face, nothing is nearer: so it is in most places.
  const Bound at_least = bound(root, p);
  const Foot first = foot(at_least.face, p);
  if (first.distance <= std::abs(at_least.distance) + 1e-9 && on_surface(first.point, first.normal, &at_least.face, 1))
    return {at_least.distance, face_id(at_least.face)};

  // Leaves in order of how near they can be.
  std::vector<std::pair<double, int>> order;
  for (std::size_t i = 0; i < leaves.size(); ++i)
    order.emplace_back(distance_to(leaves[i].bounds, p), static_cast<int>(i));
  std::sort(order.begin(), order.end());

  struct Near {
    Face face;
    Foot foot;
  };
  double best = 1e300;
  int best_face = 0;
  std::vector<Near> met, hidden;  // faces as near as the best; those whose foot is no part of the surface
  for (const auto& [box_distance, index] : order) {
    if (box_distance >= best) break;
    const auto& leaf = leaves[static_cast<std::size_t>(index)];
    for (std::size_t k = 0; k < leaf.solid->faces.size(); ++k) {
      const Face face{index, static_cast<int>(k)};
      const Foot f = foot(face, p);
      if (f.distance >= best) continue;
      met.push_back({face, f});
      if (on_surface(f.point, f.normal, &face, 1)) {
        best = f.distance, best_face = face_id(face);
      } else {
        hidden.push_back({face, f});
      }
    }
  }
  // Where a face is hidden, its visible part ends in a curve or a corner that it has in common with others.
  std::sort(hidden.begin(), hidden.end(),
            [](const Near& a, const Near& b) { return a.foot.distance < b.foot.distance; });
  auto take = [&](const Vec3& x, const Face* faces, int count) {
    const double d = (x - p).norm();
    if (d >= best || !on_surface(x, hidden[0].foot.normal, faces, count)) return false;
    best = d, best_face = face_id(faces[0]);
    return true;
  };
  for (const Near& a : hidden) {
    if (a.foot.distance >= best) break;
    for (const Near& b : met) {
      if (b.foot.distance >= best || b.face.leaf == a.face.leaf) continue;
      std::array<Face, 3> faces{a.face, b.face, b.face};
      for (const Vec3& start : {p, a.foot.point, b.foot.point}) {
        const auto curve = meeting_point(faces.data(), 2, p, start);
        if (!curve) continue;
        if ((*curve - p).norm() >= best) continue;
        if (take(*curve, faces.data(), 2)) break;
        for (const Near& c : met) {
          const bool same = (c.face.leaf == a.face.leaf && c.face.face == a.face.face) ||
                            (c.face.leaf == b.face.leaf && c.face.face == b.face.face);
          if (same || c.foot.distance >= best) continue;
          faces[2] = c.face;
          if (const auto corner = meeting_point(faces.data(), 3, p, *curve)) take(*corner, faces.data(), 3);
        }
      }
    }
  }
  // On a face that is hidden, both of its sides are alike, and the place itself may be rounded to either.
  const bool on_hidden = !hidden.empty() && hidden[0].foot.distance <= small;
  const bool in = inside(on_hidden ? Vec3(p + small * hidden[0].foot.normal) : p);
  if (best > 1e299) best = std::abs(at_least.distance);  // nothing is left of the body, or only less than `small`
  return {in ? -best : best, best_face};
}

}  // namespace partscribe::model
