#include "fit/refine/nominal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/number.h"

namespace partscribe::fit {
namespace {

constexpr double inch = 25.4;
constexpr double drilled = 0.4;  // share of round holes that come from the tables of drills and threads
constexpr double least_probability = 0.9, z_limit = 2.6;
constexpr double z_reported = 20;  // beyond it a round value is not even a near miss

/// How a designer chooses sizes: a system and the step that most of them are multiples of, in mm.
struct Habit {
  bool metric = true;
  double step = 1;
  double prior = 0;
};
constexpr Habit habits[] = {{true, 5, 0.15},          {true, 1, 0.35},          {true, 0.5, 0.2},
                            {true, 0.1, 0.1},         {false, inch / 8, 0.06},  {false, inch / 16, 0.05},
                            {false, inch / 32, 0.03}, {false, inch / 64, 0.03}, {false, inch / 20, 0.03}};
constexpr double habitual = 0.6;  // share of nominal sizes that are multiples of the habit's step

/// A value of a series near to a measured one.
struct Hit {
  double value = 0;    ///< mm or rad, in the parameter's own measure (half of a diameter)
  double spacing = 0;  ///< of the series there, likewise
  double weight = 0;   ///< prior share of the series among the nominal values
  std::string series;
};

struct Named {
  double mm;
  const char* what;
};

// ISO 273 clearance holes and ISO 2306 tap drills of coarse threads.
constexpr Named metric_holes[] = {
    {1.6, "tap drill of M2"},           {1.7, "clearance of M1.6, fine"},   {1.8, "clearance of M1.6, medium"},
    {2.05, "tap drill of M2.5"},        {2.2, "clearance of M2, fine"},     {2.4, "clearance of M2, medium"},
    {2.5, "tap drill of M3"},           {2.7, "clearance of M2.5, fine"},   {2.9, "clearance of M2.5, medium"},
    {3.2, "clearance of M3, fine"},     {3.3, "tap drill of M4"},           {3.4, "clearance of M3, medium"},
    {3.6, "clearance of M3, coarse"},   {4.2, "tap drill of M5"},           {4.3, "clearance of M4, fine"},
    {4.5, "clearance of M4, medium"},   {4.8, "clearance of M4, coarse"},   {5.0, "tap drill of M6"},
    {5.3, "clearance of M5, fine"},     {5.5, "clearance of M5, medium"},   {5.8, "clearance of M5, coarse"},
    {6.4, "clearance of M6, fine"},     {6.6, "clearance of M6, medium"},   {6.8, "tap drill of M8"},
    {7.0, "clearance of M6, coarse"},   {8.4, "clearance of M8, fine"},     {8.5, "tap drill of M10"},
    {9.0, "clearance of M8, medium"},   {10.0, "clearance of M8, coarse"},  {10.2, "tap drill of M12"},
    {10.5, "clearance of M10, fine"},   {11.0, "clearance of M10, medium"}, {12.0, "clearance of M10, coarse"},
    {13.0, "clearance of M12, fine"},   {13.5, "clearance of M12, medium"}, {14.0, "tap drill of M16"},
    {14.5, "clearance of M12, coarse"}, {17.0, "clearance of M16, fine"},   {17.5, "clearance of M16, medium"},
    {18.5, "clearance of M16, coarse"}, {21.0, "clearance of M20, fine"},   {22.0, "clearance of M20, medium"},
    {24.0, "clearance of M20, coarse"}, {25.0, "clearance of M24, fine"},   {26.0, "clearance of M24, medium"},
    {28.0, "clearance of M24, coarse"}};

// Number drills 1 to 60 and letter drills A to Z (ASME B94.11M), thousandths of an inch.
constexpr double number_drills[] = {
    228, 221,  213, 209, 205.5, 204, 201,  199,   196, 193.5, 191, 189,  185,  182, 180, 177,   173, 169.5, 166,  161,
    159, 157,  154, 152, 149.5, 147, 144,  140.5, 136, 128.5, 120, 116,  113,  111, 110, 106.5, 104, 101.5, 99.5, 98,
    96,  93.5, 89,  86,  82,    81,  78.5, 76,    73,  70,    67,  63.5, 59.5, 55,  52,  46.5,  43,  42,    41,   40};
constexpr double letter_drills[] = {234, 238, 242, 246, 250, 257, 261, 266, 272, 277, 281, 290, 295,
                                    302, 316, 323, 332, 339, 348, 358, 368, 377, 386, 397, 404, 413};

// ISO 3, one decade of R20.
constexpr double preferred[] = {1.00, 1.12, 1.25, 1.40, 1.60, 1.80, 2.00, 2.24, 2.50, 2.80,
                                3.15, 3.55, 4.00, 4.50, 5.00, 5.60, 6.30, 7.10, 8.00, 9.00};

bool mentions(const Parameter& p, const char* word) { return p.name.find(word) != std::string::npos; }

std::string mm(double v) { return print_number(snapped(v, 1e-4)); }

/// "3/8", "1 5/16" inch.
std::string fraction(double value, int denominator) {
  long numerator = std::lround(value * denominator);
  while (denominator > 1 && numerator % 2 == 0) numerator /= 2, denominator /= 2;
  const long whole = numerator / denominator, rest = numerator % denominator;
  if (rest == 0) return std::to_string(whole);
  return (whole ? std::to_string(whole) + " " : "") + std::to_string(rest) + "/" + std::to_string(denominator);
}

/// Nearest of an ascending list and the mean gap to its neighbours.
template <typename At>
std::pair<std::size_t, double> nearest_of(std::size_t count, At at, double x) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < count; ++k)
    if (std::abs(at(k) - x) < std::abs(at(best) - x)) best = k;
  const double low = at(best == 0 ? 0 : best - 1), high = at(best + 1 == count ? best : best + 1);
  const double gaps = (best > 0) + (best + 1 < count);
  return {best, gaps > 0 ? (high - low) / gaps : 0};
}

