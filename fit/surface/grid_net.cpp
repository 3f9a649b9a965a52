#include "fit/surface/grid_net.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fit/surface/spline_fit.h"
#include "geometry/surfaces/cubic_basis.h"

namespace partscribe::fit {
namespace {

/// Means of `width` numbers a line.
std::vector<double> means(const GridSamples& at, std::span<const double> values, std::size_t width) {
  std::vector<double> result(at.count() * width, 0.0);
  for (std::size_t s = 0; s < at.count(); ++s)
    for (std::size_t i = at.begins[s]; i < at.begins[s] + at.window; ++i)
      for (std::size_t w = 0; w < width; ++w) result[s * width + w] += values[i * width + w];
  if (at.window > 1)
    for (double& x : result) x /= double(at.window);
  return result;
}

/// Some in each span of the knots, its first and last line among them, and those from `more` on.
GridSamples samples_in_spans(const std::vector<double>& lines, const KnotVector& knots, std::size_t window,
                             const std::vector<std::size_t>& more) {
  constexpr std::size_t in_a_span = 4;
  GridSamples result{more, window};
  const auto breaks = knots.breaks();
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const auto first = std::size_t(std::lower_bound(lines.begin(), lines.end(), breaks[k]) - lines.begin());
    const auto end = k + 2 == breaks.size()
                         ? lines.size()
                         : std::size_t(std::lower_bound(lines.begin(), lines.end(), breaks[k + 1]) - lines.begin());
    const std::size_t count = std::min(in_a_span, end - first);
    for (std::size_t n = 0; n < count; ++n) {
      const std::size_t line = first + (count > 1 ? n * (end - 1 - first) / (count - 1) : 0);
      result.begins.push_back(std::min(line - std::min(line, window / 2), lines.size() - window));
    }
  }
  std::sort(result.begins.begin(), result.begins.end());
  result.begins.erase(std::unique(result.begins.begin(), result.begins.end()), result.begins.end());
  return result;
}

std::vector<double> turned(std::span<const double> values, std::size_t rows, std::size_t columns, std::size_t width) {
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      for (std::size_t w = 0; w < width; ++w)
        result[(j * rows + i) * width + w] = values[(i * columns + j) * width + w];
  return result;
}

/// Sums of eighth powers, in eight lanes.
double eighths(const float* x, std::size_t count) {
  float lanes[8] = {};
  std::size_t i = 0;
  for (; i + 8 <= count; i += 8)
    for (std::size_t l = 0; l < 8; ++l) {
      const float x2 = x[i + l] * x[i + l], x4 = x2 * x2;
      lanes[l] += x4 * x4;
    }
  for (; i < count; ++i) {
    const float x2 = x[i] * x[i], x4 = x2 * x2;
    lanes[0] += x4 * x4;
  }
  return double((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + double((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}

std::vector<double> slopes(const KnotVector& knots, std::span<const double> controls, std::size_t width,
                           const std::vector<double>& at) {
  std::vector<double> result(at.size() * width, 0.0);
  CubicBasis n(knots);
  for (std::size_t s = 0; s < at.size(); ++s) {
    n.move_to(at[s]);
    const double* c = &controls[std::size_t(n.first) * width];
    for (std::size_t k = 0; k < 4; ++k, c += width)
      for (std::size_t w = 0; w < width; ++w) result[s * width + w] += n.slope[k] * c[w];
  }
  return result;
}

std::vector<double> mean_values(const LineBasis& basis, std::span<const double> controls, std::size_t width,
                                const GridSamples& at) {
  std::vector<double> result(at.count() * width, 0.0);
  for (std::size_t s = 0; s < at.count(); ++s)
    for (std::size_t i = at.begins[s]; i < at.begins[s] + at.window; ++i)
      basis.add_values(i, 1 / double(at.window), controls, std::span(result).subspan(s * width, width));
  return result;
}

GridNorm norm_of(const std::vector<float>& off) {
  float worst = 0;
  for (const float d : off) worst = std::max(worst, std::abs(d));
  return {worst, eighths(off.data(), off.size())};
}

}  // namespace

GridNet::GridNet(const SplineGrid& grid, const GridFitOptions& options)
    : grid_(grid), options_(options), lines_{&grid.u, &grid.v} {
  const double wanted = std::clamp(enough_to_average(options.noise, options.tolerance), 1.0, 30.0);
  const auto window = std::size_t(std::ceil(std::sqrt(wanted)));
  for (std::size_t d : {0u, 1u}) window_[d] = std::min(window, lines_[d]->size() / 4);
  split_components();
}

/// Components that are linear in the parameters are met by any net: only the others are fitted.
void GridNet::split_components() {
  const std::size_t nu = grid_.u.size(), nv = grid_.v.size();
  const double long_u = grid_.u.back() - grid_.u.front(), long_v = grid_.v.back() - grid_.v.front();
  origin_ = grid_.points.front();
  slope_[0] = (grid_.points[(nu - 1) * nv] - origin_) / long_u, slope_[1] = (grid_.points[nv - 1] - origin_) / long_v;
  for (int k = 0; k < 3; ++k) {
    double off = 0;
    for (std::size_t i = 0; i < nu; ++i)
      for (std::size_t j = 0; j < nv; ++j)
        off = std::max(off, std::abs(grid_.points[i * nv + j][k] - linear(grid_.u[i], grid_.v[j])[k]));
    if (off > 1e-6 * options_.tolerance) bent_.push_back(k);
  }
  if (bent_.empty()) bent_.push_back(2);
  width_ = bent_.size();
  data_[0].reserve(nu * nv * width_);
  for (std::size_t i = 0; i < nu; ++i)
    for (std::size_t j = 0; j < nv; ++j)
      for (const int k : bent_) data_[0].push_back(grid_.points[i * nv + j][k] - linear(grid_.u[i], grid_.v[j])[k]);
  data_[1] = turned(data_[0], nu, nv, width_);
}

Vec3 GridNet::linear(double u, double v) const {
  return origin_ + (u - grid_.u.front()) * slope_[0] + (v - grid_.v.front()) * slope_[1];
}

void GridNet::set(GridKnots knots) {
  for (std::size_t d : {0u, 1u}) {
    samples_[d] = samples_in_spans(*lines_[d], knots[d], window_[d], missed_[d]);
    basis_[d].emplace(*lines_[d], std::move(knots[d]));
    flat_[d].clear();
  }
  look();
}

/// The data in terms of the other direction's basis, along lines of this one: [line][other's control
/// value][component].
const std::vector<double>& GridNet::flat(std::size_t d) {
  if (flat_[d].empty()) {
    const LineBasis& other = *basis_[1 - d];
    const std::size_t lines = lines_[d]->size();
    flat_[d] = turned(other.nearest(data_[1 - d], lines * width_), other.count(), lines, width_);
  }
  return flat_[d];
}

/// Control values, [u][v][component].
std::vector<double> GridNet::net() { return basis_[0]->nearest(flat(0), basis_[1]->count() * width_); }

/// Means of distances along the net's normals over `allowed`, [v][u]; `weight`: what a change of the net does to
/// them.
std::vector<float> GridNet::distances_at(const std::array<GridSamples, 2>& at, double allowed,
                                         std::vector<float>& weight) {
  const std::size_t lines = grid_.u.size(), nu = at[0].count(), nv = at[1].count(), columns = basis_[1]->count();
  const auto mean_u = means(at[0], grid_.u, 1), mean_v = means(at[1], grid_.v, 1);
  const auto controls = net();
  const auto along = turned(mean_values(*basis_[0], controls, columns * width_, at[0]), nu, columns, width_);
  const auto found = mean_values(*basis_[1], along, nu * width_, at[1]);
  const auto slopes_v = slopes(basis_[1]->knots(), along, nu * width_, mean_v);
  const auto along_u = turned(slopes(basis_[0]->knots(), controls, columns * width_, mean_u), nu, columns, width_);
  const auto slopes_u = mean_values(*basis_[1], along_u, nu * width_, at[1]);
  std::vector<float> result(nu * nv);
  weight.resize(nu * nv * width_);
  for (std::size_t t = 0; t < nv; ++t) {
    const double* from = &data_[1][at[1].begins[t] * lines * width_];
    for (std::size_t s = 0; s < nu; ++s) {
      Vec3 du = slope_[0], dv = slope_[1];
      for (std::size_t k = 0; k < width_; ++k)
        du[bent_[k]] += slopes_u[(t * nu + s) * width_ + k], dv[bent_[k]] += slopes_v[(t * nu + s) * width_ + k];
      const Vec3 normal = du.cross(dv).normalized() / allowed;
      double sum = 0;
      for (std::size_t k = 0; k < width_; ++k) {
        double mean = 0;
        for (std::size_t j = 0; j < at[1].window; ++j)
          for (std::size_t i = 0; i < at[0].window; ++i) mean += from[(j * lines + at[0].begins[s] + i) * width_ + k];
        mean /= double(at[0].window * at[1].window);
        weight[(k * nv + t) * nu + s] = float(normal[bent_[k]]);
        sum += normal[bent_[k]] * (mean - found[(t * nu + s) * width_ + k]);
      }
      result[t * nu + s] = float(sum);
    }
  }
  return result;
}

void GridNet::look() {
  off_ = distances_at(samples_, options_.tolerance, weight_);
  norm_ = norm_of(off_);
}

double GridNet::look_at_all() {
  std::array<GridSamples, 2> at;
  for (std::size_t d : {0u, 1u}) {
    at[d].window = window_[d];
    for (std::size_t i = 0; i + window_[d] <= lines_[d]->size(); ++i) at[d].begins.push_back(i);
  }
  std::vector<float> weight;
  const auto off = distances_at(at, 1, weight);
  const std::size_t nu = at[0].count(), nv = at[1].count();
  std::array<std::vector<float>, 2> most = {std::vector<float>(nu), std::vector<float>(nv)};
  for (std::size_t t = 0; t < nv; ++t)
    for (std::size_t s = 0; s < nu; ++s) {
      const float d = std::abs(off[t * nu + s]);
      most[0][s] = std::max(most[0][s], d), most[1][t] = std::max(most[1][t], d);
    }
  for (std::size_t d : {0u, 1u})
    for (std::size_t i = 0; i < most[d].size(); ++i) {
      const bool highest =
          (i == 0 || most[d][i] >= most[d][i - 1]) && (i + 1 == most[d].size() || most[d][i] > most[d][i + 1]);
      if (highest && most[d][i] > options_.tolerance) missed_[d].push_back(i);
    }
  return *std::max_element(most[0].begin(), most[0].end());
}

NurbsSurface GridNet::surface() {
  NurbsSurface result{basis_[0]->knots(), basis_[1]->knots(), {}, {}};
  const auto controls = net();
  const auto mean = [](const KnotVector& t, std::size_t i) {
    return (t.knots[i + 1] + t.knots[i + 2] + t.knots[i + 3]) / 3;
  };
  std::size_t next = 0;
  for (std::size_t i = 0; i < basis_[0]->count(); ++i)
    for (std::size_t j = 0; j < basis_[1]->count(); ++j) {
      Vec3 p = linear(mean(result.u, i), mean(result.v, j));
      for (const int k : bent_) p[k] += controls[next++];
      result.points.push_back(p);
    }
  return result;
}

bool GridNet::held(std::size_t d, double low, double high) const {
  const auto& lines = *lines_[d];
  return std::lower_bound(lines.begin(), lines.end(), high) - std::lower_bound(lines.begin(), lines.end(), low) >= 1;
}

GridChange GridNet::change_of(std::size_t d, const KnotVector& knots, double t) {
  return change_of(d, LineBasis(*lines_[d], knots, *basis_[d]), t);
}

GridChange GridNet::change_of(std::size_t d, const LineBasis& basis, double t) {
  const auto share = basis.share_of(t);
  const std::size_t other = basis_[1 - d]->count() * width_;
  std::vector<double> across(other, 0.0);
  for (std::size_t i = share.begin; i < share.end; ++i) {
    const double* from = &flat(d)[i * other];
    for (std::size_t w = 0; w < other; ++w) across[w] += share.values[i - share.begin] * from[w];
  }
  GridChange result;
  const GridSamples& at = samples_[d];
  const auto begins = [&](std::size_t line) {
    return std::size_t(std::lower_bound(at.begins.begin(), at.begins.end(), line) - at.begins.begin());
  };
  result.begin = begins(share.begin < at.window ? 0 : share.begin - at.window + 1);
  const std::size_t end = begins(share.end);
  result.along.reserve(end - result.begin);
  for (std::size_t s = result.begin; s < end; ++s) {
    double sum = 0;
    for (std::size_t i = std::max(at.begins[s], share.begin); i < std::min(at.begins[s] + at.window, share.end); ++i)
      sum += share.values[i - share.begin];
    result.along.push_back(float(sum / double(at.window)));
    result.size = std::max(result.size, std::abs(double(result.along.back())));
  }
  const auto means = mean_values(*basis_[1 - d], across, width_, samples_[1 - d]);
  double most = 0;
  result.across.reserve(means.size());
  for (std::size_t k = 0; k < width_; ++k)
    for (std::size_t t = 0; t < samples_[1 - d].count(); ++t) {
      const double x = means[t * width_ + k];
      most = std::max(most, std::abs(x)), result.energy += x * x;
      result.across.push_back(float(x));
    }
  result.size *= most;
  return result;
}

/// Goes through the rows of samples that changes reach: `visit(first sample, by)` with the changes of the distances.
template <class Visit>
void GridNet::through(std::size_t d, std::span<const GridChange> changes, const Visit& visit) const {
  const std::size_t nu = samples_[0].count(), nv = samples_[1].count();
  std::size_t begin = changes[0].begin, end = changes[0].end();
  for (const GridChange& c : changes) begin = std::min(begin, c.begin), end = std::max(end, c.end());
  const std::size_t from = d == 0 ? begin : 0, count = d == 0 ? end - begin : nu;
  std::vector<float> by(count);
  for (std::size_t t = d == 0 ? 0 : begin; t < (d == 0 ? nv : end); ++t) {
    std::fill(by.begin(), by.end(), 0.0f);
    for (const GridChange& c : changes)
      for (std::size_t k = 0; k < width_; ++k) {
        const float* weight = &weight_[(k * nv + t) * nu];
        const float sign = float(c.sign);
        if (d == 0) {
          const float y = sign * c.across[k * nv + t];
          for (std::size_t s = 0; s < c.along.size(); ++s)
            by[c.begin - begin + s] += y * c.along[s] * weight[c.begin + s];
        } else if (t >= c.begin && t < c.end()) {
          const float y = sign * c.along[t - c.begin];
          const float* x = &c.across[k * nu];
          for (std::size_t s = 0; s < nu; ++s) by[s] += y * x[s] * weight[s];
        }
      }
    visit(t * nu + from, by);
  }
}

/// The norm's sum after changes.
double GridNet::sum_after(std::size_t d, std::span<const GridChange> changes) const {
  double sum = norm_.sum;
  through(d, changes, [&](std::size_t at, std::vector<float>& by) {
    sum -= eighths(&off_[at], by.size());
    for (std::size_t s = 0; s < by.size(); ++s) by[s] += off_[at + s];
    sum += eighths(by.data(), by.size());
  });
  return sum;
}

std::vector<float> GridNet::after(std::size_t d, std::span<const GridChange> changes) const {
  std::vector<float> off = off_;
  through(d, changes, [&](std::size_t at, const std::vector<float>& by) {
    for (std::size_t s = 0; s < by.size(); ++s) off[at + s] += by[s];
  });
  return off;
}

void GridNet::take_over(std::size_t d, LineBasis&& basis, std::vector<float>&& off, const GridNorm& norm) {
  basis_[d].emplace(std::move(basis));
  flat_[1 - d].clear();
  off_ = std::move(off), norm_ = norm;
}

void GridNet::restore(const State& state) {
  for (std::size_t d : {0u, 1u})
    if (basis_[d]->knots() != state.knots[d]) {
      basis_[d].emplace(*lines_[d], state.knots[d]);
      flat_[1 - d].clear();
    }
  off_ = state.off, norm_ = state.norm;
}

bool GridNet::take_out(std::size_t d, double t, double most) {
  const GridChange gone = change_of(d, t);
  auto off = after(d, {&gone, 1});
  const GridNorm norm = norm_of(off);
  if (norm.worst > most) return false;
  take_over(d, LineBasis(*lines_[d], without_one(basis_[d]->knots(), t)), std::move(off), norm);
  return true;
}

bool GridNet::move(std::size_t d, double t, double by) {
  const auto breaks = basis_[d]->knots().breaks();
  const auto at = std::find(breaks.begin(), breaks.end(), t);
  const double low = *(at - 1), high = *(at + 1);
  GridChange changes[2] = {change_of(d, *basis_[d], t), {}};
  const KnotVector fewer = without_one(basis_[d]->knots(), t);
  for (const double side : {by, -by}) {
    const double to = side > 0 ? t + side * (high - t) : t + side * (t - low);
    if (!held(d, low, to) || !held(d, to, high)) continue;
    LineBasis basis(*lines_[d], with_knot(fewer, to), *basis_[d]);
    changes[1] = change_of(d, basis, to), changes[1].sign = -1;
    if (!(sum_after(d, changes) < 0.999 * norm_.sum)) continue;
    auto off = after(d, changes);
    const GridNorm norm = norm_of(off);
    take_over(d, std::move(basis), std::move(off), norm);
    return true;
  }
  return false;
}

}  // namespace partscribe::fit
