#include "fit/surface/chart_joints.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/number.h"
#include "fit/surface/curve_crossings.h"
#include "fit/surface/curve_fit.h"
#include "fit/surface/piece_fit.h"
#include "geometry/surfaces/edge_curve.h"
#include "geometry/surfaces/nurbs_edit.h"

namespace partscribe::fit {
namespace {

constexpr double meeting = 0.1;            // of the tolerance: how closely surfaces are to meet the mean of their edge
constexpr double edge_weight = 30;         // of a place on an edge, against that of a point
constexpr double beside_weight = 10;       // of a place beside it
constexpr int rounds = 6;                  // of drawing neighbours together
constexpr double most_smooth = 0.1;        // of an edge's length: how far it may leave the triangles' edges
constexpr std::size_t most_pieces = 200;   // of an edge's curve
constexpr std::size_t most_places = 4000;  // of an edge, beyond which no more of them help
constexpr double by_node = 0.2;            // of an edge: what crosses there is straightened up to its end
constexpr double straight_most = 3;        // tolerances: what is straightened may leave the surfaces

SplineFoot foot_on(const ChartPiece& piece, const Vec3& p, const Vec2& near) {
  return foot_near(piece.surface, p, near.x(), near.y());
}

/// A border between charts as a curve in space and in the plane of each side.
struct Joint {
  ChartBorder border;
  std::vector<Vec3> guide;            // the border of the charts, smoothed, at equal shares
  std::vector<Vec3> places;           // where the edge is at these shares
  std::vector<Vec2> uv[2];            // the same on the left and on the right surface
  NurbsCurve<2> trim[2];              // both run as the left chart's border does
  std::vector<Vec3> across[2];        // places a little to either side, where both surfaces show one
  std::vector<Vec2> across_uv[2][2];  // of these, on either surface
};

class Joiner {
 public:
  Joiner(const TriangleMesh& mesh, const Charts& charts, std::vector<ChartPiece> pieces, const FitInput& input,
         Context& context)
      : mesh_(mesh), input_(input), context_(context), current_(std::move(pieces)) {
    for (const auto& border : charts.borders) joints_.push_back(started(border));
    gather_nodes();
  }

  std::vector<TrimmedSurface> joined() {
    for (int round = 0; round < rounds; ++round) {
      settle();
      context_.say("free form: edges are up to " + print_number(snapped(gap(), 1e-4)) + " mm apart");
      if (!draw_together(round + 2 < rounds ? 1e300 : meeting * input_.tolerance)) {
        context_.say("free form: surfaces cannot be drawn together");
        return {};
      }
    }
    settle();
    context_.say("free form: edges are up to " + print_number(snapped(gap(), 1e-4)) + " mm apart");
    for (auto& joint : joints_) trim(joint);
    if (!uncrossed()) {
      context_.say("free form: edges cross each other");
      return {};
    }
    auto result = with_loops();
    double apart = 0;
    for (const auto& [edge, sides] : edge_sides(result)) apart = std::max(apart, edge_gap(sides, 200));
    context_.say("free form: edges as they are drawn are up to " + print_number(snapped(apart, 1e-4)) + " mm apart");
    if (apart > 0.7 * input_.tolerance) return {};
    say_angles();
    return result;
  }

 private:
  static int chart_of(const Joint& joint, int s) { return s == 0 ? joint.border.left : joint.border.right; }
  const ChartPiece* side(const Joint& joint, int s) const {
    const int chart = chart_of(joint, s);
    return chart < 0 ? nullptr : &current_[std::size_t(chart)];
  }

  static bool smooth(const Joint& joint) { return !joint.border.crease && joint.border.right >= 0; }

  Vec3 normal_on(const Joint& joint, int s, std::size_t i) const {
    return side(joint, s)->surface.derivatives(joint.uv[s][i].x(), joint.uv[s][i].y()).normal();
  }