void add_grid(std::vector<Hit>& hits, double x, double step, double unit, double weight, const std::string& series) {
  const double value = snapped(std::round(x / step) * step, unit);
  if (value > 0) hits.push_back({value, step, weight, series});
}

/// The share of a series whose step is this, where it has `usual` among people of no habit.
double share_of(double step, double usual, const Habit& habit) {
  return (1 - habitual) * usual + (std::abs(step - habit.step) < 1e-9 ? habitual : 0);
}

/// Values of the metric series near a length x.
void metric_length(std::vector<Hit>& hits, double x, double weight, const Habit& habit) {
  static constexpr struct { double step, weight; } grids[] = {{10, 0.2}, {5, 0.2}, {1, 0.3}, {0.5, 0.12}, {0.1, 0.06}};
  for (const auto& g : grids)
    add_grid(hits, x, g.step, 0.1, weight * share_of(g.step, g.weight, habit),
             "multiples of " + print_number(g.step) + " mm");
  if (!(x > 0)) return;
  const double decade = std::pow(10, std::floor(std::log10(x) + 1e-12));
  const auto [k, gap] = nearest_of(
      21, [&](std::size_t i) { return i == 20 ? 10 * decade : preferred[i] * decade; }, x);
  const double value = k == 20 ? 10 * decade : preferred[k] * decade;
  hits.push_back({snapped(value, 0.001 * decade), gap, 0.05 * (1 - habitual) * weight, "preferred numbers R20"});
}

void inch_length(std::vector<Hit>& hits, double x, double weight, const Habit& habit) {
  static constexpr struct {
    int denominator;
    double weight;
  } fractions[] = {{1, 0.15}, {2, 0.15}, {4, 0.15}, {8, 0.15}, {16, 0.1}, {32, 0.05}, {64, 0.03}};
  for (const auto& f : fractions) {
    const double step = inch / f.denominator, count = std::round(x / step);
    if (count > 0)
      hits.push_back({count * step, step, weight * share_of(step, f.weight, habit),
                      fraction(count / f.denominator, f.denominator) + " inch"});
  }
  static constexpr struct { double step, weight; } decimals[] = {{0.1, 0.08}, {0.05, 0.04}, {0.01, 0.02}};
  for (const auto& d : decimals) {
    const double count = std::round(x / (d.step * inch));
    if (count > 0)
      hits.push_back({count * d.step * inch, d.step * inch, weight * share_of(d.step * inch, d.weight, habit),
                      mm(count * d.step) + " inch"});
  }
}

