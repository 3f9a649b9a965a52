#include "scan/register/register_joint.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/decompose.h"
#include "geometry/points/nearest_again.h"
#include "scan/register/register_measured.h"
#include "scan/register/register_steps.h"

namespace partscribe::scan {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int groups = 10;               // of the jackknife, by place
constexpr double contour_trust = 0.25;   // neighbouring borders share what disturbs them
constexpr double same_face = 0.966;      // cosine of 15 degrees
constexpr double rough_free_limit = 10;  // while partners are wrong, weak directions lead astray
constexpr double well_fixed = 20;        // v'Hv / v'Mv from which measured places are asked
constexpr double shared_noise = 0.25;    // pixels; see Equations

/// Behind the six numbers of each view stand two that all views share: how much lower places lie where they are seen at
/// a slant, in noise sigmas per cosine, and how much too far out borders do, in pixels. They are not fitted, for
/// nothing tells the first from all views standing nearer to the middle; the covariance knows of them. Deviations as
/// found: 0.1 to 0.5 against drawings; 0.00 to 0.04, 0.025 on the root mean square, at the true poses of nine parts.
constexpr Eigen::Index shared = 2;
constexpr std::array<double, shared> shared_deviation{0.5, 0.03};
using Row = Eigen::Matrix<double, 6 + shared, 1>;
using Square = Eigen::Matrix<double, 6 + shared, 6 + shared>;

/// What noise in the normals alone explains is 1: from 0.4 to 1.2 where parts are round, from 2 on where something
/// fixes them. Normals of one window share their noise, so that few matches (of a view) reach more by chance. Nobody
/// else contradicts two views that lie wrong.
double free_limit(std::size_t matches, std::size_t views) {
  constexpr double window = 20, deviations = 6;
  return std::max(views > 2 ? 1.5 : 3.0,
                  1 + deviations * std::sqrt(2 * window / static_cast<double>(std::max<std::size_t>(matches, 1))));
}

/// The part of the normal equations that one view against another contributes; the other has the opposite sign.
struct PairSum {
  std::size_t a = 0, b = 0;  // positions in the list of views
  Square h = Square::Zero();
  Mat6 m = Mat6::Zero();
  Row g = Row::Zero();
  std::vector<Square> group_h;
  std::vector<Row> group_g;
  std::vector<double> residual, bend;  // e, |n_x - n_y|^2
  double bias_top = 0, bias_bottom = 0;
  std::size_t matches = 0;
};

/// What one round of matching starts from.
struct Round {
  double reach = 0, wide = 0, border_wide = 0;    // mm: across, and the kernels' widths along the normal
  double surface_sigma = 1, contour_sigma = 0.8;  // mm; pixels
  double normal_variance = 1e-3, bias = 0;        // rad^2; pixels
  std::size_t stride = 1;                         // of the samples
  bool grouped = false, narrow = false;

  /// Width of the borders' kernel, in pixels of this size.
  double border_kernel(double pixel) const { return std::max(2.5 * contour_sigma, border_wide / pixel); }
};

struct Problem {
  const std::vector<ViewSurface>& surfaces;
  const std::vector<std::size_t>& views;
  std::vector<Pose> poses;  // by position in `views`
  Vec3 center;
  double size;