  /// The zigzag of triangles' edges, smoothed.
  Joint started(const ChartBorder& border) const {
    Joint joint;
    joint.border = border;
    std::vector<Vec3> line;
    double length = 0;
    for (const auto v : border.vertices) {
      if (!line.empty()) length += (mesh_.vertices[v] - line.back()).norm();
      line.push_back(mesh_.vertices[v]);
    }
    const double mean = length / double(line.size() - 1);
    const double within =
        smooth(joint) ? std::max(mean, 0.5 * input_.tolerance) : std::max(0.2 * mean, 0.3 * input_.tolerance);
    // The two sides of a narrow chart stay apart.
    const NurbsCurve<3> curve = fitted_curve<3>(line, std::min(within, most_smooth * length));
    const int count = std::clamp(std::max(20 * static_cast<int>(curve.t.breaks().size() - 1),
                                          static_cast<int>(length / std::max(input_.tolerance, 0.2 * mean))),
                                 24, 1500);
    // Places in the planes from the polyline, at the same share of its length.
    std::vector<double> along = {0};
    for (std::size_t i = 1; i < line.size(); ++i)
      along.push_back(along.back() + (line[i] - line[i - 1]).norm() / std::max(length, 1e-300));
    for (int i = 0; i <= count; ++i) {
      const double share = double(i) / count;
      joint.places.push_back(curve.at(share));
      const auto next = std::size_t(std::clamp<std::ptrdiff_t>(
          std::upper_bound(along.begin(), along.end(), share) - along.begin(), 1, std::ptrdiff_t(along.size()) - 1));
      const double part = (share - along[next - 1]) / std::max(along[next] - along[next - 1], 1e-300);
      for (int s = 0; s < 2; ++s) {
        const ChartPiece* piece = side(joint, s);
        if (!piece) continue;
        const Vec2 &a = piece->places[piece->local.at(border.vertices[next - 1])],
                   &b = piece->places[piece->local.at(border.vertices[next])];
        joint.uv[s].push_back(a + std::clamp(part, 0.0, 1.0) * (b - a));
      }
    }
    joint.guide = joint.places;
    return joint;
  }

  /// Ends of joints that are one place, and one place in each plane.
  void gather_nodes() {
    for (std::size_t j = 0; j < joints_.size(); ++j)
      for (const bool last : {false, true}) {
        const auto& b = joints_[j].border;
        nodes_[last ? b.vertices.back() : b.vertices.front()].emplace_back(j, last);
      }
  }

  /// Edges go to the mean of the two surfaces' feet, some times over: where these cross, or lie between them.
  void settle() {
    for (int round = 0; round < 4; ++round) {
      for (const auto& [vertex, ends] : nodes_) settle_node(ends);
      for (auto& joint : joints_)
        for (std::size_t i = 1; i + 1 < joint.places.size(); ++i) {
          // Places slide sideways only: where surfaces disagree their feet would run together.
          const Vec3 along = (joint.guide[i + 1] - joint.guide[i - 1]).normalized();
          const Vec3 off = to_feet(joint, i) - joint.guide[i];
          joint.places[i] = joint.guide[i] + off - off.dot(along) * along;
        }
    }
    for (auto& joint : joints_) {
      even_out(joint);
      for (std::size_t i = 1; i + 1 < joint.places.size(); ++i) to_feet(joint, i);
    }
    beside();
  }

  /// Twice as many places: those between are the mean of their feet.
  void densify(Joint& joint) const {
    const auto with_middles = [](auto& list) {
      auto before = std::move(list);
      list.clear();
      for (std::size_t i = 0; i < before.size(); ++i) {
        if (i > 0) list.push_back(0.5 * (before[i - 1] + before[i]));
        list.push_back(before[i]);
      }
    };
    with_middles(joint.guide), with_middles(joint.places);
    for (auto& uv : joint.uv) with_middles(uv);
    for (std::size_t i = 1; i < joint.places.size(); i += 2) joint.places[i] = to_feet(joint, i);
  }

  /// The parameters of a place go to its feet, whose mean is returned.
  Vec3 to_feet(Joint& joint, std::size_t i) const {
    Vec3 sum = Vec3::Zero();
    int sides = 0;
    for (int s = 0; s < 2; ++s)
      if (const ChartPiece* piece = side(joint, s)) {
        const SplineFoot foot = foot_on(*piece, joint.places[i], joint.uv[s][i]);
        joint.uv[s][i] = {foot.u, foot.v};
        sum += foot.point, ++sides;
      }
    return sum / sides;
  }

  /// Surfaces that are wrinkled where they end move places to and fro: that is taken out, without shortening the edge
  /// [Taubin 1995].
  static void even_out(Joint& joint) {
    for (int round = 0; round < 6; ++round) {
      const auto before = joint.places;
      const double share = round % 2 == 0 ? 0.5 : -0.53;
      for (std::size_t i = 1; i + 1 < before.size(); ++i)
        joint.places[i] += share * (0.5 * (before[i - 1] + before[i + 1]) - before[i]);
    }
  }

