#include "fit/sketch/outline_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "core/number.h"
#include "core/sample_consensus.h"
#include "core/statistics.h"
#include "fit/sketch/plane_circle.h"
#include "geometry/points/nearby_in_plane.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t most_primitives = 30;

/// A line through `center` across `normal`, or a circle.
struct Primitive {
  bool circle = false;
  bool centred = false;  // its centre is another's, and stays
  Vec2 center = Vec2::Zero(), normal = Vec2::UnitX();
  double radius = 0;
  std::vector<Vec2> on;  // the data behind it
  double band = 0;       // mm, within which it may be off

  Vec2 along() const { return {-normal.y(), normal.x()}; }
  double distance(const Vec2& p) const { return circle ? (p - center).norm() - radius : normal.dot(p - center); }
  Vec2 normal_at(const Vec2& p) const { return circle ? Vec2((p - center).normalized()) : normal; }
  /// Position along it: mm on a line, rad on a circle.
  double place_of(const Vec2& p) const {
    return circle ? std::atan2(p.y() - center.y(), p.x() - center.x()) : along().dot(p - center);
  }
  Vec2 at(double t) const {
    return circle ? Vec2(center + radius * Vec2(std::cos(t), std::sin(t))) : Vec2(center + t * along());
  }
};

bool lies_on(const Primitive& f, const PlanePoint& p, double band) {
  return std::abs(f.distance(p.position)) < band && std::abs(f.normal_at(p.position).dot(p.normal)) > 0.85;
}

std::vector<Vec2> points_on(const Primitive& f, const std::vector<PlanePoint>& points, double band) {
  std::vector<Vec2> on;
  for (const auto& p : points)
    if (lies_on(f, p, band)) on.push_back(p.position);
  return on;
}

std::optional<Primitive> line_through(const PlanePoint& a, const PlanePoint& b, double least) {
  const Vec2 d = b.position - a.position;
  if (!(d.norm() > least)) return std::nullopt;
  Primitive line;
  line.center = a.position, line.normal = Vec2(-d.y(), d.x()).normalized();
  if (std::abs(line.normal.dot(a.normal)) < 0.9 || std::abs(line.normal.dot(b.normal)) < 0.9) return std::nullopt;
  return line;
}

std::optional<Primitive> circle_through(const Vec2& a, const Vec2& b, const Vec2& c, double band, double size) {
  const Vec2 u = b - a, v = c - a;
  const double det = 2 * (u.x() * v.y() - u.y() * v.x());
  if (!(std::abs(det) > 0.1 * u.norm() * v.norm())) return std::nullopt;
  const Vec2 offset =
      Vec2(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(), u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) / det;
  Primitive circle;
  circle.circle = true, circle.center = a + offset, circle.radius = offset.norm();
  if (circle.radius > 0.7 * size || circle.radius < 3 * band) return std::nullopt;
  return circle;
}

void refit(Primitive& f) {
  if (f.centred) {
    f.radius = 0;
    for (const Vec2& p : f.on) f.radius += (p - f.center).norm() / double(f.on.size());
    return;
  }
  if (f.circle) {
    const PlaneCircle c = polished({f.center, f.radius}, f.on);
    f.center = c.center, f.radius = c.radius;
    return;
  }
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : f.on) mean += p / double(f.on.size());
  double xx = 0, xy = 0, yy = 0;
  for (const Vec2& p : f.on) {
    const Vec2 d = p - mean;
    xx += d.x() * d.x(), xy += d.x() * d.y(), yy += d.y() * d.y();
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  f.center = mean, f.normal = {-std::sin(angle), std::cos(angle)};
}