  const ViewSurface& surface(std::size_t k) const { return surfaces[views[k]]; }
};

int group_of(const Problem& problem, const Vec3& p) {
  std::uint64_t hash = 0x9E3779B97F4A7C15ull;
  for (int k = 0; k < 3; ++k) {
    const auto cell = static_cast<std::int64_t>(std::floor((p[k] - problem.center[k]) / (0.4 * problem.size)));
    hash = (hash ^ static_cast<std::uint64_t>(cell + 1000)) * 0xBF58476D1CE4E5B9ull;
    hash ^= hash >> 29;
  }
  return static_cast<int>(hash % groups);
}

/// The derivative of a distance along `n` at `place`.
Vec6 row_of(const Problem& problem, const Vec3& place, const Vec3& n) {
  Vec6 row;
  row << ((place - problem.center) / problem.size).cross(n), n;
  return row;
}

Mat6 square_of(const Vec6& row) { return row * row.transpose(); }

/// What a normal of this variance (rad^2) across itself mixes into the square of its row.
Mat6 mixed_in(const Problem& problem, const Vec3& place, const Vec3& n, double variance) {
  const Vec3 u = n.unitOrthogonal();
  return variance * (square_of(row_of(problem, place, u)) + square_of(row_of(problem, place, n.cross(u))));
}

/// `slant` and `border`: the derivatives of the distance `e` by what all views share.
void add_row(const Problem& problem, const Vec3& place, const Vec3& n, double e, double slant, double border, double w,
             const Mat6& mixed, bool grouped, PairSum& sum) {
  Row row;
  row << row_of(problem, place, n), slant, border;
  const Square square = w * row * row.transpose();
  sum.h += square, sum.g -= w * e * row, sum.m += w * mixed;
  ++sum.matches;
  if (!grouped) return;
  const auto k = static_cast<std::size_t>(group_of(problem, place));
  sum.group_h[k] += square, sum.group_g[k] -= w * e * row;
}

PairSum empty_sum(std::size_t a, std::size_t b, bool grouped) {
  PairSum sum;
  sum.a = a, sum.b = b;
  if (grouped) sum.group_h.assign(groups, Square::Zero()), sum.group_g.assign(groups, Row::Zero());
  return sum;
}

/// The share of its weight that a match keeps where the more slanted of the two views sees it under this cosine. What
/// is wrong there is wrong for whole faces (mixed pixels of one side, half a pixel's place) and does not average out;
/// better than equal weights and than the square, and the fourth power lets borders fix what they do not.
double slant_share(double cosine) {
  const double c = std::max(cosine, 1e-3);
  return c * c * c;
}

PairSum match_surfaces(const Problem& problem, std::size_t a, std::size_t b, const Round& round,
                       NearestAgain& partners) {
  PairSum sum = empty_sum(a, b, round.grouped);
  const ViewSurface &from = problem.surface(a), &to = problem.surface(b);
  const Pose there = problem.poses[b].inverse() * problem.poses[a];
  for (std::size_t k = 0; k < from.samples.size(); k += round.stride) {
    const auto i = from.samples[k];
    const Vec3 x = there * from.points[i], nx = there.rotation * from.normals[i];
    if (nx.dot(to.raster.ray(x)) > 0.1) continue;  // faces away: the other cannot see it
    const std::uint32_t near = partners.nearest(k, x, 3 * round.reach);
    if (near == NearestAgain::nobody || !to.smooth[near]) continue;
    const Vec3& ny = to.normals[near];
    if (nx.dot(ny) < 0.7071) continue;
    const Vec3 n = (nx + ny).normalized(), d = x - to.points[near];
    const double e = d.dot(n);
    // Places beyond the other view's border, and beside a crease that one of the two took for a slope.
    if (round.narrow && ((d - e * n).norm() > to.spacing || nx.dot(ny) < same_face)) continue;
    const double w =
        std::exp(-d.squaredNorm() / (2 * round.reach * round.reach) - e * e / (2 * round.wide * round.wide));
    if (w < 1e-3) continue;
    const double variance = std::max(0.5 * (from.variance[i] + to.variance[near]), 0.5);
    // Apart from how the surface bends from place to place the normals differ by two errors, their mean by half as
    // much.
    Vec3 errors = nx - ny;
    if (d.norm() < 2 * from.spacing) errors -= there.rotation * (from.bending(k) * (there.rotation.transpose() * d));
    const Pose& pose = problem.poses[b];
    const Vec3 place = pose * (x - 0.5 * d);
    const double from_cosine = from.cosine[i], to_cosine = to.cosine[near];
    const double slant = (from_cosine - to_cosine) * 0.5 * (from.sigma + to.sigma);
    const double share = round.narrow ? slant_share(std::min(from_cosine, to_cosine)) : 1;
    add_row(problem, place, pose.rotation * n, e, slant, 0,
            share * w / (variance * round.surface_sigma * round.surface_sigma),
            square_of(row_of(problem, place, pose.rotation * (0.5 * errors))), round.grouped, sum);
    sum.residual.push_back(e), sum.bend.push_back((nx - ny).squaredNorm());
  }
  return sum;
}

constexpr int rough_rounds = 4;  // at the end, where that is enough
constexpr std::size_t most_contour = 3000, rough_contour = 150;

/// A place of another view beside a border, and how far the border lies outside it, in pixels.
struct Beside {
  std::size_t at = 0;
  double off = 0;
};

/// A border of one view as another one sees it.
struct SeenBorder {
  Vec3 q, outward, na,
      ray;  // its place, the way out, the normal of its face and the sight of its own view, in the other's frame
};

SeenBorder seen_from(const Pose& there, const ViewSurface& from, const ContourPoint& c) {
  return {there * c.point, there.rotation * c.outward, there.rotation * c.normal,
          there.rotation * from.raster.ray(c.point)};
}

/// The place of `to` that a border of another view is compared with. Right beside an edge places are rounded off where
/// noise is large (half a pixel too low was measured), a little farther on they are not, and far away a round face has
/// curved away and a flat one has ended. So the best known place within reach is taken, at a penalty for its distance.
/// Places on the other side of a wall whose edge returned nothing do not count. Nothing if no place lies next to the
/// border, or if the nearest one is on another face than the best: then a chamfer or a round lies between them, so
/// narrow that it has hardly a place of its own, and the border does not end at the face behind it. `of_samples`: only
/// samples are asked; `near`: scratch space for points of `to` in order of their distance from the border.
std::optional<Beside> surface_beside(const ViewSurface& to, const ContourPoint& border, const SeenBorder& seen,
                                     bool of_samples, const Round& round, std::vector<Neighbour>& near) {
  constexpr double next_to = 1.5, reach = 4, far = 0.05;  // spacings across; what the square of one spacing costs
  constexpr double other_side = -0.5;                     // cosine
  const auto& [q, outward, na, ray] = seen;
  const double wide = round.border_kernel(border.pixel);
  (of_samples ? *to.sample_tree : *to.tree)
      .within(q, std::max(4 * std::max(to.spacing, border.pixel), round.reach), near);
  std::optional<Beside> best;
  Vec3 adjoining = Vec3::Zero();
  double least = 0;
  for (const Neighbour& neighbour : near) {
    const std::size_t at = of_samples ? to.samples[neighbour.index] : neighbour.index;
    const Vec3& n = to.normals[at];
    const double towards = -n.dot(ray);
    if (!to.smooth[at] || towards > 0.25 || towards < -0.75 || n.dot(na) > 0.75 || n.dot(na) < other_side ||
        n.dot(outward) < 0.3)
      continue;
    const Vec3 d = q - to.points[at];
    const double e = d.dot(n), across = (d - e * n).norm() / to.spacing;
    if (round.narrow && across > (best ? reach : next_to)) break;
    if (std::abs(e) > 2 * wide * border.pixel) continue;
    const double cost = to.variance[at] * to.variance[at] * (1 + far * across * across);
    if (!best)
      adjoining = n;
    else if (cost < least && n.dot(adjoining) < same_face)
      return {};
    if (!best || cost < least) best = Beside{at, e / border.pixel}, least = cost;
    if (!round.narrow) break;
  }
  return best;
}

/// Whether the edge between a border's own face and one beside it is broken by a chamfer or a round: other views show
/// places near it that lie inside of both faces. What ends at the border is then not what the face beside it runs up
/// to.
bool is_broken(const Problem& problem, std::size_t a, const ContourPoint& border, const Vec3& on_face,
               const Vec3& face) {
  constexpr double around = 2.5, inside = 0.05,
                   sigmas = 2;  // pixels; pixels and sigmas: of sharp edges one in ten is deeper
  constexpr int enough = 2;     // places: one may be an outlier
  const Vec3 q = problem.poses[a] * border.point, own = problem.poses[a].rotation * border.normal;
  std::vector<Neighbour> near;
  int found = 0;
  for (std::size_t w = 0; w < problem.views.size(); ++w) {
    if (w == a) continue;
    const ViewSurface& other = problem.surface(w);
    const double margin = inside * border.pixel + sigmas * other.sigma;
    other.tree->within(problem.poses[w].inverse() * q, around * border.pixel, near);
    for (const Neighbour& k : near) {
      const Vec3 p = problem.poses[w] * other.points[k.index];
      if ((q - p).dot(own) > margin && (on_face - p).dot(face) > margin && ++found >= enough) return true;
    }
  }
  return false;
}

/// Which borders of view `a` stand on sharp edges to faces of `b` that lie beside them. An edge is broken where others
/// show that, or of a quarter of the borders around: a narrow chamfer has few places, but runs along the whole edge.
std::vector<std::uint8_t> sharp_edges(const Problem& problem, std::size_t a, std::size_t b, const Round& round) {
  constexpr double around = 6, share = 0.25;  // pixels
  const ViewSurface &from = problem.surface(a), &to = problem.surface(b);
  const Pose there = problem.poses[b].inverse() * problem.poses[a];
  std::vector<std::uint8_t> sharp(from.contour.size(), 0), broken;  // of the contour; of those asked
  std::vector<std::size_t> asked;
  std::vector<Vec3> places;
  std::vector<Neighbour> near;
  for (std::size_t k = 0; k < from.contour.size(); ++k) {
    const ContourPoint& c = from.contour[k];
    const auto beside = surface_beside(to, c, seen_from(there, from, c), false, round, near);
    if (!beside) continue;
    asked.push_back(k), places.push_back(c.point);
    broken.push_back(is_broken(problem, a, c, problem.poses[b] * to.points[beside->at],
                               problem.poses[b].rotation * to.normals[beside->at]));
  }
  if (asked.empty()) return sharp;
  const KdTree tree(places);
  for (std::size_t k = 0; k < asked.size(); ++k) {
    tree.within(places[k], around * from.contour[asked[k]].pixel, near);
    const auto others =
        std::count_if(near.begin(), near.end(), [&](const Neighbour& n) { return broken[n.index] != 0; });
    sharp[asked[k]] = !broken[k] && double(others) <= share * double(near.size());
  }
  return sharp;
}

/// `sharp`: sharp_edges, found when they are asked for first, and kept.
PairSum match_contours(const Problem& problem, std::size_t a, std::size_t b, const Round& round,
                       std::vector<std::uint8_t>& sharp) {
  PairSum sum = empty_sum(a, b, round.grouped);
  const ViewSurface &from = problem.surface(a), &to = problem.surface(b);
  const Pose there = problem.poses[b].inverse() * problem.poses[a];
  if (round.narrow && sharp.empty()) sharp = sharp_edges(problem, a, b, round);
  std::vector<Neighbour> near;
  // While poses are rough a few borders looked for far and wide are enough.
  const bool wide_search = round.reach > 8 * to.spacing;
  const std::size_t count = std::min(wide_search ? rough_contour : most_contour, from.contour.size());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t at = (2 * k + 1) * from.contour.size() / (2 * count);
    if (round.narrow && !sharp[at]) continue;
    const ContourPoint& c = from.contour[at];
    const SeenBorder seen = seen_from(there, from, c);
    const auto beside = surface_beside(to, c, seen, wide_search, round, near);
    if (!beside) continue;
    const Vec3& n = to.normals[beside->at];
    const double e = beside->off, lever = n.dot(seen.outward);
    const double wide = round.border_kernel(c.pixel);
    const double w = std::exp(-e * e / (2 * wide * wide));
    const double sigma = round.contour_sigma * c.pixel;
    const Vec3 place = problem.poses[b] * seen.q, normal = problem.poses[b].rotation * n;
    add_row(problem, place, normal, e * c.pixel, 0, lever * c.pixel, contour_trust * w / (sigma * sigma),
            mixed_in(problem, place, normal, round.normal_variance), round.grouped, sum);
    sum.residual.push_back(e);
    sum.bias_top += w * e * lever, sum.bias_bottom += w * lever * lever;
  }
  return sum;
}