  /// The mean of all charts there, each counted once; the joints that end there follow along their whole length.
  void settle_node(const std::vector<std::pair<std::size_t, bool>>& ends) {
    const auto end_of = [](auto& list, bool last) -> auto& { return last ? list.back() : list.front(); };
    std::map<int, Vec2> uv;
    Vec3 mean = Vec3::Zero();
    for (const auto& [j, last] : ends) {
      mean += end_of(joints_[j].places, last) / double(ends.size());
      for (int s = 0; s < 2; ++s)
        if (side(joints_[j], s)) uv.try_emplace(chart_of(joints_[j], s), end_of(joints_[j].uv[s], last));
    }
    Vec3 sum = Vec3::Zero();
    for (auto& [chart, at] : uv) {
      const SplineFoot foot = foot_on(current_[std::size_t(chart)], mean, at);
      at = {foot.u, foot.v}, sum += foot.point;
    }
    const Vec3 node = sum / double(uv.size());
    for (const auto& [j, last] : ends) {
      Joint& joint = joints_[j];
      const Vec3 shift = node - end_of(joint.places, last);
      const double count = double(joint.places.size() - 1);
      for (std::size_t i = 0; i < joint.places.size(); ++i)
        for (auto* list : {&joint.places, &joint.guide})
          (*list)[i] += (last ? double(i) : count - double(i)) / count * shift;
      end_of(joint.places, last) = node;
      for (int s = 0; s < 2; ++s)
        if (side(joint, s)) end_of(joint.uv[s], last) = uv[chart_of(joint, s)];
    }
  }

  /// Places a little to either side of smooth joints, between the surfaces: there they are to have one tangent plane.
  void beside() {
    for (auto& joint : joints_) {
      for (auto& list : joint.across) list.clear();
      if (!smooth(joint)) continue;
      const double off = 2 * input_.tolerance;
      for (int way = 0; way < 2; ++way)
        for (int s = 0; s < 2; ++s) joint.across_uv[way][s].clear();
      for (std::size_t i = 1; i + 1 < joint.places.size(); ++i) {
        const Vec3 along = (joint.places[i + 1] - joint.places[i - 1]).normalized();
        const Vec3 out = along.cross(normal_on(joint, 0, i) + normal_on(joint, 1, i)).normalized();
        if (!out.allFinite()) continue;
        for (int way = 0; way < 2; ++way) {
          const Vec3 start = joint.places[i] + (way == 0 ? off : -off) * out;
          SplineFoot feet[2];
          for (int s = 0; s < 2; ++s) feet[s] = foot_on(*side(joint, s), start, joint.uv[s][i]);
          // Far apart, one of them is no more the surface that the scan shows.
          if ((feet[0].point - feet[1].point).norm() > input_.tolerance) continue;
          joint.across[way].push_back(0.5 * (feet[0].point + feet[1].point));
          for (int s = 0; s < 2; ++s) joint.across_uv[way][s].emplace_back(feet[s].u, feet[s].v);
        }
      }
    }
  }

  /// How far the two sides of a joint are apart at the most.
  double gap() const {
    double most = 0;
    for (const auto& joint : joints_)
      for (std::size_t i = 0; i < joint.places.size(); ++i)
        for (int s = 0; s < 2; ++s)
          if (const ChartPiece* piece = side(joint, s))
            most = std::max(most, (piece->surface.at(joint.uv[s][i].x(), joint.uv[s][i].y()) - joint.places[i]).norm());
    return 2 * most;
  }

  /// How far joints that are no crease are from one tangent plane.
  void say_angles() const {
    std::vector<double> angles;
    for (const auto& joint : joints_) {
      if (!smooth(joint)) continue;
      for (std::size_t i = 0; i < joint.places.size(); ++i) {
        const Vec3 left = normal_on(joint, 0, i), right = normal_on(joint, 1, i);
        angles.push_back(std::atan2(left.cross(right).norm(), left.dot(right)));
      }
    }
    if (angles.empty()) return;
    std::sort(angles.begin(), angles.end());
    const auto degrees = [&](double share) {
      return print_number(snapped(angles[std::size_t(share * double(angles.size() - 1))] * 180 / pi, 0.1));
    };
    context_.say("free form: tangent planes differ by " + degrees(0.5) +
                 " degrees at half of the smooth edges' places, " + degrees(0.95) + " at 95 % and " + degrees(1) +
                 " at the most");
  }

