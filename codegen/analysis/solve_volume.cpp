#include "codegen/analysis/solve_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/ensure.h"
#include "core/number.h"

namespace partscribe::codegen {
namespace {

// Of the volume: below what a number of ten digits says of it, and above the rounding of its integrals.
constexpr double volume_accuracy = 1e-9;
// The rounded value keeps the volume within this share.
constexpr double rounding_share = 1e-6;
constexpr int most_builds = 200;

const Parameter* parameter_called(const Model& model, const std::string& name) {
  for (const Parameter& p : model.parameters)
    if (p.name == name) return &p;
  return nullptr;
}

struct VolumeAt {
  double value = 0, excess = 0;  ///< mm^3 above what is wished
};

class VolumeSearch {
 public:
  VolumeSearch(const CheckedModel& model, const Parameter& parameter, double wished, Context& context)
      : model_(model), parameter_(parameter), wished_(wished), context_(context) {
    result_.least = std::numeric_limits<double>::infinity();
  }

  Result<SolvedVolume> run() {
    const auto here = at(parameter_.value);
    if (!here) return stopped_ ? *stopped_ : bad_input(result_.limit);
    result_.limit.clear();
    if (std::abs(here->excess) <= volume_accuracy * wished_) return answer(*here, false);
    const double size = parameter_.quantity == Quantity::length ? std::cbrt(here->excess + wished_) : 1;
    step_ = 0.05 * std::max(std::abs(parameter_.value), 0.2 * size);
    furthest_ = 100 * (std::abs(parameter_.value) + size);
    const auto near = at(parameter_.value + 1e-3 * step_);
    if (stopped_) return *stopped_;
    const bool rises = !near || (near->excess - here->excess) * here->excess < 0;
    for (const double direction : {rises ? 1.0 : -1.0, rises ? -1.0 : 1.0}) {
      const auto bracket = walked(*here, direction);
      if (stopped_) return *stopped_;
      if (!bracket) continue;
      const auto root = between(bracket->first, bracket->second);
      if (stopped_) return *stopped_;
      if (root && std::abs(root->excess) <= rounding_share * wished_)
        return answer(*root, true,
                      std::abs((bracket->second.excess - bracket->first.excess) /
                               (bracket->second.value - bracket->first.value)));
      result_.limit = "the volume jumps near " + print_number(snapped(bracket->first.value, 1e-6));
    }
    result_.value = nearest_.value, result_.volume = nearest_.excess + wished_;
    return result_;
  }

 private:
  std::optional<VolumeAt> at(double value) {
    ++result_.builds;
    const auto changed = with_value(model_, parameter_.name, value);
    if (!changed) return failed(changed.error());
    const auto body = mass_properties(*changed, context_);
    if (!body.ok()) return failed(body.error());
    const VolumeAt found{value, body->volume - wished_};
    if (!any_ || std::abs(found.excess) < std::abs(nearest_.excess)) nearest_ = found;
    result_.low = any_ ? std::min(result_.low, value) : value;
    result_.high = any_ ? std::max(result_.high, value) : value;
    result_.least = std::min(result_.least, body->volume), result_.most = std::max(result_.most, body->volume);
    any_ = true;
    return found;
  }

  std::optional<VolumeAt> failed(const Error& error) {
    if (error.kind == ErrorKind::stopped) stopped_ = error;
    result_.limit = error.message;
    return std::nullopt;
  }

  /// Two values between which the volume passes the one that is wished.
  std::optional<std::pair<VolumeAt, VolumeAt>> walked(const VolumeAt& from, double direction) {
    VolumeAt last = from;
    for (double step = step_; step > 1e-4 * step_ && std::abs(last.value - from.value) < furthest_;) {
      if (stopped_ || result_.builds > most_builds) return std::nullopt;
      const auto next = at(last.value + direction * step);
      if (!next) {
        step /= 4;
        continue;
      }
      if ((next->excess > 0) != (last.excess > 0)) return std::pair(last, *next);
      last = *next, step *= 1.6;
    }
    return std::nullopt;
  }

  /// Regula falsi that halves the weight of an end that stays twice. A value at which nothing can be built ends it.
  std::optional<VolumeAt> between(VolumeAt a, VolumeAt b) {
    double weight_a = a.excess, weight_b = b.excess;
    int stays = 0;  // the end that did not move last time
    VolumeAt best = std::abs(a.excess) < std::abs(b.excess) ? a : b;
    for (int round = 0; round < 80 && std::abs(best.excess) > volume_accuracy * wished_; ++round) {
      if (std::abs(b.value - a.value) <= 1e-12 * (std::abs(a.value) + std::abs(b.value))) break;
      double middle = (a.value * weight_b - b.value * weight_a) / (weight_b - weight_a);
      const double low = std::min(a.value, b.value), high = std::max(a.value, b.value);
      if (!(middle > low && middle < high)) middle = (a.value + b.value) / 2;
      const auto found = at(middle);
      if (!found) return std::nullopt;
      if (std::abs(found->excess) < std::abs(best.excess)) best = *found;
      if ((found->excess > 0) == (a.excess > 0)) {
        a = *found, weight_a = a.excess;
        if (stays == 2) weight_b /= 2;
        stays = 2;
      } else {
        b = *found, weight_b = b.excess;
        if (stays == 1) weight_a /= 2;
        stays = 1;
      }
    }
    return best;
  }

  /// The value as it is to be printed, and what the model of that value has.
  Result<SolvedVolume> answer(VolumeAt root, bool moved, double slope = 0) {
    if (moved) {
      const double resolution =
          power_of_ten_below(std::clamp(rounding_share * wished_ / std::max(slope, 1e-300), 1e-9, 1e-3));
      const bool angle = parameter_.quantity == Quantity::angle;
      const double rounded =
          angle ? radians(snapped(degrees(root.value), resolution)) : snapped(root.value, resolution);
      if (const auto printed = at(rounded)) root = *printed;
      if (stopped_) return *stopped_;
    }
    result_.found = true, result_.limit.clear();
    result_.value = root.value, result_.volume = root.excess + wished_;
    return result_;
  }

  const CheckedModel& model_;
  const Parameter& parameter_;
  double wished_;
  Context& context_;
  SolvedVolume result_;
  VolumeAt nearest_;
  bool any_ = false;
  double step_ = 0, furthest_ = 0;
  std::optional<Error> stopped_;
};

}  // namespace

Result<Done> check_solvable(const CheckedModel& model, const std::string& name) {
  const Parameter* parameter = parameter_called(*model, name);
  // Also says what is wrong with a name.
  if (const auto same = with_value(model, name, parameter ? parameter->value : 0); !same) return same.error();
  if (parameter->quantity == Quantity::count)
    return usage_error("parameter '" + name + "' is a count: it takes whole numbers, and no volume in between");
  return Done{};
}

Result<SolvedVolume> solve_volume(const CheckedModel& model, const std::string& name, double volume, Context& context) {
  ensure(volume > 0, "a body has a volume");
  if (const auto ok = check_solvable(model, name); !ok) return ok.error();
  return VolumeSearch(model, *parameter_called(*model, name), volume, context).run();
}

}  // namespace partscribe::codegen
