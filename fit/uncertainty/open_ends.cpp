#include "fit/uncertainty/open_ends.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "fit/refine/refine.h"
#include "geometry/decompose.h"

namespace partscribe::fit {
namespace {

constexpr double objection = 2;  // nats: two sigmas
const Welsch kernel{3};

/// Orthonormal columns: directions in the unknowns that hardly any point depends on.
Matrix hardly_fixed(const AllPoints& all, double few, int threads) {
  std::vector<double> weight(all.nodes.size(), 0);
  for (std::size_t k = 0; k < all.nodes.size(); ++k)
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i)
      if (all.used[i]) weight[k] += kernel.weight(all.at.value[i] / all.sigma[i]);
  const Matrix h = normal_equations(all.jacobian.rows, weight, std::vector<double>(weight.size(), 0), threads).h;
  const auto eigen = eigensystem(h);
  const double most = std::max(double(hardly_any_points), few * double(all.points.size()));
  Eigen::Index count = 0;
  while (count < h.rows() && eigen.values[count] < most) ++count;
  return eigen.vectors.leftCols(count);
}

/// Some points of the whole part, each standing for `each` of the scan.
struct Selection {
  const std::vector<Vec3>& points;
  double each;
  std::vector<double> here;  ///< their distances from the candidate
};

/// The cost along one direction in the unknowns. Where a number moves few points, all of them are asked; of those that
/// it meets farther on, and that the part as a whole turns or shifts, the selection speaks.
class WayThrough {
 public:
  WayThrough(const Candidate& candidate, const Unknowns& unknowns, const Vector& direction, const AllPoints& all,
             const Selection& selection, double noise, Context& context)
      : candidate_(candidate),
        unknowns_(unknowns),
        direction_(direction),
        selection_(selection),
        noise_(noise),
        context_(context),
        away_(selection.points.size(), 1) {
    ask_those_that_move(all);
    for (const double d : selection.here) still_ += kernel.loss(d / noise_);
  }

  /// Nats.
  double cost(double way) {
    const Candidate moved = at(way);
    if (!unknowns_.sensible(moved)) return std::numeric_limits<double>::infinity();
    double& walked = walked_[way > 0 ? 1 : 0];
    if (std::abs(way) > walked) find_met(moved, std::abs(way), walked == 0), walked = std::abs(way);
    return own_each_ * loss(moved, own_) + selection_.each * (still_ + loss(moved, met_));
  }

  Candidate at(double way) const { return unknowns_.stepped(candidate_, way * direction_); }

  /// How far it may go, to one side, before the cost reaches `most`; more than the part's size if it never does.
  double until(double side, double most) {
    constexpr int halvings = 7;
    double free = 0, step = 0.1 * noise_;
    for (; cost(side * step) < most; step *= 2) {
      free = step;
      if (step > unknowns_.size()) return free;
    }
    for (int k = 0; k < halvings; ++k) {
      const double middle = 0.5 * (free + step);
      (cost(side * middle) < most ? free : step) = middle;
    }
    return free;
  }

 private:
  static constexpr double hardly = 0.1;  // mm of a distance per mm of the way
  const Candidate& candidate_;
  const Unknowns& unknowns_;
  Vector direction_;
  const Selection& selection_;
  double noise_;
  Context& context_;
  std::vector<Vec3> own_, met_;            // points that move from the start; those of the selection that do later
  double own_each_ = 1;                    // points of the scan that one of `own_` stands for
  std::vector<char> away_;                 // of the selection: neither `own_` nor `met_`
  double still_ = 0;                       // the cost of these
  std::array<double, 2> walked_ = {0, 0};  // backwards, forwards

  double loss(const Candidate& there, const std::vector<Vec3>& points) const {
    double sum = 0;
    for (const double d : unknowns_.distances(there, points, context_.threads).value) sum += kernel.loss(d / noise_);
    return sum;
  }

  void ask_those_that_move(const AllPoints& all) {
    constexpr std::size_t most = 1000;
    for (std::size_t k = 0; k < all.nodes.size(); ++k)
      if (std::abs(all.jacobian.rows.row(static_cast<Eigen::Index>(k)).dot(direction_)) > hardly)
        for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) own_.push_back(all.points[i]);
    const std::size_t stride = (own_.size() + most - 1) / most;
    if (stride < 2) return;
    own_each_ = double(stride);
    std::vector<Vec3> some;
    for (std::size_t i = 0; i < own_.size(); i += stride) some.push_back(own_[i]);
    own_ = std::move(some);
  }