void hole_tables(std::vector<Hit>& hits, bool metric, double diameter) {
  if (metric) {
    const auto count = std::size(metric_holes);
    const auto [k, gap] = nearest_of(
        count, [](std::size_t i) { return metric_holes[i].mm; }, diameter);
    hits.push_back({metric_holes[k].mm, gap, drilled, metric_holes[k].what});
    return;
  }
  const double thousandths = diameter / inch * 1000;
  const auto [n, number_gap] = nearest_of(
      60, [](std::size_t i) { return number_drills[59 - i]; }, thousandths);
  hits.push_back({number_drills[59 - n] * inch / 1000, number_gap * inch / 1000, 0.6 * drilled,
                  "number drill " + std::to_string(60 - n)});
  const auto [l, letter_gap] = nearest_of(
      26, [](std::size_t i) { return letter_drills[i]; }, thousandths);
  hits.push_back({letter_drills[l] * inch / 1000, letter_gap * inch / 1000, 0.4 * drilled,
                  std::string("letter drill ") + char('A' + l)});
}

/// "hole_d", "hole_2_d": holes are drilled, mostly.
bool is_hole_diameter(const Parameter& p) {
  return p.name.ends_with("_d") && (mentions(p, "hole") || mentions(p, "bore"));
}

/// Of a positive length or angle.
std::vector<Hit> hits_near(const Parameter& p, double x, const Habit& habit) {
  std::vector<Hit> hits;
  if (p.quantity == Quantity::angle) {
    static constexpr struct {
      double step, weight;
    } grids[] = {{90, 0.2}, {30, 0.15}, {15, 0.2}, {5, 0.2}, {1, 0.15}, {0.5, 0.06}, {0.1, 0.02}};
    for (const auto& g : grids) {
      add_grid(hits, degrees(x), g.step, 0.1, g.weight, "multiples of " + print_number(g.step) + " degrees");
    }
    for (auto& h : hits) h.value = radians(h.value), h.spacing = radians(h.spacing);
    return hits;
  }
  auto lengths = habit.metric ? metric_length : inch_length;
  const bool hole = is_hole_diameter(p);
  lengths(hits, x, hole ? 1 - drilled : 1, habit);
  if (hole) hole_tables(hits, habit.metric, x);
  return hits;
}

/// A place on the other side of the origin is as round.
std::vector<Hit> hits_of(const Parameter& p, const Habit& habit) {
  auto hits = hits_near(p, std::abs(p.fitted), habit);
  if (p.fitted < 0)
    for (auto& h : hits) h.value = -h.value;
  return hits;
}

/// How much better a hit explains a value than chance does, times its prior share.
double gain(const Hit& h, double fitted, double sigma) {
  const double z = (h.value - fitted) / sigma;
  return h.weight * h.spacing / (sigma * std::sqrt(2 * pi)) * std::exp(-z * z / 2);
}

/// One parameter's hits under one habit.
struct Offers {
  std::vector<Hit> hits;
  std::vector<double> gains;
  double sum = 0;
};

/// The most obvious round value, which the measurement misses.
std::optional<NominalEvidence> near_miss(const std::vector<Hit>& hits, double fitted, double sigma) {
  const Hit* coarsest = nullptr;
  for (const auto& h : hits)
    if (h.spacing > 50 * sigma && std::abs(h.value - fitted) < z_reported * sigma &&
        (!coarsest || h.spacing > coarsest->spacing))
      coarsest = &h;
  if (!coarsest) return {};
  NominalEvidence e;
  e.candidate = coarsest->value, e.z = (coarsest->value - fitted) / sigma, e.series = coarsest->series;
  return e;
}

}  // namespace

