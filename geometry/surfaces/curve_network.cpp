#include "geometry/surfaces/curve_network.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/ensure.h"
#include "core/number.h"

namespace partscribe::geometry {
namespace {

using NodePair = std::pair<std::uint32_t, std::uint32_t>;  // the smaller first
NodePair pair_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

std::map<NodePair, std::size_t> curves_by_nodes(const CurveNetwork& network) {
  std::map<NodePair, std::size_t> curves;
  for (std::size_t c = 0; c < network.curves.size(); ++c)
    curves.emplace(pair_of(network.curves[c].from, network.curves[c].to), c);
  return curves;
}

/// The four control points of a curve, from one of its nodes on.
using CubicPoints = std::array<Vec3, 4>;

CubicPoints control_points(const CurveNetwork& network, const NetworkCurve& curve, std::uint32_t from) {
  const CubicPoints p = {network.nodes[curve.from], curve.first, curve.second, network.nodes[curve.to]};
  return from == curve.from ? p : CubicPoints{p[3], p[2], p[1], p[0]};
}

/// What all patches beside a curve have in common: D at its ends.
struct CrossField {
  Vec3 first, last;
};

CrossField cross_field(const CurveNetwork& network, const NetworkCurve& curve) {
  const Vec3 out = curve.first - network.nodes[curve.from], in = network.nodes[curve.to] - curve.second;
  return {network.normals[curve.from].cross(out).normalized(), network.normals[curve.to].cross(in).normalized()};
}

/// Tangents across a curve as a cubic in Bernstein's form, of which the ends are given: k D + h C'.
std::array<Vec3, 4> tangents_across(const CubicPoints& curve, const CrossField& field, const Vec3& first,
                                    const Vec3& last) {
  const Vec3 c0 = 3 * (curve[1] - curve[0]), c1 = 3 * (curve[2] - curve[1]), c2 = 3 * (curve[3] - curve[2]);
  const double k0 = first.dot(field.first), k1 = last.dot(field.last);
  const double h0 = first.dot(c0) / c0.squaredNorm(), h1 = last.dot(c2) / c2.squaredNorm();
  const Vec3 d0 = k0 * field.first, d1 = 0.5 * (k0 * field.last + k1 * field.first), d2 = k1 * field.last;
  return {d0 + h0 * c0, (d0 + 2 * d1 + h1 * c0 + 2 * h0 * c1) / 3, (2 * d1 + d2 + 2 * h1 * c1 + h0 * c2) / 3,
          d2 + h1 * c2};
}

std::optional<Error> complaint_about_curves(const CurveNetwork& network) {
  constexpr double most_angle = 1e-6;
  for (const NetworkCurve& curve : network.curves) {
    const std::string name =
        "the curve between nodes " + std::to_string(curve.from) + " and " + std::to_string(curve.to);
    const double size = (network.nodes[curve.to] - network.nodes[curve.from]).norm();
    for (const bool at_end : {false, true}) {
      const std::uint32_t node = at_end ? curve.to : curve.from;
      const Vec3 tangent = (at_end ? curve.second : curve.first) - network.nodes[node];
      if (!(tangent.norm() > 1e-9 * size)) return bad_input(name + " has no direction at node " + std::to_string(node));
      const double angle = std::abs(std::asin(std::clamp(network.normals[node].dot(tangent.normalized()), -1.0, 1.0)));
      if (!(angle <= most_angle))
        return bad_input("expected curves in the tangent planes of their nodes, " + name + " leaves that of node " +
                         std::to_string(node) + " by " + print_number(std::round(1e6 * angle) / 1e6) + " rad");
    }
  }
  return std::nullopt;
}

}  // namespace

CurveNetwork network_through(const std::vector<Vec3>& nodes, const std::vector<Vec3>& normals,
                             const std::vector<std::array<std::uint32_t, 4>>& faces) {
  ensure(normals.size() == nodes.size(), "a normal for each node");
  CurveNetwork network{nodes, normals, {}, faces};
  std::map<NodePair, bool> known;
  // An arc of a circle whose chord makes the angle phi with its tangents has inner control points at this distance.
  const auto inner = [&](std::uint32_t node, std::uint32_t other) {
    const Vec3 chord = nodes[other] - nodes[node];
    const Vec3 tangent = (chord - normals[node].dot(chord) * normals[node]).normalized();
    const double length = chord.norm(), cosine = tangent.dot(chord) / length;
    return Vec3(nodes[node] + 2.0 / 3 * length / (1 + cosine) * tangent);
  };
  for (const auto& face : faces)
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t a = face[k], b = face[(k + 1) % 4];
      ensure(a != b, "the nodes of a face differ");
      if (known.emplace(pair_of(a, b), true).second) network.curves.push_back({a, b, inner(a, b), inner(b, a)});
    }
  return network;
}