/// The least and the largest angle between two directions of sight.
double sight_cosine(const Problem& problem, std::size_t a, std::size_t b) {
  const auto direction = [&](std::size_t k) {
    return Vec3(problem.poses[k].rotation * problem.surface(k).raster.ray(problem.surface(k).center));
  };
  return direction(a).dot(direction(b));
}

using PairList = std::vector<std::pair<std::size_t, std::size_t>>;

/// Each view with the views that share most of its surface, both ways round.
PairList neighbour_pairs(const Problem& problem, double reach, int neighbours, int threads) {
  const std::size_t n = problem.views.size();
  std::vector<double> share(n * n, 0);
  parallel_for(
      n * n, threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const std::size_t a = k / n, b = k % n;
          if (a == b) continue;
          const ViewSurface &from = problem.surface(a), &to = problem.surface(b);
          const Pose there = problem.poses[b].inverse() * problem.poses[a];
          const std::size_t count = std::min<std::size_t>(150, from.samples.size());
          int hits = 0;
          for (std::size_t s = 0; s < count; ++s) {
            const auto i = from.samples[s * from.samples.size() / count];
            const Vec3 x = there * from.points[i];
            const Neighbour near = to.nearest_within(x, reach);
            hits +=
                near.sq_distance < reach * reach && to.normals[near.index].dot(there.rotation * from.normals[i]) > 0.8;
          }
          share[k] = static_cast<double>(hits) / static_cast<double>(count);
        }
      },
      1);
  std::vector<char> chosen(n * n, 0);
  for (std::size_t a = 0; a < n; ++a) {
    std::vector<std::size_t> order;
    for (std::size_t b = 0; b < n; ++b)
      if (share[a * n + b] > 0.03) order.push_back(b);
    std::stable_sort(order.begin(), order.end(), [&](auto p, auto q) { return share[a * n + p] > share[a * n + q]; });
    for (std::size_t k = 0; k < std::min(order.size(), static_cast<std::size_t>(neighbours)); ++k)
      chosen[a * n + order[k]] = chosen[order[k] * n + a] = 1;
  }
  PairList pairs;
  for (std::size_t k = 0; k < n * n; ++k)
    if (chosen[k]) pairs.emplace_back(k / n, k % n);
  return pairs;
}