std::vector<std::optional<NominalEvidence>> nominal_values(const std::vector<Parameter>& parameters, double tolerance,
                                                           double size) {
  std::vector<std::optional<NominalEvidence>> answers(parameters.size());
  std::vector<std::size_t> asked;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto& p = parameters[i];
    if (p.sigma > 0 && (p.quantity == Quantity::length || p.quantity == Quantity::angle)) asked.push_back(i);
  }
  // The share of nominal sizes, evenly likely between 0 and 1, at the middles of so many steps.
  constexpr int steps = 40;
  constexpr std::size_t count = std::size(habits);
  std::array<std::vector<Offers>, count> offers;
  std::array<std::array<double, steps>, count> log_likelihood{};
  for (std::size_t s = 0; s < count; ++s) {
    for (const auto i : asked) {
      const auto& p = parameters[i];
      Offers o;
      o.hits = hits_of(p, habits[s]);
      for (const auto& h : o.hits) o.gains.push_back(gain(h, p.fitted, p.sigma)), o.sum += o.gains.back();
      for (int k = 0; k < steps; ++k) {
        const double share = (k + 0.5) / steps;
        log_likelihood[s][k] += std::log1p(share * (o.sum - 1));
      }
      offers[s].push_back(std::move(o));
    }
    for (double& l : log_likelihood[s]) l += std::log(habits[s].prior);
  }
  double best = -1e300, total = 0;
  for (const auto& row : log_likelihood)
    for (const double l : row) best = std::max(best, l);
  auto posterior = log_likelihood;
  for (auto& row : posterior)
    for (double& l : row) total += l = std::exp(l - best);
  std::size_t likeliest = 0;
  std::array<double, count> mass{};
  for (std::size_t s = 0; s < count; ++s) {
    for (const double l : posterior[s]) mass[s] += l;
    if (mass[s] > mass[likeliest]) likeliest = s;
  }
  for (std::size_t a = 0; a < asked.size(); ++a) {
    const auto& p = parameters[asked[a]];
    // Probability of every value on offer; series that agree on a value add up.
    struct Value {
      double value = 0, probability = 0, coarsest = 0, strongest = 0;
      std::string series;  // the coarsest that has it names it
    };
    std::vector<Value> values;
    for (std::size_t s = 0; s < count; ++s) {
      const auto& o = offers[s][a];
      double factor = 0;
      for (int k = 0; k < steps; ++k) {
        const double share = (k + 0.5) / steps;
        factor += posterior[s][k] / total * share / (1 + share * (o.sum - 1));
      }
      for (std::size_t h = 0; h < o.hits.size(); ++h) {
        const double probability = factor * o.gains[h];
        auto found = std::find_if(values.begin(), values.end(), [&](const Value& v) {
          return std::abs(v.value - o.hits[h].value) < 1e-9 * std::max(1.0, std::abs(v.value));
        });
        if (found == values.end()) found = values.insert(values.end(), {o.hits[h].value, 0, 0, 0, ""});
        found->probability += probability;
        const double coarse = o.hits[h].spacing;
        if (coarse > found->coarsest + 1e-9 || (coarse > found->coarsest - 1e-9 && probability > found->strongest))
          found->coarsest = coarse, found->strongest = probability, found->series = o.hits[h].series;
      }
    }
    const auto most = std::max_element(values.begin(), values.end(),
                                       [](const Value& x, const Value& y) { return x.probability < y.probability; });
    auto& answer = answers[asked[a]];
    if (most != values.end() && most->probability >= 0.5) {
      NominalEvidence e;
      e.candidate = most->value, e.z = (most->value - p.fitted) / p.sigma, e.series = most->series;
      e.probability = std::min(most->probability, 1.0);
      const double shift = std::abs(most->value - p.fitted) * (p.quantity == Quantity::angle ? size : 1);
      e.kept = e.probability >= least_probability && std::abs(e.z) <= z_limit && shift <= tolerance / 4;
      answer = e;
    } else {
      answer = near_miss(offers[likeliest][a].hits, p.fitted, p.sigma);
      if (answer)
        for (const auto& v : values)
          if (std::abs(v.value - answer->candidate) < 1e-9 * std::max(1.0, std::abs(v.value)))
            answer->probability = v.probability;
    }
  }
  return answers;
}

}  // namespace partscribe::fit
