#include "fit/refine.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/parallel.h"
#include "model/distance.h"

namespace partscribe {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr int jackknife_groups = 8;

/// The normal equations of one block of points, and of each jackknife group in it.
struct Normal {
  Matrix h;
  Vector g;
  std::vector<Matrix> group_h;
  std::vector<Vector> group_g;
};

class Problem {
 public:
  Problem(Candidate& candidate, const FitInput& input, const RefineOptions& options, Context& context)
      : candidate_(candidate), input_(input), options_(options), context_(context) {
    const std::set<std::string> fixed(options.fixed.begin(), options.fixed.end());
    for (std::size_t i = 0; i < candidate.parameters.size(); ++i)
      if (candidate.parameters[i].quantity != Quantity::count && !fixed.count(candidate.parameters[i].name))
        free_.push_back(i);
    const std::size_t count = input.cloud.size(),
                      step = std::max<std::size_t>(
                          1, (count + options.points - 1) / std::max<std::size_t>(options.points, 1));
    for (std::size_t i = 0; i < count; i += step) chosen_.push_back(i);
    center_ = input.bounds.center();
    size_ = std::max(0.5 * input.bounds.diagonal(), 1e-9);
    model_ = bare_model(candidate);
    find_limits();
    assign_groups();
  }

  std::size_t unknowns() const { return free_.size() + 6; }
  const std::vector<std::size_t>& free_parameters() const { return free_; }
  std::size_t point_count() const { return chosen_.size(); }

  Values values(const Candidate& c) const {
    Values v;
    for (const auto& p : c.parameters) v[p.name] = p.value;
    return v;
  }

  /// Signed distances of the chosen points.
  std::vector<double> distances(const Candidate& c) const {
    const ModelDistance distance(model_, values(c));
    const Pose part_from_scan = c.scan_from_part.inverse();
    std::vector<double> d(chosen_.size());
    parallel_for(chosen_.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        d[i] = distance(part_from_scan * input_.cloud.points[chosen_[i]]).distance;
    });
    return d;
  }

