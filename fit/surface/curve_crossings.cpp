#include "fit/surface/curve_crossings.h"

#include <algorithm>

namespace partscribe::fit {
namespace {

struct Stretch {
  Vec2 from, to;
  std::size_t curve;
  double share;
};

bool stretches_cross(const Stretch& a, const Stretch& b) {
  const auto side = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    return (q - p).x() * (r - p).y() - (q - p).y() * (r - p).x();
  };
  return side(a.from, a.to, b.from) * side(a.from, a.to, b.to) < 0 &&
         side(b.from, b.to, a.from) * side(b.from, b.to, a.to) < 0;
}

}  // namespace

std::vector<CurveCrossing> crossings_of(std::span<const NurbsCurve<2>* const> curves) {
  std::vector<Stretch> list;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const auto& t = curves[c]->t;
    const int count = 20 * static_cast<int>(t.breaks().size());
    Vec2 last = curves[c]->at(t.low());
    for (int i = 1; i <= count; ++i) {
      const Vec2 next = curves[c]->at(t.low() + (t.high() - t.low()) * i / count);
      list.push_back({last, next, c, (i - 0.5) / count});
      last = next;
    }
  }
  std::stable_sort(list.begin(), list.end(), [](const Stretch& a, const Stretch& b) {
    return std::min(a.from.x(), a.to.x()) < std::min(b.from.x(), b.to.x());
  });
  std::vector<CurveCrossing> result;
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t k = i + 1;
         k < list.size() && std::min(list[k].from.x(), list[k].to.x()) <= std::max(list[i].from.x(), list[i].to.x());
         ++k) {
      const Stretch &a = list[i], &b = list[k];
      if (stretches_cross(a, b)) result.push_back({{a.curve, b.curve}, {a.share, b.share}});
    }
  return result;
}

}  // namespace partscribe::fit