Result<std::vector<GregoryPatch>> gregory_patches(const CurveNetwork& network) {
  if (const auto complaint = complaint_about_curves(network)) return *complaint;
  const auto curves = curves_by_nodes(network);
  std::vector<GregoryPatch> result;
  for (const auto& face : network.faces) {
    // Sides in the directions of the parameters: v = 0, u = 1, v = 1, u = 0.
    const std::array<std::pair<std::uint32_t, std::uint32_t>, 4> sides = {
        {{face[0], face[1]}, {face[1], face[2]}, {face[3], face[2]}, {face[0], face[3]}}};
    std::array<const NetworkCurve*, 4> along{};
    std::array<CubicPoints, 4> p;
    for (std::size_t s = 0; s < 4; ++s) {
      const auto [a, b] = sides[s];
      const auto found = curves.find(pair_of(a, b));
      if (found == curves.end())
        return bad_input("expected a curve between nodes " + std::to_string(a) + " and " + std::to_string(b) +
                         " of a face, found none");
      along[s] = &network.curves[found->second];
      p[s] = control_points(network, *along[s], a);
    }
    GregoryPatch patch;
    for (auto& row : patch.points) row.fill(Vec3::Zero());
    for (std::size_t k = 0; k < 4; ++k)
      patch.points[k][0] = p[0][k], patch.points[3][k] = p[1][k], patch.points[k][3] = p[2][k],
      patch.points[0][k] = p[3][k];
    // Across side s, at its two ends, run the sides before and after it; `grows`: away from it, into the patch.
    const auto across = [&](std::size_t s, const CubicPoints& before, const CubicPoints& after, bool grows) {
      const auto tangent = [&](const CubicPoints& side) {
        return Vec3(grows ? 3 * (side[1] - side[0]) : 3 * (side[3] - side[2]));
      };
      CrossField field = cross_field(network, *along[s]);
      if (along[s]->from != sides[s].first) field = {field.last, field.first};
      return tangents_across(p[s], field, tangent(before), tangent(after));
    };
    const auto at_v0 = across(0, p[3], p[1], true), at_u1 = across(1, p[0], p[2], false);
    const auto at_v1 = across(2, p[3], p[1], false), at_u0 = across(3, p[0], p[2], true);
    for (std::size_t k = 1; k <= 2; ++k) {
      patch.across_v[k - 1][0] = patch.points[k][0] + at_v0[k] / 3;
      patch.across_v[k - 1][1] = patch.points[k][3] - at_v1[k] / 3;
      patch.across_u[0][k - 1] = patch.points[0][k] + at_u0[k] / 3;
      patch.across_u[1][k - 1] = patch.points[3][k] - at_u1[k] / 3;
    }
    result.push_back(patch);
  }
  return result;
}

std::vector<TrimmedSurface> trimmed_faces(const CurveNetwork& network, const std::vector<GregoryPatch>& patches,
                                          double corner_weight) {
  ensure(patches.size() == network.faces.size(), "a patch for each face");
  const auto curves = curves_by_nodes(network);
  const std::array<Vec2, 4> corners = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  std::vector<TrimmedSurface> result;
  for (std::size_t f = 0; f < patches.size(); ++f) {
    TrimmedSurface face{rational_bezier(patches[f], corner_weight), {{}}};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto edge = curves.at(pair_of(network.faces[f][k], network.faces[f][(k + 1) % 4]));
      face.loops[0].push_back({{clamped(1, {0, 1}), {corners[k], corners[(k + 1) % 4]}, {}}, static_cast<int>(edge)});
    }
    result.push_back(std::move(face));
  }
  return result;
}

}  // namespace partscribe::geometry