  /// Fits every surface once more, to its points and to the places where it meets its neighbours.
  bool draw_together(double held_tolerance) {
    for (std::size_t c = 0; c < current_.size(); ++c) {
      ChartPiece& piece = current_[c];
      SplineData data = piece.data;
      data.weights.assign(data.points.size(), 1);
      const auto add = [&](const Vec3& p, const Vec2& uv, double weight) {
        data.points.push_back(p), data.places.push_back(uv), data.weights.push_back(weight);
      };
      const auto each = [&](auto&& visit) {
        for (const auto& joint : joints_)
          for (int s = 0; s < 2; ++s)
            if (chart_of(joint, s) == int(c) && joint.border.right >= 0) visit(joint, s);
      };
      each([&](const Joint& joint, int s) {
        for (int way = 0; way < 2; ++way)
          for (std::size_t i = 0; i < joint.across[way].size(); ++i)
            add(joint.across[way][i], joint.across_uv[way][s][i], beside_weight);
      });
      each([&](const Joint& joint, int s) {
        for (std::size_t i = 0; i < joint.places.size(); ++i)
          add(joint.places[i], joint.uv[s][i], edge_weight), ++data.held;
      });
      auto fit = fit_piece_again(data, piece.surface, held_tolerance, input_, context_);
      // Where neighbours disagree no net is fine enough: such an edge is met as it can be.
      if (!fit) fit = fit_piece_again(data, piece.surface, 1e300, input_, context_);
      if (!fit) return false;
      piece.surface = std::move(fit->surface);
      fit->places.resize(piece.data.points.size());
      piece.data.places = std::move(fit->places);
    }
    return true;
  }

  /// Curves of a joint in both planes, with the same knots: equal shares are equal places.
  void trim(Joint& joint) const {
    std::size_t count = 0;
    std::vector<double> at;
    const auto share_out = [&] {
      count = joint.places.size(), at.resize(count);
      for (std::size_t i = 0; i < count; ++i) at[i] = double(i) / double(count - 1);
    };
    share_out();
    int densified = 0;
    const double enough = input_.tolerance / 10;
    std::vector<double> breaks = {0, 1};
    for (int degree = 1;;) {
      const KnotVector knots = clamped(degree, breaks);
      std::vector<char> failing(breaks.size() - 1, 0);
      for (int s = 0; s < 2; ++s) {
        const ChartPiece* piece = side(joint, s);
        if (!piece) continue;
        joint.trim[s] = curve_through<2>(joint.uv[s], at, knots);
        for (std::size_t i = 0; i < count; ++i) {
          const Vec2 uv = joint.trim[s].at(at[i]);
          if ((piece->surface.at(uv.x(), uv.y()) - piece->surface.at(joint.uv[s][i].x(), joint.uv[s][i].y())).norm() <
              enough)
            continue;
          failing[std::size_t(std::upper_bound(breaks.begin() + 1, breaks.end() - 1, at[i]) - breaks.begin() - 1)] = 1;
        }
      }
      if (std::count(failing.begin(), failing.end(), 1) == 0) return;
      if (degree == 1) {
        degree = 3;
        continue;
      }
      // Pieces with few places would swing between them.
      std::vector<double> finer = {0};
      for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        if (failing[i] && (breaks[i + 1] - breaks[i]) * double(count - 1) > 3)
          finer.push_back(0.5 * (breaks[i] + breaks[i + 1]));
        finer.push_back(breaks[i + 1]);
      }
      if (finer.size() == breaks.size()) {
        if (++densified > 3 || count > most_places) return;  // as near as the surfaces are to each other
        densify(joint), share_out();
      }
      if (finer.size() > most_pieces) return;
      breaks = std::move(finer);
    }
  }

  /// Edges that leave a node in nearly the same direction may cross close to it, and one that turns sharply may cross
  /// itself: there they become straight.
  bool uncrossed() {
    for (int round = 0; round < 8 && !context_.cancelled; ++round) {
      std::map<std::size_t, std::vector<std::pair<double, double>>> straight;  // stretches of joints, in shares
      for (std::size_t c = 0; c < current_.size(); ++c) {
        std::vector<const NurbsCurve<2>*> curves;
        std::vector<std::size_t> joints;
        for (std::size_t j = 0; j < joints_.size(); ++j)
          for (int s = 0; s < 2; ++s)
            if (chart_of(joints_[j], s) == int(c)) curves.push_back(&joints_[j].trim[s]), joints.push_back(j);
        for (const auto& [curve, share] : crossings_of(curves)) {
          const std::size_t ends[2] = {joints[curve[0]], joints[curve[1]]};
          if (ends[0] == ends[1] && std::abs(share[0] - share[1]) < 0.5) {
            straight[ends[0]].emplace_back(std::min(share[0], share[1]), std::max(share[0], share[1]));
          } else {
            for (std::size_t k = 0; k < 2; ++k)
              straight[ends[k]].emplace_back(share[k] < by_node ? 0 : share[k], share[k] > 1 - by_node ? 1 : share[k]);
          }
        }
      }
      if (straight.empty()) return true;
      for (const auto& [joint, stretches] : straight) {
        for (const auto& [from, to] : stretches) straighten(joints_[joint], from, to, 1 + round);
        trim(joints_[joint]);
      }
    }
    return false;
  }