/// Lines and circles by decreasing support; each takes its points away.
void find_primitives(std::vector<PlanePoint> points, double band, double size, std::size_t least,
                     std::vector<Primitive>& found) {
  constexpr int draws = 700;
  constexpr double dearer = 1.15;  // a circle can fit outliers that a line cannot
  Random random(7);
  while (points.size() >= least && found.size() < most_primitives) {
    const auto line_or_circle = [&](auto offer) {
      // Points of one wall lie near each other.
      const PlanePoint& a = drawn_from(points, random);
      const double within = size * std::pow(0.5, double(1 + random.below(4)));
      const auto near = [&]() -> const PlanePoint& {
        for (int k = 0; k < 20; ++k)
          if (const PlanePoint& p = drawn_from(points, random); (p.position - a.position).norm() < within) return p;
        return a;
      };
      const PlanePoint &b = near(), &c = near();
      for (const auto& f :
           {line_through(a, b, 4 * band), circle_through(a.position, b.position, c.position, band, size)})
        if (f) offer(*f);
    };
    const auto points_on_it = [&](const Primitive& f, double) {
      const auto count = std::ranges::count_if(points, [&](const PlanePoint& p) { return lies_on(f, p, band); });
      return double(count) / (f.circle ? dearer : 1);
    };
    const auto drawn = consensus<Primitive>(draws, 0, line_or_circle, points_on_it);
    if (!drawn || drawn->support < double(least)) return;
    Primitive best = drawn->hypothesis;
    for (int round = 0; round < 3; ++round) {
      best.on = points_on(best, points, band);
      if (best.on.size() >= 3) refit(best);
    }
    best.on = points_on(best, points, band);
    const bool good = best.on.size() >= least;
    const Primitive& taken = good ? best : drawn->hypothesis;
    std::erase_if(points, [&](const PlanePoint& p) { return lies_on(taken, p, 1.6 * band); });
    best.band = band;
    if (good) found.push_back(std::move(best));
  }
}

/// Round ends about the centres of holes: their arcs are short, and lines that touch them hide them.
void add_concentric(const std::vector<PlanePoint>& points, double band, double size, std::size_t least,
                    std::vector<Primitive>& found) {
  const std::size_t count = found.size();
  for (std::size_t k = 0; k < count && found.size() < most_primitives; ++k) {
    if (!found[k].circle) continue;
    const Vec2 center = found[k].center;
    std::vector<double> radii;
    for (const auto& p : points) {
      const Vec2 d = p.position - center;
      const double r = d.norm();
      if (r > found[k].radius + 4 * band && r < 0.7 * size && std::abs(d.dot(p.normal)) > 0.95 * r) radii.push_back(r);
    }
    std::sort(radii.begin(), radii.end());
    std::size_t most = 0, from = 0;
    for (std::size_t i = 0, j = 0; i < radii.size(); ++i) {
      while (j < radii.size() && radii[j] < radii[i] + 2 * band) ++j;
      if (j - i > most) most = j - i, from = i;
    }
    if (most < least) continue;
    Primitive ring;
    ring.circle = ring.centred = true, ring.center = center, ring.band = band, ring.radius = radii[from + most / 2];
    const auto known = [&](const Primitive& f) {
      return f.circle && (f.center - center).norm() < 2 * band && std::abs(f.radius - ring.radius) < 2 * band;
    };
    if (std::none_of(found.begin(), found.end(), known)) found.push_back(ring);
  }
}

/// Every point goes to the nearest primitive, which is fitted again: beside a tangent joint the first found has taken
/// what belongs to the next.
void share_points(const std::vector<PlanePoint>& points, double band, std::size_t least,
                  std::vector<Primitive>& found) {
  // Primitives without points of their own are removed one at a time, so that of two equal ones one stays.
  for (int settled = 0; settled < 3;) {
    std::vector<std::size_t> alone(found.size(), 0);  // points that lie on no other
    for (auto& f : found) f.on.clear();
    for (const auto& p : points) {
      std::size_t nearest = found.size(), holders = 0;
      for (std::size_t k = 0; k < found.size(); ++k) {
        if (!lies_on(found[k], p, band)) continue;
        ++holders;
        if (nearest == found.size() ||
            std::abs(found[k].distance(p.position)) < std::abs(found[nearest].distance(p.position)))
          nearest = k;
      }
      if (nearest == found.size()) continue;
      found[nearest].on.push_back(p.position);
      alone[nearest] += holders == 1;
    }
    std::size_t weakest = 0;
    for (std::size_t k = 1; k < found.size(); ++k)
      if (alone[k] < alone[weakest]) weakest = k;
    if (found.empty()) return;
    if (alone[weakest] < least / 2) {
      found.erase(found.begin() + static_cast<std::ptrdiff_t>(weakest));
      continue;
    }
    for (auto& f : found)
      if (f.on.size() >= 3) refit(f);
    ++settled;
  }
}