  /// d(distance)/d(unknown), one column per unknown: parameters, shift (in scan axes), turn about the scan's centre
  /// (times size, so that all columns are lengths per length).
  Matrix jacobian(const Candidate& c, const std::vector<double>& d) const {
    Matrix j(chosen_.size(), unknowns());
    const Values base = values(c);
    const Pose part_from_scan = c.scan_from_part.inverse();
    const double h = 1e-6 * size_;
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const auto& p = candidate_.parameters[free_[k]];
      double step = p.quantity == Quantity::length ? h : 1e-6;
      if (const auto limit = limits_.find(p.name);
          limit != limits_.end() && base.at(p.name) + step > limit->second.second)
        step = -step;
      Values shifted = base;
      shifted[p.name] += step;
      const ModelDistance above(model_, shifted);
      parallel_for(chosen_.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3 q = part_from_scan * input_.cloud.points[chosen_[i]];
          j(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = (above(q).distance - d[i]) / step;
        }
      });
    }
    const ModelDistance distance(model_, base);
    const auto first = static_cast<Eigen::Index>(free_.size());
    parallel_for(chosen_.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Vec3& p = input_.cloud.points[chosen_[i]];
        const Vec3 q = part_from_scan * p;
        Vec3 gradient;
        for (int a = 0; a < 3; ++a) {
          gradient[a] = (distance(q + Vec3::Unit(a) * h).distance - d[i]) / h;
        }
        gradient = c.scan_from_part.rotation * gradient;
        const auto row = static_cast<Eigen::Index>(i);
        j.block<1, 3>(row, first) = -gradient.transpose();
        j.block<1, 3>(row, first + 3) = -((p - center_).cross(gradient)).transpose() / size_;
      }
    });
    // Half-spaces move with their offsets: shifting the frame as well would say the same twice.
    if (std::holds_alternative<HalfSpaces>(candidate_.shape)) j.middleCols(first, 3).setZero();
    return j;
  }

  double weight(double d, double scale) const {
    const double u = d / (options_.welsch * scale);
    return std::exp(-u * u / 2);
  }
  double loss(double d, double scale) const {
    const double c = options_.welsch * scale, u = d / c;
    return c * c * (1 - std::exp(-u * u / 2));
  }

  Normal normal_equations(const Matrix& j, const std::vector<double>& d, double scale, bool groups) const {
    // Summed block by block in index order: the same bits for any number of threads.
    constexpr std::size_t block = 512;
    const std::size_t blocks = (d.size() + block - 1) / block;
    const auto n = static_cast<Eigen::Index>(unknowns());
    std::vector<Normal> parts(blocks);
    parallel_for(
        blocks, context_.threads,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t b = begin; b < end; ++b) {
            Normal& part = parts[b];
            part.h = Matrix::Zero(n, n), part.g = Vector::Zero(n);
            if (groups) part.group_h.assign(jackknife_groups, part.h), part.group_g.assign(jackknife_groups, part.g);
            for (std::size_t i = b * block; i < std::min(d.size(), (b + 1) * block); ++i) {
              const double w = weight(d[i], scale);
              const Vector row = j.row(static_cast<Eigen::Index>(i)).transpose();
              Matrix& h = groups ? part.group_h[group_[i]] : part.h;
              Vector& g = groups ? part.group_g[group_[i]] : part.g;
              h.selfadjointView<Eigen::Lower>().rankUpdate(row, w);
              g += w * d[i] * row;
            }
          }
        },
        4);
    Normal sum;
    sum.h = Matrix::Zero(n, n), sum.g = Vector::Zero(n);
    if (groups) sum.group_h.assign(jackknife_groups, sum.h), sum.group_g.assign(jackknife_groups, sum.g);
    for (const auto& part : parts) {
      sum.h += part.h, sum.g += part.g;
      if (groups)
        for (int k = 0; k < jackknife_groups; ++k) sum.group_h[k] += part.group_h[k], sum.group_g[k] += part.group_g[k];
    }
    auto complete = [](Matrix& h) { h = Matrix(h.selfadjointView<Eigen::Lower>()); };
    if (groups)
      for (int k = 0; k < jackknife_groups; ++k) {
        complete(sum.group_h[k]);
        sum.h += sum.group_h[k], sum.g += sum.group_g[k];
      }
    else
      complete(sum.h);
    return sum;
  }

  double cost(const std::vector<double>& d, double scale) const {
    double sum = 0;
    for (const double v : d) sum += loss(v, scale);
    return sum;
  }

  Candidate stepped(const Candidate& c, const Vector& step) const {
    Candidate next = c;
    for (std::size_t k = 0; k < free_.size(); ++k) {
      auto& p = next.parameters[free_[k]];
      p.value += step[static_cast<Eigen::Index>(k)];
      if (const auto limit = limits_.find(p.name); limit != limits_.end())
        p.value = std::clamp(p.value, limit->second.first, limit->second.second);
    }
    const auto first = static_cast<Eigen::Index>(free_.size());
    const Vec3 shift = step.segment<3>(first), turn = step.segment<3>(first + 3) / size_;
    const Mat3 r = rotation_of(turn);
    next.scan_from_part.rotation = r * c.scan_from_part.rotation;
    next.scan_from_part.translation = r * (c.scan_from_part.translation - center_) + center_ + shift;
    return next;
  }

  double size() const { return size_; }

  /// False after a step that turned a size negative.
  bool sensible(const Candidate& c) const {
    const Values v = values(c);
    bool all = true;
    visit_expressions(c.shape, [&](const Expr& e, Domain domain) {
      if (domain == Domain::length) all = all && evaluate(e, v) > 0;
      if (domain == Domain::length_or_zero) all = all && evaluate(e, v) >= 0;
    });
    return all;
  }

 private:
  /// Exponents and tapers stop at the ends of their domains: a box lies there, and the other parameters go on.
  void find_limits() {
    visit_expressions(candidate_.shape, [&](const Expr& e, Domain domain) {
      if (!e.is_parameter()) return;
      if (domain == Domain::exponent) limits_[e.parameter] = {0.1, 2.0};
      if (domain == Domain::taper) limits_[e.parameter] = {-0.95, 0.95};
    });
  }

  void assign_groups() {
    group_.resize(chosen_.size());
    std::set<int> views;
    const auto& view = input_.cloud.view;
    for (const auto v : view) views.insert(v);
    // Views err together; with few of them regions must do: octants about the centre.
    const bool by_view = views.size() >= 4;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Vec3 d = input_.cloud.points[chosen_[i]] - center_;
      group_[i] = by_view ? view[chosen_[i]] % jackknife_groups : (d.x() > 0) + 2 * (d.y() > 0) + 4 * (d.z() > 0);
    }
  }

  Candidate& candidate_;
  const FitInput& input_;
  const RefineOptions& options_;
  Context& context_;
  Model model_;
  std::vector<std::size_t> free_, chosen_;
  std::vector<int> group_;
  std::map<std::string, std::pair<double, double>> limits_;
  Vec3 center_;
  double size_;
};

/// Inverse of a symmetric matrix without its free directions.
Matrix pseudo_inverse(const Matrix& h) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(h);
  const double cut = 1e-9 * std::max(h.trace() / double(h.rows()), 1e-300);
  Vector inverse = eigen.eigenvalues();
  for (auto& v : inverse) v = v > cut ? 1 / v : 0;
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

double robust_scale(std::vector<double> d) {
  for (auto& v : d) v = std::abs(v);
  const auto middle = d.begin() + static_cast<std::ptrdiff_t>(d.size() / 2);
  std::nth_element(d.begin(), middle, d.end());
  return 1.4826 * *middle;
}

}  // namespace

Model bare_model(const Candidate& candidate) {
  Model model;
  model.parameters = candidate.parameters;
  model.objects.push_back({candidate.object_name, candidate.shape, {}, {}, {}});
  model.as_scanned = false;
  return model;
}

