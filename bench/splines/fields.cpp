#include "fields.h"

#include <algorithm>
#include <cmath>

namespace bench {
namespace {

/// Sum of products g(x) h(y), each given with two derivatives.
struct Along {
  double value, first, second;
};
void add_product(Height& h, const Along& g, const Along& k) {
  h.z += g.value * k.value;
  h.x += g.first * k.value, h.y += g.value * k.first;
  h.xx += g.second * k.value, h.xy += g.first * k.first, h.yy += g.value * k.second;
}

Along sine(double t, double length) {
  return {std::sin(t / length), std::cos(t / length) / length, -std::sin(t / length) / length / length};
}
Along cosine(double t, double length) {
  return {std::cos(t / length), -std::sin(t / length) / length, -std::cos(t / length) / length / length};
}
Along bell(double t, double width) {  // exp(-t^2 / width)
  const double e = std::exp(-t * t / width);
  return {e, -2 * t / width * e, (4 * t * t / width - 2) / width * e};
}
Along times(double factor, const Along& a) { return {factor * a.value, factor * a.first, factor * a.second}; }
constexpr Along one = {1, 0, 0};

/// The squared distance to the graph and where it falls.
struct Descent {
  double value, x, y, xx, xy, yy;
};
Descent descent(const FieldPiece& piece, const Vec3& p, const Vec2& at) {
  const Height h = piece.height(at.x(), at.y());
  const double dx = at.x() - p.x(), dy = at.y() - p.y(), dz = h.z - p.z();
  return {dx * dx + dy * dy + dz * dz, dx + dz * h.x,         dy + dz * h.y,
          1 + h.x * h.x + dz * h.xx,   h.x * h.y + dz * h.xy, 1 + h.y * h.y + dz * h.yy};
}

double sq_distance(const FieldPiece& piece, const Vec3& p) {
  Vec2 at = p.head<2>();
  const bool everywhere = piece.side.isZero();
  const auto beyond = [&](const Vec2& q) { return everywhere ? 0 : piece.side.dot(q) - piece.end; };
  bool on_border = beyond(at) > 0;
  const Vec2 border = everywhere ? Vec2::Zero() : Vec2(piece.side.normalized());
  const auto to_border = [&](const Vec2& q) { return Vec2(q - beyond(q) / piece.side.norm() * border); };
  if (on_border) at = to_border(at);
  for (int round = 0; round < 50; ++round) {
    const Descent d = descent(piece, p, at);
    Vec2 step = Vec2::Zero();
    if (on_border) {
      const Vec2 along(-border.y(), border.x());
      const double first = d.x * along.x() + d.y * along.y();
      const double second =
          d.xx * along.x() * along.x() + 2 * d.xy * along.x() * along.y() + d.yy * along.y() * along.y();
      step = -first / std::max(second, 0.1) * along;
      // Off the border again, where that leads down.
      if (d.x * border.x() + d.y * border.y() > 1e-12 && round > 0) on_border = false;
    }
    if (!on_border) {
      const double det = d.xx * d.yy - d.xy * d.xy;
      step = det > 0 && d.xx > 0 ? Vec2(-(d.yy * d.x - d.xy * d.y) / det, -(d.xx * d.y - d.xy * d.x) / det)
                                 : Vec2(-0.5 * d.x, -0.5 * d.y);
    }
    Vec2 next = at + step;
    if (beyond(next) > 0) {
      if (!on_border) next = to_border(next), on_border = true;
    }
    const bool settled = (next - at).norm() < 1e-11;
    at = next;
    if (settled) break;
  }
  return descent(piece, p, at).value;
}

}  // namespace

double Field::height(double x, double y) const {
  for (const FieldPiece& piece : pieces)
    if (piece.side.dot(Vec2(x, y)) <= piece.end) return piece.height(x, y).z;
  return pieces.back().height(x, y).z;
}

double Field::distance(const Vec3& point) const {
  double least = 1e300;
  for (const FieldPiece& piece : pieces) least = std::min(least, sq_distance(piece, point));
  return std::sqrt(least);
}

std::vector<Field> fields() {
  const auto smooth = [](double x, double y) {
    Height h{25};
    add_product(h, times(5, sine(x, 18)), cosine(y, 14));
    add_product(h, times(3, cosine(x, 30)), one);
    return h;
  };
  const auto bumps = [](double x, double y) {
    Height h{20};
    add_product(h, times(4, sine(x, 25)), one);
    add_product(h, times(6, bell(x - 20, 30)), bell(y - 20, 30));
    add_product(h, times(3, bell(x - 60, 10)), bell(y - 45, 10));
    add_product(h, times(-2, bell(x - 40, 200)), bell(y - 30, 200));
    return h;
  };
  const auto roof = [](double from, double slope) {  // along x, on a wave along y
    return [=](double x, double y) {
      Height h{20 + from + slope * (x - 30), slope};
      add_product(h, one, times(2, sine(y, 15)));
      return h;
    };
  };
  const auto fold = [](double slope) {
    return [=](double x, double y) { return Height{34 + slope * (x + y - 70), slope, slope}; };
  };
  return {{"smooth", {{smooth}}},
          {"bumps", {{bumps}}},
          {"crease along v", {{roof(12, 0.4), Vec2(1, 0), 30}, {roof(12, -0.2), Vec2(-1, 0), -30}}},
          {"diagonal crease", {{fold(0.2), Vec2(1, 1), 70}, {fold(-0.2), Vec2(-1, -1), -70}}}};
}

}  // namespace bench