/// Unseen walls are parallel to seen ones, and round ends have the centre of their holes, where rims allow it.
void align(Primitive& rim, const std::vector<Primitive>& walls) {
  constexpr double parallel = 0.9986;  // 3 degrees
  if (rim.circle) {
    for (const auto& w : walls)
      if (w.circle && (w.center - rim.center).norm() < 2 * rim.band) {
        rim.center = w.center, rim.centred = true;
        return refit(rim);
      }
    return;
  }
  for (const auto& w : walls)
    if (!w.circle && std::abs(w.normal.dot(rim.normal)) > parallel) {
      rim.normal = w.normal;
      return;
    }
}

/// Lines along and across the longest wall where the data end, unless a primitive is near: something has to close the
/// outline.
void add_ends(const OutlineData& data, const Vec2& along, double band, std::vector<Primitive>& primitives) {
  for (const Vec2& out : {along, Vec2(-along), Vec2(-along.y(), along.x()), Vec2(along.y(), -along.x())}) {
    std::vector<double> reach;
    for (const auto& p : data.walls) reach.push_back(out.dot(p.position));
    for (const Vec2& p : data.ends) reach.push_back(out.dot(p));
    const double end = quantile(std::move(reach), 0.998);
    const auto there = [&](const Primitive& f) {
      return !f.circle && std::abs(f.normal.dot(out)) > 0.98 && std::abs(out.dot(f.center) - end) < 3 * f.band;
    };
    if (primitives.size() >= most_primitives || std::any_of(primitives.begin(), primitives.end(), there)) continue;
    Primitive line;
    line.normal = out, line.center = end * out, line.band = band;
    primitives.push_back(line);
  }
}

/// Where two primitives meet; where they touch within `band`, once.
std::vector<Vec2> meetings(const Primitive& a, const Primitive& b) {
  const double band = std::max(a.band, b.band);
  if (!a.circle && !b.circle) {
    const double det = a.normal.x() * b.normal.y() - a.normal.y() * b.normal.x();
    if (std::abs(det) < 0.05) return {};
    const double p = a.normal.dot(a.center), q = b.normal.dot(b.center);
    return {Vec2(p * b.normal.y() - q * a.normal.y(), q * a.normal.x() - p * b.normal.x()) / det};
  }
  if (a.circle && b.circle) {
    const Vec2 d = b.center - a.center;
    const double between = d.norm();
    if (!(between > band)) return {};
    const Vec2 u = d / between;
    const double x = 0.5 * (between + (a.radius * a.radius - b.radius * b.radius) / between);
    const double outside = std::abs(x) - a.radius;
    if (outside > 2 * band) return {};
    if (outside > -band) return {a.center + (x > 0 ? 1 : -1) * a.radius * u};
    const double y = std::sqrt(std::max(a.radius * a.radius - x * x, 0.0));
    const Vec2 v(-u.y(), u.x());
    return {a.center + x * u + y * v, a.center + x * u - y * v};
  }
  const Primitive &circle = a.circle ? a : b, &line = a.circle ? b : a;
  const double d = line.distance(circle.center);
  const Vec2 foot = circle.center - d * line.normal;
  if (std::abs(d) > circle.radius + 2 * band) return {};
  if (std::abs(d) > circle.radius - 2 * band) return {foot};
  const double y = std::sqrt(circle.radius * circle.radius - d * d);
  return {foot + y * line.along(), foot - y * line.along()};
}

