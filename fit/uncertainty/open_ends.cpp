#include "fit/uncertainty/open_ends.h"

#include <algorithm>
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

/// The cost along one direction in the unknowns.
class WayThrough {
 public:
  WayThrough(const Candidate& candidate, const Unknowns& unknowns, const Vector& direction,
             const std::vector<Vec3>& points, double noise, double points_each, Context& context)
      : candidate_(candidate),
        unknowns_(unknowns),
        direction_(direction),
        points_(points),
        noise_(noise),
        points_each_(points_each),
        context_(context) {}

  /// Nats.
  double cost(double way) const {
    const Candidate moved = at(way);
    if (!unknowns_.sensible(moved)) return std::numeric_limits<double>::infinity();
    double sum = 0;
    for (const double d : unknowns_.distances(moved, points_, context_.threads).value) sum += kernel.loss(d / noise_);
    return points_each_ * sum;
  }

  Candidate at(double way) const { return unknowns_.stepped(candidate_, way * direction_); }

  /// How far it may go, to one side, before the cost reaches `most`; more than the part's size if it never does.
  double until(double side, double most) const {
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
  const Candidate& candidate_;
  const Unknowns& unknowns_;
  Vector direction_;
  const std::vector<Vec3>& points_;
  double noise_, points_each_;
  Context& context_;
};

/// How far along the way the cost is least, and the end there.
std::pair<double, OpenEnd> end_along(const WayThrough& way, std::size_t parameter, double size) {
  constexpr double each = 9;  // nats at most for a point that is left outside
  constexpr int per_point = 2, outward = 30 * per_point, inward = int(hardly_any_points) * per_point;  // steps
  constexpr double lopsided = 3;
  const double here = way.cost(0), ten_points = here + each * double(hardly_any_points);
  const double up = way.until(1, ten_points), down = way.until(-1, ten_points);
  const double out = up > down ? 1 : -1, last = std::min(up, down);
  if (last > size) return {0, {parameter, size / 4, size, true}};
  if (std::max(up, down) < std::min(size, lopsided * last))
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
  const double points_each = double(all.points.size()) / double(points.size());
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
      const WayThrough way(start, unknowns, direction, points, noise, points_each, context);
      std::tie(moved, end) = end_along(way, parameter, unknowns.size());
      if (moved != 0 && !among_outliers(input))
        candidate = way.at(moved);  // with many outliers it would continue to those
    }
    if (end.unlimited) end.sigma = std::max(end.sigma, 0.5 * input.thin_spacing / direction.cwiseAbs().maxCoeff());
    result.push_back(end);
  }
  return result;
}

}  // namespace partscribe::fit