/// The normal equations of all views but the first, and of what all share.
struct System {
  MatrixXd h, m;
  VectorXd g;
};

void scatter(const PairSum& sum, const Square& h, const Mat6& m, const Row& g, System& system) {
  const Eigen::Index last = system.h.rows() - shared;
  add_pair(sum.a, sum.b, h.topLeftCorner<6, 6>(), system.h), add_pair(sum.a, sum.b, m, system.m);
  add_pull(sum.a, sum.b, g.head<6>(), system.g);
  const auto couple = [&](std::size_t view, double sign) {
    if (view == 0) return;
    system.h.block<6, shared>(first_unknown(view), last) += sign * h.topRightCorner<6, shared>();
    system.h.block<shared, 6>(last, first_unknown(view)) += sign * h.bottomLeftCorner<shared, 6>();
  };
  couple(sum.a, 1), couple(sum.b, -1);
  system.h.bottomRightCorner<shared, shared>() += h.bottomRightCorner<shared, shared>();
  system.g.tail<shared>() += g.tail<shared>();
}

System assemble(std::size_t views, const std::vector<PairSum>& sums, int group = -1) {
  const auto n = static_cast<Eigen::Index>(6 * (views - 1)) + shared;
  System system{MatrixXd::Zero(n, n), MatrixXd::Zero(n, n), VectorXd::Zero(n)};
  for (const PairSum& sum : sums)
    if (group < 0)
      scatter(sum, sum.h, sum.m, sum.g, system);
    else
      scatter(sum, sum.group_h[std::size_t(group)], Mat6::Zero(), sum.group_g[std::size_t(group)], system);
  return system;
}

