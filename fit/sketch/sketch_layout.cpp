#include "fit/sketch/sketch_layout.h"

#include <algorithm>
#include <cmath>

namespace partscribe::fit {
namespace {

/// The lowest and the highest level of a loop along an axis, and how many it has.
struct Span {
  SketchLevel* low = nullptr;
  SketchLevel* high = nullptr;
  std::size_t count = 0;
  double size() const { return high->value - low->value; }
  double middle() const { return (high->value + low->value) / 2; }
};

Span span_of(const std::vector<SketchPiece>& loop, std::vector<SketchLevel>& levels, int axis) {
  std::vector<int> seen;
  for (const auto& p : loop)
    if (p.level >= 0 && levels[std::size_t(p.level)].axis == axis) seen.push_back(p.level);
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  Span span;
  span.count = seen.size();
  for (const int l : seen) {
    SketchLevel& level = levels[std::size_t(l)];
    if (!span.low || level.value < span.low->value) span.low = &level;
    if (!span.high || level.value > span.high->value) span.high = &level;
  }
  return span;
}

/// Two levels by the middle between them and their distance.
void place_about(SketchNumbers& numbers, const Span& span, const Expr& middle, const Expr& size) {
  const Expr half = size / Expr(2);
  span.low->expr = middle == Expr(0) ? -half : middle - half;
  span.high->expr = middle == Expr(0) ? half : middle + half;
  for (SketchLevel* level : {span.low, span.high}) {
    level->set = true;
    numbers.know(level->axis, level->value, level->expr);
  }
}

/// A row of holes shares levels across it: those are placed once.
void place_straight_hole(SketchNumbers& numbers, SketchNumbers::Shared& sizes, const std::array<Span, 2>& spans) {
  if (spans[0].count != 2 || spans[1].count != 2) return;
  const bool square = std::abs(spans[0].size() - spans[1].size()) < numbers.same;
  for (const int axis : {0, 1}) {
    const Span& span = spans[std::size_t(axis)];
    const auto placed = [&](const SketchLevel* l) { return l->set || numbers.knows(axis, l->value); };
    if (placed(span.low) || placed(span.high)) continue;
    const std::string xy = axis == 0 ? "x" : "y";
    const std::string role = square ? "hole_side" : axis == 0 ? "hole_length" : "hole_width";
    const Expr middle = numbers.coordinate(axis, span.middle(), "hole_" + xy, xy + " of the middle of the hole");
    place_about(
        numbers, span, middle,
        numbers.shared(sizes, span.size(), role, square ? "side of the square hole" : "size of the hole along " + xy));
  }
}

/// A round hole, or one with two straight sides along each axis.
struct HoleLoop {
  Vec2 center, size;
  bool round = false;
};

std::vector<HoleLoop> holes_of(const std::vector<std::vector<SketchPiece>>& loops, std::vector<SketchLevel>& levels) {
  std::vector<HoleLoop> holes;
  for (std::size_t l = 1; l < loops.size(); ++l) {
    const Span x = span_of(loops[l], levels, 0), y = span_of(loops[l], levels, 1);
    const ProfileSegment& s = loops[l].front().s;
    if (loops[l].size() == 1 && s.arc)
      holes.push_back({s.center, Vec2::Constant(2 * s.radius), true});
    else if (x.count == 2 && y.count == 2)
      holes.push_back({{x.middle(), y.middle()}, {x.size(), y.size()}});
  }
  return holes;
}

/// Along one axis: even rows about the origin by their pitch, pairs about it by their distance, others each from the
/// one before.
void space_holes(SketchNumbers& numbers, const std::vector<HoleLoop>& equal, int axis) {
  std::vector<double> at;
  for (const HoleLoop& hole : equal) at.push_back(hole.center[axis]);
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [&](double a, double b) { return b - a < numbers.same; }), at.end());
  const std::size_t n = at.size();
  if (n < 2) return;
  const std::string xy = axis == 0 ? "x" : "y";
  SketchNumbers::Shared spacings;
  const auto spacing = [&](double v) {
    return numbers.shared(spacings, v, "pitch_" + xy, "pitch of the holes along " + xy);
  };
  bool symmetric = true, even = n > 2;
  for (std::size_t k = 0; k < n; ++k) symmetric &= std::abs(at[k] + at[n - 1 - k]) < numbers.same;
  for (std::size_t k = 2; k < n; ++k) even &= std::abs((at[k] - at[k - 1]) - (at[1] - at[0])) < numbers.same;
  if (symmetric) {
    for (std::size_t k = 0; 2 * k + 1 < n; ++k) {
      const Expr half = even ? spacing((at[n - 1] - at[0]) / double(n - 1)) * Expr(double(n - 1 - 2 * k) / 2)
                             : spacing(at[n - 1 - k] - at[k]) / Expr(2);
      numbers.know(axis, at[n - 1 - k], half);
      numbers.know(axis, at[k], -half);
    }
    return;
  }
  Expr before = numbers.coordinate(axis, at[0], "hole_" + xy, xy + " of the hole");
  for (std::size_t k = 1; k < n; ++k) {
    if (!numbers.knows(axis, at[k])) {
      const Expr step = spacing(at[k] - at[k - 1]);
      numbers.know(axis, at[k], before == Expr(0) ? step : before + step);
    }
    before = *numbers.known(axis, at[k]);
  }
}

/// The radius of a round end determines the distance of the two edges beside it.
bool ends_round(const std::vector<SketchPiece>& outline, const Span& span, double same) {
  return std::any_of(outline.begin(), outline.end(), [&](const SketchPiece& p) {
    return p.s.arc && std::abs(2 * p.s.radius - span.size()) < 2 * same;
  });
}

}  // namespace

void place_by_sizes(SketchNumbers& numbers, std::vector<SketchLevel>& levels,
                    const std::vector<std::vector<SketchPiece>>& loops, const std::array<bool, 2>& from_middle) {
  for (const int axis : {0, 1}) {
    const Span span = span_of(loops[0], levels, axis);
    if (!from_middle[std::size_t(axis)] || span.count < 2 || ends_round(loops[0], span, numbers.same)) continue;
    place_about(numbers, span, Expr(0),
                axis == 0 ? numbers.parameter(span.size(), Quantity::length, "length", "size along x")
                          : numbers.parameter(span.size(), Quantity::length, "width", "size along y"));
  }
  std::vector<HoleLoop> rest = holes_of(loops, levels);
  while (!rest.empty()) {
    const auto others =
        std::stable_partition(rest.begin(), rest.end(), [first = rest.front(), &numbers](const HoleLoop& h) {
          return h.round == first.round && (h.size - first.size).cwiseAbs().maxCoeff() < 2 * numbers.same;
        });
    const std::vector<HoleLoop> equal(rest.begin(), others);
    for (const int axis : {0, 1}) space_holes(numbers, equal, axis);
    rest.erase(rest.begin(), others);
  }
  SketchNumbers::Shared sizes;
  for (std::size_t l = 1; l < loops.size(); ++l)
    place_straight_hole(numbers, sizes, {span_of(loops[l], levels, 0), span_of(loops[l], levels, 1)});
}

}  // namespace partscribe::fit