RefineReport refine(Candidate& candidate, const FitInput& input, const RefineOptions& options, Context& context) {
  RefineReport report;
  Problem problem(candidate, input, options, context);
  if (problem.point_count() < problem.unknowns()) return report;
  const double noise = std::max(input.sampling.sigma, 1e-7 * problem.size());

  Candidate best = candidate;
  std::vector<double> d = problem.distances(best);
  double scale = std::max(robust_scale(d), noise);
  double lambda = 1e-6;
  for (; report.iterations < options.iterations && !context.cancelled; ++report.iterations) {
    const Matrix j = problem.jacobian(best, d);
    const Normal normal = problem.normal_equations(j, d, scale, false);
    const double before = problem.cost(d, scale);
    bool improved = false;
    double largest = 0;
    for (int attempt = 0; attempt < 8 && !improved; ++attempt) {
      Matrix damped = normal.h;
      const double trace = normal.h.trace() / double(normal.h.rows());
      for (Eigen::Index k = 0; k < damped.rows(); ++k) damped(k, k) += lambda * (normal.h(k, k) + 1e-6 * trace);
      const Vector step = -pseudo_inverse(damped) * normal.g;
      const auto turn = static_cast<Eigen::Index>(problem.free_parameters().size()) + 3;
      if (step.segment<3>(turn).norm() > 0.5 * problem.size()) {
        lambda = std::max(lambda * 10, 1e-3);
        continue;
      }
      Candidate next = problem.stepped(best, step);
      if (!problem.sensible(next)) {
        lambda = std::max(lambda * 10, 1e-3);
        continue;
      }
      std::vector<double> next_d = problem.distances(next);
      if (problem.cost(next_d, scale) <= before * (1 + 1e-12)) {
        improved = true;
        largest = step.cwiseAbs().maxCoeff();
        best = std::move(next);
        d = std::move(next_d);
        lambda = std::max(lambda * 0.1, 1e-9);
      } else {
        lambda *= 10;
      }
    }
    const double new_scale = std::max(robust_scale(d), noise);
    const bool scale_settled = new_scale > 0.97 * scale;
    scale = std::min(scale, new_scale);
    if (!improved || (largest < 1e-7 * problem.size() && scale_settled)) {
      report.converged = true;
      break;
    }
  }
  candidate = std::move(best);

  double sum = 0, weights = 0;
  std::size_t inliers = 0;
  for (const double v : d) {
    const double w = problem.weight(v, scale);
    sum += w * v * v, weights += w;
    inliers += std::abs(v) < 4 * scale;
  }
  // The weighted square underestimates a Gaussian's by (1 + 1/c^2)^(-1); undo it.
  report.rms = std::sqrt(sum / std::max(weights, 1e-300) * (1 + 1 / (options.welsch * options.welsch)));
  report.inlier_share = double(inliers) / double(d.size());

  for (auto& p : candidate.parameters)
    p.fitted = p.value, p.sigma = p.sigma_noise = p.sigma_systematic = 0, p.points = 0;
  if (!options.uncertainty) return report;
  const Matrix j = problem.jacobian(candidate, d);
  const Normal normal = problem.normal_equations(j, d, scale, true);
  const double sigma_point = std::max(report.rms, noise);
  const Matrix covariance = pseudo_inverse(normal.h) * sigma_point * sigma_point;
  std::vector<Vector> shifts;
  for (int k = 0; k < jackknife_groups; ++k) {
    const Matrix rest = normal.h - normal.group_h[k];
    // One step from the common solution to that without the group; a group that alone holds a direction tells nothing.
    if (normal.group_h[k].trace() > 0) shifts.push_back(-pseudo_inverse(rest) * (normal.g - normal.group_g[k]));
  }
  // Facets of a source mesh, filters and registration do not average out; a tenth of the noise is their usual size.
  const double floor = 0.1 * noise;
  const auto& free = problem.free_parameters();
  for (std::size_t k = 0; k < free.size(); ++k) {
    auto& p = candidate.parameters[free[k]];
    const auto column = static_cast<Eigen::Index>(k);
    p.sigma_noise = std::sqrt(std::max(covariance(column, column), 0.0));
    double mean = 0, spread = 0;
    for (const auto& s : shifts) mean += s[column] / double(shifts.size());
    for (const auto& s : shifts) spread += (s[column] - mean) * (s[column] - mean);
    const double jackknife = shifts.empty() ? 0 : std::sqrt(spread * double(shifts.size() - 1) / double(shifts.size()));
    const double unit = p.quantity == Quantity::length ? floor : floor / problem.size();
    p.sigma_systematic = std::hypot(jackknife, unit);
    p.sigma = std::hypot(p.sigma_noise, p.sigma_systematic);
    for (std::size_t i = 0; i < d.size(); ++i)
      p.points += std::abs(j(static_cast<Eigen::Index>(i), column)) > 0.1 && std::abs(d[i]) < 4 * scale;
  }
  return report;
}

}  // namespace partscribe