System together(const System& a, const System& b) { return {a.h + b.h, a.m + b.m, a.g + b.g}; }

/// Directions of poses in order of how well they are fixed; columns v with v'Mv = 1, so that v'Hv is the eigenvalue.
struct Directions {
  MatrixXd v;
  VectorXd fixed;
  Eigen::Index first = 0;  // of those that are fixed well enough
};

Directions directions_of(const System& system, double limit) {
  const Eigen::Index n = system.h.rows() - shared;
  const MatrixXd h = system.h.topLeftCorner(n, n);
  MatrixXd m = system.m.topLeftCorner(n, n);
  m.diagonal().array() +=
      1e-9 * std::max(m.trace() / static_cast<double>(n), 1e-30) + 1e-12 * h.trace() / static_cast<double>(n);
  const auto eigen = generalized_eigensystem(h, m);
  Directions result{eigen.vectors, eigen.values};
  while (result.first < n && !(result.fixed[result.first] > limit)) ++result.first;
  return result;
}

/// What surfaces and borders say. Noise that the place and the normal of one window share makes surfaces pull even
/// where they fix nothing (found: towards places a quarter of a pixel off, with v'Hv = v'Mv), more than borders hold
/// against: there only borders are asked.
struct Equations {
  System surfaces, borders;
  Directions directions;  // of both together
  MatrixXd trusted;       // projects onto what surfaces alone fix
  Directions by_surfaces;

  /// Columns in all unknowns; what all views share stays.
  MatrixXd fixed() const {
    MatrixXd basis = MatrixXd::Zero(surfaces.h.rows(), directions.v.cols() - directions.first);
    basis.topRows(directions.v.rows()) = directions.v.rightCols(basis.cols());
    return basis;
  }
  /// Columns in the six unknowns of each view.
  MatrixXd well_fixed_by_surfaces() const {
    Eigen::Index first = by_surfaces.first;
    while (first < by_surfaces.fixed.size() && !(by_surfaces.fixed[first] > well_fixed)) ++first;
    return by_surfaces.v.rightCols(by_surfaces.v.cols() - first);
  }
  System asked(const System& of_surfaces, const System& of_borders) const {
    const MatrixXd& p = trusted;
    return together(
        {p.transpose() * of_surfaces.h * p, p.transpose() * of_surfaces.m * p, p.transpose() * of_surfaces.g},
        of_borders);
  }
  System asked() const { return asked(surfaces, borders); }
};

