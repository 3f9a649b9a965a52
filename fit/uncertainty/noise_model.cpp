#include "fit/uncertainty/noise_model.h"

#include <algorithm>
#include <cmath>

#include "fit/refine/normal_equations.h"

namespace partscribe::fit {
namespace {

constexpr int incidence_bins = 8;
constexpr std::size_t least_points = 30;
constexpr double widest_factor = 5;

/// Factors of the classes, given residuals that should have unit scale. Classes too small to tell get 1.
std::vector<double> factors(const std::vector<double>& unit, const std::vector<int>& cls, int count,
                            const std::vector<char>& told) {
  std::vector<std::vector<double>> members(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < unit.size(); ++i)
    if (told.empty() || told[i]) members[static_cast<std::size_t>(cls[i])].push_back(unit[i]);
  std::vector<double> log_scale(members.size(), 0), variance(members.size(), 0);
  double weights = 0, excess = 0;
  for (std::size_t g = 0; g < members.size(); ++g) {
    if (members[g].size() < least_points) continue;
    const double scale = robust_scale(members[g]);
    if (!(scale > 0)) continue;
    log_scale[g] = std::log(scale);
    variance[g] = 0.6 / double(members[g].size());  // of the logarithm of a trimmed scale; 0.5 for the best estimator
    weights += double(members[g].size());
    excess += double(members[g].size()) * (log_scale[g] * log_scale[g] - variance[g]);
  }
  std::vector<double> result(members.size(), 1);
  const double spread = weights > 0 ? std::max(excess / weights, 0.0) : 0;
  for (std::size_t g = 0; g < members.size(); ++g)
    if (variance[g] > 0) result[g] = std::exp(log_scale[g] * spread / (spread + variance[g]));
  return result;
}

}  // namespace

std::vector<double> noise_of_points(const std::vector<double>& residuals, const NoiseTraits& traits, double least) {
  const std::size_t n = residuals.size();
  std::vector<double> sigma(n, 1);
  if (traits.relative.size() == n) {
    // Numbers without spread carry no information.
    sigma = traits.relative;
    for (auto& s : sigma) s = s > 0 ? s : 1;
  }
  auto unit = [&] {
    std::vector<double> u(n);
    for (std::size_t i = 0; i < n; ++i) u[i] = residuals[i] / sigma[i];
    return u;
  };
  const auto of_told = [&](std::vector<double> values) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (traits.told.empty() || traits.told[i]) values[kept++] = values[i];
    values.resize(kept);
    return values;
  };
  auto rescale = [&] {
    const double scale = robust_scale(of_told(unit()));
    for (auto& s : sigma) s *= scale > 0 ? scale : 1;
  };
  rescale();
  auto apply = [&](const std::vector<int>& cls, int count) {
    const auto factor = factors(unit(), cls, count, traits.told);
    for (std::size_t i = 0; i < n; ++i) sigma[i] *= factor[static_cast<std::size_t>(cls[i])];
  };
  std::vector<int> bin;
  if (traits.cosine.size() == n)
    for (const double c : traits.cosine)
      bin.push_back(std::clamp(static_cast<int>(c * incidence_bins), 0, incidence_bins - 1));
  std::vector<int> face = traits.face;
  int faces = 0;
  for (auto& f : face) f = std::max(f, 0), faces = std::max(faces, f + 1);
  const bool grouped = traits.group.size() == n && traits.group_count > 1;
  for (int round = 0; round < 2; ++round) {
    if (grouped) apply(traits.group, traits.group_count);
    if (faces > 1 && face.size() == n) apply(face, faces);
    if (!bin.empty()) apply(bin, incidence_bins);
  }
  rescale();
  const double overall = robust_scale(of_told(residuals));
  for (auto& s : sigma) s = std::max(std::clamp(s, overall / widest_factor, overall * widest_factor), least);
  return sigma;
}

}  // namespace partscribe::fit