  /// Between two shares and some way beyond: a short way straight, else as a cubic, for places far from the surfaces
  /// are no edge.
  void straighten(Joint& joint, double low, double high, int more_of) const {
    const double count = double(joint.places.size() - 1),
                 more = more_of * (0.25 * (high - low) + std::max(2 / count, 0.01));
    const auto from = static_cast<std::size_t>(std::max(std::floor((low - more) * count), 0.0));
    const auto to = static_cast<std::size_t>(std::min(std::ceil((high + more) * count), count));
    if ((joint.places[to] - joint.places[from]).norm() > straight_most * input_.tolerance) {
      redraw(joint.places, from, to);
      for (auto& uv : joint.uv)
        if (!uv.empty()) redraw(uv, from, to);
      return;
    }
    for (std::size_t i = from + 1; i < to; ++i) {
      const double t = double(i - from) / double(to - from);
      joint.places[i] = joint.places[from] + t * (joint.places[to] - joint.places[from]);
      for (int s = 0; s < 2; ++s)
        if (side(joint, s)) joint.uv[s][i] = joint.uv[s][from] + t * (joint.uv[s][to] - joint.uv[s][from]);
    }
  }

  /// Places between two as one cubic near them.
  template <int Size>
  static void redraw(std::vector<Eigen::Matrix<double, Size, 1>>& list, std::size_t from, std::size_t to) {
    const std::vector<Eigen::Matrix<double, Size, 1>> before(list.begin() + std::ptrdiff_t(from),
                                                             list.begin() + std::ptrdiff_t(to) + 1);
    std::vector<double> at;
    for (std::size_t i = 0; i < before.size(); ++i) at.push_back(double(i) / double(before.size() - 1));
    const auto curve = curve_through<Size>(before, at, clamped(3, {0, 1}));
    for (std::size_t i = 1; i + 1 < before.size(); ++i) list[from + i] = curve.at(at[i]);
  }

  std::vector<TrimmedSurface> with_loops() const {
    std::vector<TrimmedSurface> result;
    for (std::size_t c = 0; c < current_.size(); ++c) {
      // The pieces of this chart's border by the node they begin at.
      std::map<std::uint32_t, std::vector<std::pair<SurfaceTrim, std::uint32_t>>> from;
      for (std::size_t j = 0; j < joints_.size(); ++j)
        for (int s = 0; s < 2; ++s) {
          const auto& b = joints_[j].border;
          if (chart_of(joints_[j], s) != int(c)) continue;
          const auto edge = static_cast<int>(j + 1);
          if (s == 0)
            from[b.vertices.front()].push_back({{joints_[j].trim[0], edge}, b.vertices.back()});
          else
            from[b.vertices.back()].push_back({{reversed(joints_[j].trim[1]), edge}, b.vertices.front()});
        }
      TrimmedSurface trimmed{current_[c].surface, {}};
      while (!from.empty()) {
        auto& loop = trimmed.loops.emplace_back();
        const std::uint32_t start = from.begin()->first;
        for (auto at = start;;) {
          const auto found = from.find(at);
          if (found == from.end()) return {};
          auto [trim, to] = std::move(found->second.back());
          found->second.pop_back();
          if (found->second.empty()) from.erase(found);
          loop.push_back(std::move(trim));
          if (to == start) break;
          at = to;
        }
      }
      std::stable_sort(trimmed.loops.begin(), trimmed.loops.end(),
                       [](const auto& a, const auto& b) { return enclosed(a) > enclosed(b); });
      result.push_back(std::move(trimmed));
    }
    return result;
  }

  /// Signed area of a loop.
  static double enclosed(const std::vector<SurfaceTrim>& loop) {
    double sum = 0;
    for (const auto& trim : loop)
      for (int i = 0; i < 64; ++i) {
        const Vec2 a = trim.curve.at(i / 64.0), b = trim.curve.at((i + 1) / 64.0);
        sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
      }
    return sum;
  }

  const TriangleMesh& mesh_;
  const FitInput& input_;
  Context& context_;
  std::vector<ChartPiece> current_;
  std::vector<Joint> joints_;
  std::map<std::uint32_t, std::vector<std::pair<std::size_t, bool>>> nodes_;  // joints that end at a vertex
};

}  // namespace

std::vector<TrimmedSurface> joined(const TriangleMesh& mesh, const Charts& charts, std::vector<ChartPiece> pieces,
                                   const FitInput& input, Context& context) {
  return Joiner(mesh, charts, std::move(pieces), input, context).joined();
}

}  // namespace partscribe::fit