Equations equations_of(std::size_t views, const std::vector<PairSum>& surfaces, const std::vector<PairSum>& borders,
                       double limit, bool rough) {
  Equations e{assemble(views, surfaces), assemble(views, borders), {}, {}, {}};
  e.directions = directions_of(together(e.surfaces, e.borders), limit);
  e.by_surfaces = directions_of(e.surfaces, limit);
  const MatrixXd& v = e.by_surfaces.v;
  const Eigen::Index known = v.cols() - e.by_surfaces.first;
  e.trusted = MatrixXd::Identity(e.surfaces.h.rows(), e.surfaces.h.cols());
  if (!rough && !e.borders.h.isZero())
    e.trusted.topLeftCorner(v.rows(), v.rows()) = v.rightCols(known) * v.inverse().bottomRows(known);
  return e;
}

/// The largest move of any place of the part, mm.
double apply(Problem& problem, const VectorXd& step, double limit) {
  double most = 0;
  for (std::size_t k = 1; k < problem.views.size(); ++k) {
    Vec3 turn = step.segment<3>(first_unknown(k)) / problem.size, shift = step.segment<3>(first_unknown(k) + 3);
    const double move = turn.norm() * problem.size + shift.norm();
    if (move > limit) turn *= limit / move, shift *= limit / move;
    problem.poses[k] = moved_about(problem.poses[k], problem.center, turn, shift);
    most = std::max(most, std::min(move, limit));
  }
  return most;
}

/// What a match is worth depends on how far matches of its kind are off.
void learn(const std::vector<PairSum>& surfaces, const std::vector<PairSum>& contours, double least,
           double most_contour_sigma, Round& round) {
  std::vector<double> residual, bend, border;
  double top = 0, bottom = 0;
  for (const PairSum& sum : surfaces) {
    residual.insert(residual.end(), sum.residual.begin(), sum.residual.end());
    bend.insert(bend.end(), sum.bend.begin(), sum.bend.end());
  }
  for (const PairSum& sum : contours) {
    border.insert(border.end(), sum.residual.begin(), sum.residual.end());
    top += sum.bias_top, bottom += sum.bias_bottom;
  }
  round.surface_sigma = std::max(spread_of(std::move(residual)), least);
  // |n_x - n_y|^2 has the median 2 ln 2 (2 s^2); the mean of the two normals has the variance s^2 / 2.
  round.normal_variance = std::max(0.18 * median(std::move(bend)), 1e-8);
  if (!border.empty()) round.contour_sigma = std::clamp(spread_of(std::move(border)), 0.2, most_contour_sigma);
  round.bias = bottom > 0 ? top / bottom : 0;
}

/// Of all unknowns, in their units.
MatrixXd covariance_of(const std::vector<PairSum>& surfaces, const std::vector<PairSum>& borders,
                       const Equations& equations, std::size_t views, double spacing) {
  const System asked = equations.asked();
  const MatrixXd basis = equations.fixed();
  const Eigen::Index size = asked.h.rows();
  if (basis.cols() == 0) return MatrixXd::Zero(size, size);
  // Of the squares of the rows, M is what noise in the normals mixes in.
  const MatrixXd exact = answer_of(asked.h - asked.m, basis);
  MatrixXd spread = exact * asked.h * exact.transpose();
  // Leave out one group of places after the other.
  std::vector<VectorXd> steps;
  VectorXd mean = VectorXd::Zero(size);
  for (int group = 0; group < groups; ++group) {
    const System part = equations.asked(assemble(views, surfaces, group), assemble(views, borders, group));
    steps.push_back(answer_of(asked.h - part.h, basis) * (asked.g - part.g));
    mean += steps.back() / groups;
  }
  for (const VectorXd& step : steps) spread += (groups - 1.0) / groups * (step - mean) * (step - mean).transpose();
  // What does not average out: what all views share, and windows' noise where surfaces fix a direction weakly.
  const MatrixXd answer = answer_of(asked.h, basis);
  for (Eigen::Index k = 0; k < shared; ++k) {
    const VectorXd step = shared_deviation[static_cast<std::size_t>(k)] * answer * asked.h.col(size - shared + k);
    spread += step * step.transpose();
  }
  const MatrixXd& v = equations.by_surfaces.v;
  const MatrixXd pull = answer * equations.trusted.transpose() * equations.surfaces.m.leftCols(v.rows()) * v;
  for (Eigen::Index k = equations.by_surfaces.first; k < v.cols(); ++k) {
    const VectorXd step = shared_noise * spacing / std::max(largest_of_a_view(v.col(k)), 1e-300) * pull.col(k);
    spread += step * step.transpose();
  }
  return spread;
}

}  // namespace