  void find_met(const Candidate& there, double way, bool at_once) {
    const Distances d = unknowns_.distances(there, selection_.points, context_.threads);
    for (std::size_t i = 0; i < away_.size(); ++i) {
      if (!away_[i] || std::abs(d.value[i] - selection_.here[i]) <= hardly * way) continue;
      away_[i] = 0, still_ -= kernel.loss(selection_.here[i] / noise_);
      if (!at_once) met_.push_back(selection_.points[i]);
    }
  }
};

/// How far along the way the cost is least, and the end there.
std::pair<double, OpenEnd> end_along(WayThrough& way, std::size_t parameter, double size) {
  constexpr double each = 9;  // nats at most for a point that is left outside
  constexpr int per_point = 2, outward = 30 * per_point, inward = int(hardly_any_points) * per_point;  // steps
  constexpr double lopsided = 3;
  const double here = way.cost(0), ten_points = here + each * double(hardly_any_points);
  const double up = way.until(1, ten_points), down = way.until(-1, ten_points);
  const double out = up > down ? 1 : -1, last = std::min(up, down);
  if (last > size) return {0, {parameter, size / 4, size, true}};
  // Where a size would become nothing no points say so.
  const bool by_domain = std::isinf(way.cost(-out * 1.05 * last));
  if (by_domain || std::max(up, down) < std::min(size, lopsided * last))
    return {0, {parameter, (way.until(1, here + objection) + way.until(-1, here + objection)) / 4, last, false}};
  const double step = last / inward;
  std::vector<double> costs;
  for (int k = -inward; k <= outward; ++k) costs.push_back(way.cost(out * k * step) + double(k) / per_point);
  const auto cost_at = [&](int k) { return costs[std::size_t(k + inward)]; };
  int best = int(std::min_element(costs.begin(), costs.end()) - costs.begin()) - inward;
  if (cost_at(0) - cost_at(best) < objection) best = 0;
  constexpr double nearly_all = 3;  // nats: 95 % of an exponential, three times its standard deviation
  int first = best, beyond = best;
  for (int k = -inward; k <= outward; ++k)
    if (cost_at(k) < cost_at(best) + nearly_all) first = std::min(first, k), beyond = std::max(beyond, k);
  return {out * best * step, {parameter, (beyond - first) * step / 3, last, true}};
}

}  // namespace

std::vector<OpenEnd> settle_open_ends(Candidate& candidate, const AllPoints& all, const Unknowns& unknowns,
                                      const std::vector<Vec3>& points, const FitInput& input, double noise,
                                      Context& context) {
  constexpr double mostly = 0.01;  // square of what is left of a number
  const int rounds = among_outliers(input) ? 1 : 4;
  std::vector<OpenEnd> result;
  if (input.closed) return result;
  // Noise throws so many of a wall's points beyond its end, as a share of all. There is none on a mesh; beside outliers
  // they may be these.
  const double thrown = among_outliers(input) || (input.scan && !input.scan->mesh.empty()) ? 0 : 0.01;
  const Matrix loose = hardly_fixed(all, thrown, context.threads);
  Selection selection{points, double(all.points.size()) / double(points.size()),
                      unknowns.distances(candidate, points, context.threads).value};
  for (std::size_t k = 0; k < unknowns.free_parameters().size(); ++k) {
    const std::size_t parameter = unknowns.free_parameters()[k];
    const Vector own = loose.row(static_cast<Eigen::Index>(k)).transpose();
    if (candidate.parameters[parameter].quantity != Quantity::length || own.squaredNorm() < mostly) continue;
    const Vector direction = loose * own / own.squaredNorm();  // the number itself by 1
    OpenEnd end;
    double moved = 0;
    for (int round = 0; round < rounds && (round == 0 || moved != 0);
         ++round) {  // from the end itself its last points are better known
      const Candidate start = candidate;
      WayThrough way(start, unknowns, direction, all, selection, noise, context);
      std::tie(moved, end) = end_along(way, parameter, unknowns.size());
      if (moved == 0 || among_outliers(input)) continue;  // with many outliers it would continue to those
      candidate = way.at(moved);
      selection.here = unknowns.distances(candidate, points, context.threads).value;
    }
    if (end.unlimited) end.sigma = std::max(end.sigma, 0.5 * input.thin_spacing / direction.cwiseAbs().maxCoeff());
    result.push_back(end);
  }
  return result;
}

}  // namespace partscribe::fit