/// The plane as pixels, each in a cell of equal sides to all primitives.
class Cells {
 public:
  Cells(const std::vector<Primitive>& primitives, const OutlineData& data, const Vec2& low, const Vec2& high)
      : primitives_(primitives), low_(low), pixel_((high - low).maxCoeff() / 180) {
    width_ = static_cast<int>((high - low).x() / pixel_) + 1, height_ = static_cast<int>((high - low).y() / pixel_) + 1;
    flood();
    look(data);
  }
  double pixel() const { return pixel_; }
  bool solid(const Vec2& p) const {
    const int x = static_cast<int>((p.x() - low_.x()) / pixel_), y = static_cast<int>((p.y() - low_.y()) / pixel_);
    return x >= 0 && y >= 0 && x < width_ && y < height_ && label_[cell_[index(x, y)]];
  }

  double solid_area() const {
    double sum = 0;
    for (std::size_t c = 0; c < area_.size(); ++c) sum += label_[c] ? area_[c] : 0;
    return sum * pixel_ * pixel_;
  }
  /// Of the seen part of the end faces, what lies in solid cells.
  double share_in_solid() const {
    double in = 0, all = 1e-9;
    for (std::size_t c = 0; c < area_.size(); ++c) all += seen_[c], in += label_[c] ? seen_[c] : 0;
    return in / all;
  }

  /// Starts from what is mostly seen, then turns cells, alone or two by two, while that helps.
  void decide() {
    const std::size_t n = area_.size();
    label_.assign(n, 0);
    for (std::size_t c = 0; c < n; ++c) label_[c] = !border_[c] && seen_[c] > 0.5 * area_[c];
    std::vector<std::vector<std::size_t>> sides(n);
    for (std::size_t s = 0; s < sides_.size(); ++s) sides[sides_[s].a].push_back(s), sides[sides_[s].b].push_back(s);
    const auto gain = [&](const std::set<std::size_t>& turned) {
      double before = 0, after = 0;
      std::set<std::size_t> touched;
      for (const auto c : turned) {
        if (border_[c]) return -1.0;
        before += cost_of(c, label_[c]), after += cost_of(c, !label_[c]);
        touched.insert(sides[c].begin(), sides[c].end());
      }
      for (const auto s : touched) {
        const bool a = label_[sides_[s].a] != 0, b = label_[sides_[s].b] != 0;
        before += cost_of(sides_[s], a != b);
        after += cost_of(sides_[s], (a != (turned.count(sides_[s].a) > 0)) != (b != (turned.count(sides_[s].b) > 0)));
      }
      return before - after;
    };
    for (int round = 0; round < 50; ++round) {
      bool changed = false;
      const auto attempt = [&](const std::set<std::size_t>& cells) {
        if (!(gain(cells) > 1e-9)) return;
        for (const auto c : cells) label_[c] = !label_[c];
        changed = true;
      };
      for (std::size_t c = 0; c < n; ++c) attempt({c});
      for (const auto& s : sides_) attempt({s.a, s.b});
      if (!changed) break;
    }
  }

 private:
  struct Side {
    std::size_t a, b;           // cells
    double wall = 0, bare = 0;  // pixels of its length
  };
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  Vec2 middle(int x, int y) const { return low_ + pixel_ * Vec2(x + 0.5, y + 0.5); }