double largest_of_a_view(const VectorXd& direction) {
  double most = 0;
  for (Eigen::Index i = 0; i < direction.size(); i += 6) most = std::max(most, direction.segment<6>(i).norm());
  return most;
}

JointResult adjust_jointly(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                           const std::vector<std::size_t>& views, const JointOptions& options, Context& context) {
  JointResult result;
  result.poses = poses;
  const auto unknowns = static_cast<Eigen::Index>(6 * poses.size());
  result.covariance = MatrixXd::Zero(unknowns, unknowns);
  result.matches.assign(poses.size(), 0);
  result.gap.assign(poses.size(), std::vector<double>(poses.size(), -1));
  Problem problem{surfaces, views, {}, Vec3::Zero(), 1};
  double spacing = 0, sigma = 0;
  for (const std::size_t v : views) {
    problem.poses.push_back(poses[v]);
    problem.center += poses[v] * surfaces[v].center / static_cast<double>(views.size());
    spacing = std::max(spacing, surfaces[v].spacing), sigma = std::max(sigma, surfaces[v].sigma);
  }
  double square = 0;
  for (std::size_t k = 0; k < views.size(); ++k)
    square += (problem.poses[k] * problem.surface(k).center - problem.center).squaredNorm() +
              std::pow(problem.surface(k).radius, 2);
  if (!views.empty()) problem.size = std::sqrt(square / static_cast<double>(views.size()));
  result.center = problem.center, result.size = problem.size;
  if (views.size() < 2) return result;

  const double end_reach = std::max(1.5 * spacing, 4 * sigma);
  const double least = std::max(1e-3 * spacing, 0.2 * sigma);  // 0.28 sigma if both are means of 25
  Round round;
  round.reach = std::max(options.start_reach, end_reach);
  round.surface_sigma = round.reach / 4;
  // One pose is soon found well enough for narrow kernels.
  constexpr std::size_t many_samples = 1000, share_of_many = 4;
  const bool two = views.size() == 2 &&
                   std::min(problem.surface(0).samples.size(), problem.surface(1).samples.size()) >= many_samples;
  PairList pairs = neighbour_pairs(problem, round.reach, options.neighbours, context.threads), borders;
  if (options.contours && views.size() > 2)  // of two nothing would tell which face a border belongs to
    for (std::size_t a = 0; a < views.size(); ++a)
      for (std::size_t b = 0; b < views.size(); ++b)
        if (a != b && !problem.surface(a).contour.empty() && std::abs(sight_cosine(problem, a, b) + 0.08) < 0.79)
          borders.emplace_back(a, b);
  std::vector<NearestAgain> partners;
  const auto follow = [&] {
    partners.clear();
    for (const auto& [a, b] : pairs)
      partners.emplace_back(*problem.surface(b).tree, problem.surface(b).points, problem.surface(a).samples.size(),
                            problem.surface(b).grid.get());
  };
  follow();
  std::vector<PairSum> sums, contour_sums;
  std::vector<std::vector<std::uint8_t>> sharp(borders.size());
  round.border_wide = round.reach / 2;
  const auto match = [&] {
    round.wide = std::max(round.border_wide, 3 * round.surface_sigma);
    round.stride = two && !round.narrow && !round.grouped ? share_of_many : 1;
    sums.assign(pairs.size(), {}), contour_sums.assign(borders.size(), {});
    parallel_for(
        pairs.size() + borders.size(), context.threads,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t k = begin; k < end; ++k)
            if (k < pairs.size())
              sums[k] = match_surfaces(problem, pairs[k].first, pairs[k].second, round, partners[k]);
            else
              contour_sums[k - pairs.size()] =
                  match_contours(problem, borders[k - pairs.size()].first, borders[k - pairs.size()].second, round,
                                 sharp[k - pairs.size()]);
        },
        1);
  };
  const auto matches_of_view = [&] {
    std::size_t matches = 0;
    for (const PairSum& sum : sums) matches += sum.matches;
    return matches / (views.size() - 1);
  };
  int at_end = 0;
  for (int k = 0; k < options.rounds && !context.cancelled; ++k) {
    context.report("adjusting all views", static_cast<double>(k) / options.rounds);
    match();
    learn(sums, contour_sums, least, std::max(0.5, 0.25 * (round.reach - end_reach) / spacing), round);
    const bool rough = round.reach > end_reach;
    const double limit = rough ? rough_free_limit : free_limit(matches_of_view(), views.size());
    const Equations equations = equations_of(views.size(), sums, contour_sums, limit, rough);
    const System asked = equations.asked();
    if (!(asked.h.trace() > 0)) break;
    const double moved = apply(problem, answer_of(asked.h, equations.fixed()) * asked.g, 2 * round.reach);
    if (rough) {
      if (moved < 0.2 * round.reach) {
        round.reach = std::max(0.6 * round.reach, end_reach), round.border_wide = round.reach / 2;
        if (round.reach == end_reach)
          pairs = neighbour_pairs(problem, 3 * round.reach, options.neighbours, context.threads), follow();
      }
      continue;
    }
    if (options.roughly) {
      if (++at_end >= rough_rounds) break;
      continue;
    }
    // By steps: what only a few places fix is lost when a narrow kernel sees them off at once.
    if (round.border_wide > 0) {
      round.border_wide *= 0.6;
      if (round.border_wide < 3 * round.surface_sigma) round.border_wide = 0, round.narrow = true;
      continue;
    }
    // What is left of two views' pose is found by the places as measured: three rounds leave 0.04 sigma.
    if (++at_end >= (two ? 3 : 6) && moved < (two ? 0.1 : 0.02) * std::max(sigma, 1e-3 * spacing)) break;
  }
  for (std::size_t k = 0; k < views.size(); ++k) result.poses[views[k]] = problem.poses[k];
  if (options.roughly) return result;
  round.grouped = true;
  match();
  const Equations equations =
      equations_of(views.size(), sums, contour_sums, free_limit(matches_of_view(), views.size()), false);
  if (equations.asked().h.trace() > 0) {
    const MatrixXd spread = covariance_of(sums, contour_sums, equations, views.size(), spacing);
    Vec6 unit;
    unit << Vec3::Constant(1 / problem.size), Vec3::Ones();
    const auto place = [&](std::size_t k) { return static_cast<Eigen::Index>(6 * views[k]); };
    for (std::size_t a = 1; a < views.size(); ++a)
      for (std::size_t b = 1; b < views.size(); ++b)
        result.covariance.block<6, 6>(place(a), place(b)) =
            unit.asDiagonal() * spread.block<6, 6>(first_unknown(a), first_unknown(b)) * unit.asDiagonal();
    for (Eigen::Index k = 0; k < equations.directions.first; ++k) {
      VectorXd direction = VectorXd::Zero(unknowns);
      for (std::size_t j = 1; j < views.size(); ++j)
        direction.segment<6>(place(j)) = equations.directions.v.col(k).segment<6>(first_unknown(j));
      result.free_directions.push_back(direction.normalized());
    }
  }
  if (options.rounds > 0) {
    const auto own = static_cast<Eigen::Index>(6 * (views.size() - 1));
    const AdjustedViews adjusted{views,
                                 pairs,
                                 problem.center,
                                 problem.size,
                                 equations.well_fixed_by_surfaces(),
                                 equations.borders.h.topLeftCorner(own, own),
                                 equations.borders.g.head(own)};
    adjust_by_measured(surfaces, adjusted, result.poses, context);
  }
  for (const PairSum& sum : sums) {
    result.surface_matches += sum.matches;
    result.matches[views[sum.a]] += sum.matches, result.matches[views[sum.b]] += sum.matches;
    std::vector<double> sizes = sum.residual;
    for (double& e : sizes) e = std::abs(e);
    if (sizes.size() >= 30) result.gap[views[sum.a]][views[sum.b]] = median(std::move(sizes));
  }
  for (const PairSum& sum : contour_sums) result.contour_matches += sum.matches;
  result.surface_sigma = round.surface_sigma, result.contour_sigma = round.contour_sigma,
  result.contour_bias = round.bias;
  return result;
}

}  // namespace partscribe::scan