  void flood() {
    const std::size_t count = index(0, height_);
    std::vector<std::uint32_t> sides(count);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        for (std::size_t k = 0; k < primitives_.size(); ++k)
          sides[index(x, y)] |= std::uint32_t(primitives_[k].distance(middle(x, y)) > 0) << k;
    constexpr std::size_t none = ~std::size_t{0};
    cell_.assign(count, none);
    for (std::size_t start = 0; start < count; ++start) {
      if (cell_[start] != none) continue;
      const std::size_t id = area_.size();
      area_.push_back(0), border_.push_back(0);
      std::vector<std::size_t> open = {start};
      cell_[start] = id;
      while (!open.empty()) {
        const std::size_t at = open.back();
        open.pop_back();
        area_[id] += 1;
        const int x = static_cast<int>(at % static_cast<std::size_t>(width_)),
                  y = static_cast<int>(at / static_cast<std::size_t>(width_));
        for (const auto& [dx, dy] : std::array<std::pair<int, int>, 4>{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}}) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= width_ || y + dy >= height_) {
            border_[id] = 1;
            continue;
          }
          const std::size_t next = index(x + dx, y + dy);
          if (cell_[next] == none && sides[next] == sides[at]) cell_[next] = id, open.push_back(next);
        }
      }
    }
  }

  /// What of each cell's area and of each border is seen.
  void look(const OutlineData& data) {
    const double reach = std::max(1.5 * data.spacing, pixel_), wall_reach = std::max(2 * data.spacing, 2 * pixel_);
    const NearbyInPlane ends(data.ends);
    std::vector<NearbyInPlane> walls;
    for (const auto& f : primitives_) walls.emplace_back(f.on);
    seen_.assign(area_.size(), 0);
    std::map<std::pair<std::size_t, std::size_t>, Side> sides;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const Vec2 p = middle(x, y);
        const std::size_t a = cell_[index(x, y)];
        if (ends.within(p, reach)) seen_[a] += 1;
        for (const auto& [dx, dy] : std::array<std::pair<int, int>, 2>{{{1, 0}, {0, 1}}}) {
          if (x + dx >= width_ || y + dy >= height_) continue;
          const std::size_t b = cell_[index(x + dx, y + dy)];
          if (a == b) continue;
          const Vec2 q = 0.5 * (p + middle(x + dx, y + dy));
          bool wall = false;
          for (std::size_t k = 0; k < primitives_.size() && !wall; ++k)
            wall = std::abs(primitives_[k].distance(q)) < pixel_ && walls[k].within(q, wall_reach);
          Side& side = sides.try_emplace(std::minmax(a, b), Side{std::min(a, b), std::max(a, b)}).first->second;
          (wall ? side.wall : side.bare) += 1;
        }
      }
    for (const auto& [cells, side] : sides) sides_.push_back(side);
  }

  /// In pixels of length: an area counts as much as a border where it is a twentieth of the picture wide.
  double cost_of(std::size_t cell, bool solid) const {
    constexpr double unseen_solid = 0.6, area_weight = 20.0 / 180;
    return area_weight * (solid ? unseen_solid * (area_[cell] - seen_[cell]) : seen_[cell]);
  }
  static double cost_of(const Side& side, bool differ) {
    constexpr double wall_within = 1.5;
    return differ ? side.bare : wall_within * side.wall;
  }

  const std::vector<Primitive>& primitives_;
  Vec2 low_;
  double pixel_;
  int width_ = 0, height_ = 0;
  std::vector<std::size_t> cell_;
  std::vector<double> area_, seen_;
  std::vector<std::uint8_t> border_, label_;
  std::vector<Side> sides_;
};

/// A piece of a primitive between two corners, solid on its left.
struct Border {
  std::size_t primitive;
  std::size_t from, to;  // corners
  double start, end;     // places on the primitive
};

struct Corners {
  std::vector<Vec2> places;
  std::vector<std::vector<std::pair<double, std::size_t>>> on;  // of each primitive, in order
};

Corners corners_of(const std::vector<Primitive>& primitives, const Vec2& low, const Vec2& high) {
  Corners corners;
  corners.on.resize(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i)
    for (std::size_t k = i + 1; k < primitives.size(); ++k)
      for (const Vec2& p : meetings(primitives[i], primitives[k])) {
        if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) continue;
        // Corners that noise holds apart are one.
        std::size_t id = 0;
        while (id < corners.places.size() &&
               (corners.places[id] - p).norm() > std::max(primitives[i].band, primitives[k].band))
          ++id;
        if (id == corners.places.size()) corners.places.push_back(p);
        for (const std::size_t f : {i, k}) {
          auto& list = corners.on[f];
          if (std::none_of(list.begin(), list.end(), [&](const auto& c) { return c.second == id; }))
            list.emplace_back(primitives[f].place_of(corners.places[id]), id);
        }
      }
  for (auto& list : corners.on) std::sort(list.begin(), list.end());
  return corners;
}

std::vector<Border> borders_of(const std::vector<Primitive>& primitives, const Corners& corners, const Cells& cells) {
  std::vector<Border> result;
  for (std::size_t f = 0; f < primitives.size(); ++f) {
    const auto& list = corners.on[f];
    const Primitive& shape = primitives[f];
    if (list.empty() && !shape.circle) continue;
    const double aside = std::max(1.5 * cells.pixel(), 1.2 * shape.band);
    const std::size_t pieces = shape.circle ? std::max<std::size_t>(list.size(), 1) : list.size() - 1;
    for (std::size_t i = 0; i < pieces; ++i) {
      constexpr std::size_t none = ~std::size_t{0};
      double start = list.empty() ? 0 : list[i].first, end = list.empty() ? 2 * pi : list[(i + 1) % list.size()].first;
      if (shape.circle && end <= start) end += 2 * pi;
      const std::size_t from = list.empty() ? none : list[i].second,
                        to = list.empty() ? none : list[(i + 1) % list.size()].second;
      const double length = (end - start) * (shape.circle ? shape.radius : 1);
      if (length < 1.5 * shape.band) continue;  // a sliver between primitives that nearly touch
      const Vec2 p = shape.at(0.5 * (start + end)), out = shape.normal_at(p);
      const bool inner = cells.solid(p - aside * out), outer = cells.solid(p + aside * out);
      if (inner == outer) continue;
      // Forward along a circle its inside is on the left; forward along a line (the normal turned left) the normal's
      // back is.
      if (inner)
        result.push_back({f, from, to, start, end});
      else
        result.push_back({f, to, from, end, start});
    }
  }
  return result;
}

ProfileSegment segment_of(const Primitive& shape, const Border& b) {
  ProfileSegment s;
  s.arc = shape.circle;
  s.start = shape.at(b.start), s.end = shape.at(b.end);
  s.points = double(shape.on.size());
  if (shape.circle) {
    s.center = shape.center, s.radius = shape.radius, s.sweep = b.end - b.start;
  } else {
    s.point = s.start, s.direction = (s.end - s.start).normalized();
  }
  return s;
}

double area_of(const std::vector<ProfileSegment>& segments) {
  double sum = 0;
  for (const auto& s : segments) {
    sum += 0.5 * (s.start.x() * s.end.y() - s.start.y() * s.end.x());
    if (s.arc) sum += 0.5 * s.radius * s.radius * (s.sweep - std::sin(s.sweep));
  }
  return sum;
}

/// Follows the borders from corner to corner, over what noise leaves open at tangent joints (`gap` mm); slivers that
/// end nowhere are left out.
std::vector<LoopPieces> loops_of(const std::vector<Border>& borders, const std::vector<Primitive>& primitives,
                                 double gap, double least_area) {
  const auto start_of = [&](std::size_t b) { return primitives[borders[b].primitive].at(borders[b].start); };
  const auto end_of = [&](std::size_t b) { return primitives[borders[b].primitive].at(borders[b].end); };
  const auto length_of = [&](std::size_t b) {
    const Primitive& f = primitives[borders[b].primitive];
    return std::abs(borders[b].end - borders[b].start) * (f.circle ? f.radius : 1);
  };
  std::vector<LoopPieces> loops;
  std::vector<bool> used(borders.size(), false);
  std::vector<std::size_t> longest_first(borders.size());
  std::iota(longest_first.begin(), longest_first.end(), std::size_t{0});
  std::stable_sort(longest_first.begin(), longest_first.end(),
                   [&](std::size_t a, std::size_t b) { return length_of(a) > length_of(b); });
  for (const std::size_t first : longest_first) {
    if (used[first]) continue;
    std::vector<Border> run;
    bool closed = true;
    for (std::size_t at = first;;) {
      used[at] = true;
      const Border& b = borders[at];
      if (!run.empty() && run.back().primitive == b.primitive &&
          (run.back().end > run.back().start) == (b.end > b.start))
        run.back().to = b.to, run.back().end += b.end - b.start;
      else
        run.push_back(b);
      if (b.to == borders[first].from) break;
      std::size_t next = borders.size();
      double nearest = gap;
      for (std::size_t i = 0; i < borders.size(); ++i) {
        const double apart = borders[i].from == b.to ? 0 : (start_of(i) - end_of(at)).norm();
        if ((used[i] && i != first) || apart > nearest) continue;
        if (apart < nearest || next == borders.size() || length_of(i) > length_of(next)) nearest = apart, next = i;
      }
      closed = next < borders.size();
      if (!closed || next == first) break;
      at = next;
    }
    if (!closed) continue;
    if (run.size() > 1 && run.front().primitive == run.back().primitive &&
        (run.front().end > run.front().start) == (run.back().end > run.back().start)) {
      run.front().from = run.back().from, run.front().start -= run.back().end - run.back().start;
      run.pop_back();
    }
    LoopPieces loop;
    for (const auto& b : run) loop.segments.push_back(segment_of(primitives[b.primitive], b));
    if (std::abs(area_of(loop.segments)) > least_area) loops.push_back(std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(), [](const LoopPieces& a, const LoopPieces& b) {
    return std::abs(area_of(a.segments)) > std::abs(area_of(b.segments));
  });
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if ((area_of(loops[i].segments) > 0) != (i == 0)) return {};  // several bodies
    loops[i].name = i == 0 ? "outline" : loops.size() == 2 ? "hole" : "hole " + print_number(double(i));
  }
  return loops;
}

}  // namespace

std::vector<LoopPieces> outline_by_cells(const OutlineData& data) {
  if (data.walls.size() < 20 || data.ends.size() < 20 || !(data.band > 0)) return {};
  Vec2 low = Vec2::Constant(1e300), high = -low;
  for (const auto& p : data.walls) low = low.cwiseMin(p.position), high = high.cwiseMax(p.position);
  for (const Vec2& p : data.ends) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double size = (high - low).maxCoeff();
  const Vec2 margin = Vec2::Constant(0.05 * size);
  low -= margin, high += margin;
  constexpr double good_share = 0.7;  // of what is seen of the end faces
  const std::size_t least = std::max<std::size_t>(8, data.walls.size() / 100);
  std::vector<Primitive> primitives;
  find_primitives(data.walls, data.band, size, least, primitives);
  add_concentric(data.walls, data.band, size, least, primitives);
  share_points(data.walls, data.band, least, primitives);
  const auto longest = std::find_if(primitives.begin(), primitives.end(), [](const Primitive& f) { return !f.circle; });
  if (primitives.empty()) return {};
  const Vec2 along = longest == primitives.end() ? Vec2(1, 0) : longest->along();
  std::vector<PlanePoint> open;
  for (const auto& p : data.rims)
    if (std::none_of(primitives.begin(), primitives.end(),
                     [&](const Primitive& f) { return lies_on(f, p, 2 * data.band); }))
      open.push_back(p);
  const double rim_band = data.band + data.spacing;
  std::vector<Primitive> rims;
  find_primitives(open, rim_band, size, std::max<std::size_t>(8, open.size() / 20), rims);
  const std::vector<Primitive> walls = primitives;
  for (auto& rim : rims) {
    align(rim, walls);
    if (primitives.size() < most_primitives) primitives.push_back(rim);
  }
  for (const bool closed : {false, true}) {
    if (closed) add_ends(data, along, rim_band, primitives);
    Cells cells(primitives, data, low, high);
    cells.decide();
    if (cells.share_in_solid() < good_share) continue;
    const Corners corners = corners_of(primitives, low, high);
    auto loops = loops_of(borders_of(primitives, corners, cells), primitives, 3 * rim_band, 0.001 * size * size);
    double enclosed = 0;
    for (const auto& loop : loops) enclosed += area_of(loop.segments);
    if (std::abs(enclosed - cells.solid_area()) < 0.1 * enclosed) return loops;
  }
  return {};
}

}  // namespace partscribe::fit
