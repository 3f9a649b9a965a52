#include "fit/propose/convex_body.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "core/ensure.h"
#include "core/number.h"
#include "core/sample_consensus.h"
#include "core/statistics.h"

namespace partscribe::fit {

double convex_distance(const std::vector<ConvexFace>& faces, const Vec3& p, std::size_t* face, double* second) {
  double d = -1e300, next = -1e300;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double di = faces[i].normal.dot(p) - faces[i].offset;
    if (di > d) {
      next = d, d = di;
      if (face) *face = i;
    } else {
      next = std::max(next, di);
    }
  }
  if (second) *second = next;
  return d;
}

std::vector<Plane3> planes_only(const std::vector<ConvexFace>& faces) {
  std::vector<Plane3> planes;
  for (const ConvexFace& f : faces) planes.push_back({f.normal, f.offset});
  return planes;
}

std::vector<Vec3> points_on(const std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  std::vector<Vec3> on;
  for (const Vec3& p : input.cloud.points)
    if (std::abs(convex_distance(faces, p)) < 1.5 * reach) on.push_back(p);
  return on;
}

ConvexFace closing_face(const std::vector<Vec3>& on, const Vec3& normal) {
  std::vector<double> v;
  for (const Vec3& p : on) v.push_back(normal.dot(p));
  if (v.empty()) return {normal, 0, 0};
  // The few outermost may be outliers that happen to lie on the planes of the other faces.
  const std::size_t skipped = std::min(v.size() - 1, 4 + v.size() / 1000);
  const auto at = v.begin() + static_cast<std::ptrdiff_t>(skipped);
  std::nth_element(v.begin(), at, v.end(), std::greater<>());
  return {normal, *at, 0};
}

double misfit_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  const double sigma = std::max(input.sampling.sigma, 0.2 * input.tolerance);
  double sum = 0;
  for (const Vec3& p : input.cloud.points) {
    const double u = convex_distance(faces, p) / sigma;
    sum += 0.5 * std::min(u * u / 2, 12.0);
  }
  return sum;
}

double reach_of(const FitInput& input) { return std::max(3 * input.sampling.sigma, input.tolerance); }

Box3 box_along(const Mat3& rotation, const std::vector<Vec3>& points, double left_out) {
  Box3 box;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> along;
    for (const Vec3& p : points) along.push_back(rotation.col(k).dot(p));
    box.low[k] = quantile(along, left_out), box.high[k] = quantile(along, 1 - left_out);
  }
  return box;
}

namespace {

constexpr std::size_t most_faces = 24;

/// Orthogonal-distance plane through `points` by reweighting from the plane that `face` has; the scale falls to
/// `reach`.
void fit_plane(ConvexFace& face, const std::vector<Vec3>& points, double reach, int rounds) {
  std::vector<double> absolute;
  for (const Vec3& p : points) absolute.push_back(std::abs(face.normal.dot(p) - face.offset));
  double scale = std::max(reach, 1.5 * median(absolute));
  for (int round = 0; round < rounds; ++round) {
    double sum = 0;
    Vec3 mean = Vec3::Zero();
    std::vector<double> weight(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double u = (face.normal.dot(points[i]) - face.offset) / scale;
      weight[i] = std::exp(-0.5 * u * u);
      sum += weight[i], mean += weight[i] * points[i];
    }
    if (!(sum > 3)) return;
    mean /= sum;
    Mat3 scatter = Mat3::Zero();
    for (std::size_t i = 0; i < points.size(); ++i)
      scatter += weight[i] * (points[i] - mean) * (points[i] - mean).transpose();
    const Vec3 n = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(0);
    face.normal = n.dot(face.normal) < 0 ? Vec3(-n) : n;
    face.offset = face.normal.dot(mean);
    scale = std::max(reach, 0.7 * scale);
  }
}

/// Planes by their normals: a convex body has at most one face per direction, and the way out is away from the middle.
std::vector<ConvexFace> planes_of(const FitInput& input, const Vec3& middle, double reach) {
  const auto& points = input.cloud.points;
  std::vector<Vec3> normals(points.size(), Vec3::Zero());
  std::vector<std::uint32_t> open;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i >= input.cloud.normals.size() || !(input.cloud.normals[i].squaredNorm() > 0.5)) continue;
    const Vec3& n = input.cloud.normals[i];
    normals[i] = !input.oriented && n.dot(points[i] - middle) < 0 ? Vec3(-n) : n;
    open.push_back(static_cast<std::uint32_t>(i));
  }
  const std::size_t least = std::max<std::size_t>(25, points.size() / 100);
  std::vector<ConvexFace> faces;
  for (std::size_t attempt = 0; attempt < 2 * most_faces && faces.size() < most_faces && open.size() >= least;
       ++attempt) {
    // The direction that most normals share, among a few hundred of them, judged by a few thousand.
    const std::size_t seed_step = std::max<std::size_t>(1, open.size() / 300),
                      judge_step = std::max<std::size_t>(1, open.size() / 5000);
    std::size_t best = 0, best_votes = 0;
    for (std::size_t s = 0; s < open.size(); s += seed_step) {
      std::size_t votes = 0;
      for (std::size_t j = 0; j < open.size(); j += judge_step) votes += normals[open[s]].dot(normals[open[j]]) > 0.985;
      if (votes > best_votes) best_votes = votes, best = s;
    }
    Vec3 direction = normals[open[best]];
    for (double narrow : {0.97, 0.985, 0.99}) {
      Vec3 sum = Vec3::Zero();
      for (std::uint32_t i : open)
        if (normals[i].dot(direction) > narrow) sum += normals[i];
      if (sum.norm() > 0) direction = sum.normalized();
    }
    std::vector<Vec3> members;
    std::vector<double> offsets;
    for (std::uint32_t i : open)
      if (normals[i].dot(direction) > 0.94) members.push_back(points[i]), offsets.push_back(direction.dot(points[i]));
    if (members.size() < least) break;
    ConvexFace face{direction, median(offsets), 0};
    fit_plane(face, members, reach, 12);
    std::vector<std::uint32_t> left;
    for (std::uint32_t i : open) {
      const bool on =
          std::abs(face.normal.dot(points[i]) - face.offset) < 1.5 * reach && normals[i].dot(face.normal) > 0.8;
      if (on)
        ++face.points;
      else
        left.push_back(i);
    }
    if (face.points < least) {  // a round place or clutter: set its points aside
      std::vector<std::uint32_t> other;
      for (std::uint32_t i : open)
        if (!(normals[i].dot(direction) > 0.985)) other.push_back(i);
      if (other.size() == open.size()) break;
      open.swap(other);
      continue;
    }
    open.swap(left);
    faces.push_back(face);
  }
  return faces;
}

/// The body, if it is bounded and no larger than the data: walls that are parallel except for noise meet far away.
std::optional<ConvexPolyhedron> body_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  auto body = convex_polyhedron(planes_only(faces));
  if (!body) return std::nullopt;
  const double slack = 0.15 * input.bounds.diagonal();
  for (const Vec3& v : body->vertices)
    if (!((v - input.bounds.low).minCoeff() > -slack && (input.bounds.high - v).minCoeff() > -slack))
      return std::nullopt;
  return body;
}

/// Of the edges where scanned faces meet unscanned ones, the share along which the data come up to the edge.
double edges_reached(const ConvexPolyhedron& body, const std::vector<ConvexFace>& faces, const FitInput& input,
                     double reach) {
  const double near = 3 * std::max(input.thin_spacing, input.sampling.spacing) + 2 * reach;
  std::size_t asked = 0, reached = 0;
  std::vector<std::size_t> scanned_of;
  for (std::size_t closing = 0; closing < faces.size(); ++closing) {
    if (faces[closing].points > 0 || body.faces[closing].size() < 3) continue;
    const auto& loop = body.faces[closing];
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Vec3 a = body.vertices[loop[k]], b = body.vertices[loop[(k + 1) % loop.size()]];
      const Vec3 centre = 0.5 * (a + b);
      // The scanned face on the other side of this edge, if it is one.
      bool scanned = false;
      for (std::size_t f = 0; f < faces.size(); ++f)
        scanned =
            scanned || (f != closing && faces[f].points > 0 &&
                        std::abs(faces[f].normal.dot(centre) - faces[f].offset) < 1e-6 * (1 + input.bounds.diagonal()));
      if (!scanned) continue;
      const Vec3 along = (b - a).normalized();
      const double length = (b - a).norm();
      constexpr int cells = 20;
      std::array<bool, cells> hit = {};
      const std::size_t stride = std::max<std::size_t>(1, input.cloud.size() / 6000);
      for (std::size_t i = 0; i < input.cloud.size(); i += stride) {
        const Vec3& p = input.cloud.points[i];
        const double t = along.dot(p - a);
        if (t < 0 || t >= length || (p - a - t * along).norm() > near) continue;
        hit[static_cast<std::size_t>(std::min(cells - 1, static_cast<int>(t / length * cells)))] = true;
      }
      asked += cells;
      reached += static_cast<std::size_t>(std::count(hit.begin(), hit.end(), true));
    }
  }
  return asked == 0 ? 0 : static_cast<double>(reached) / static_cast<double>(asked);
}

/// Area of the scanned faces, cut off at a box well around the data where nothing else bounds them.
double scanned_area(std::vector<ConvexFace> faces, const Box3& around) {
  for (int k = 0; k < 3; ++k)
    faces.push_back({Vec3::Unit(k), around.high[k], 0}), faces.push_back({-Vec3::Unit(k), -around.low[k], 0});
  const auto body = convex_polyhedron(planes_only(faces));
  if (!body) return 1e300;
  double area = 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (faces[f].points > 0) area += face_area(*body, f);
  return area;
}

/// Turns the last face, always at the end of the points, to where the scanned faces become smallest.
double turn_last(std::vector<ConvexFace>& faces, const std::vector<Vec3>& on, const Box3& around) {
  double best = scanned_area(faces, around);
  for (double step = 0.3; step > 0.01;) {
    const Vec3 n = faces.back().normal, u = n.unitOrthogonal(), v = n.cross(u);
    bool better = false;
    for (int k = 0; k < 8; ++k) {
      const double angle = k * pi / 4;
      const ConvexFace before = faces.back();
      faces.back() = closing_face(on, (n + step * (std::cos(angle) * u + std::sin(angle) * v)).normalized());
      const double area = scanned_area(faces, around);
      if (area < best * (1 - 1e-6))
        best = area, better = true;
      else
        faces.back() = before;
    }
    if (!better) step /= 2;
  }
  return best;
}

/// The smallest body around the points: each unscanned face is put where it cuts most off the scanned ones. Whether the
/// hidden side has more faces cannot be determined from the data.
bool close_freely(std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  constexpr std::size_t most_added = 5;
  constexpr int directions = 80;
  constexpr double worth_it = 0.04;  // of the area
  const std::vector<Vec3> all = points_on(faces, input, reach);
  std::vector<Vec3> on;
  for (std::size_t i = 0, step = std::max<std::size_t>(1, all.size() / 4000); i < all.size(); i += step)
    on.push_back(all[i]);
  Box3 around;
  const Vec3 margin = Vec3::Constant(0.3 * input.bounds.diagonal());
  around.add(input.bounds.low - margin), around.add(input.bounds.high + margin);
  const std::size_t scanned = faces.size();
  double area = scanned_area(faces, around);
  while (faces.size() < scanned + most_added) {
    std::vector<ConvexFace> best = faces;
    double least = area;
    for (int k = 0; k < directions; ++k) {  // even on the sphere (Fibonacci's lattice)
      const double z = 1 - (2 * k + 1.0) / directions, r = std::sqrt(1 - z * z), angle = 2.399963229728653 * k;
      std::vector<ConvexFace> trial = faces;
      trial.push_back(closing_face(on, {r * std::cos(angle), r * std::sin(angle), z}));
      const double now = scanned_area(trial, around);
      if (now < least) least = now, best = std::move(trial);
    }
    if (best.size() == faces.size()) break;
    least = turn_last(best, on, around);
    const bool bounded = body_of(faces, input).has_value();
    if (bounded && least > (1 - worth_it) * area) break;
    faces = std::move(best), area = least;
  }
  // Each once more, now that the others stand; one that cuts little is dropped.
  for (std::size_t k = scanned; k < faces.size(); ++k) {
    std::rotate(faces.begin() + static_cast<std::ptrdiff_t>(scanned),
                faces.begin() + static_cast<std::ptrdiff_t>(scanned) + 1, faces.end());
    area = turn_last(faces, on, around);
  }
  for (std::size_t k = faces.size(); k-- > scanned;) {
    std::vector<ConvexFace> fewer = faces;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    if (!body_of(fewer, input) || scanned_area(fewer, around) > (1 + worth_it) * area) continue;
    faces = std::move(fewer), area = scanned_area(faces, around);
  }
  return body_of(faces, input).has_value();
}

/// Adds unscanned faces that are opposite or perpendicular to scanned ones, until the body is bounded; false if the
/// data do not reach the edges that this gives.
bool close_regularly(std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  const std::vector<Vec3> on = points_on(faces, input, reach);
  // One missing face: the areas times normals of a closed body sum to zero, so the scanned ones name the last. What
  // is measured so is rough; opposite to a face or perpendicular to two it is taken as exactly that.
  std::vector<std::vector<ConvexFace>> trials;
  Vec3 missing = Vec3::Zero();
  for (const ConvexFace& f : faces) missing -= static_cast<double>(f.points) * f.normal;
  if (missing.norm() > 0) {
    missing.normalize();
    for (const ConvexFace& f : faces)
      if (-f.normal.dot(missing) > 0.9) trials.push_back({closing_face(on, -f.normal)});
    for (std::size_t i = 0; i < faces.size(); ++i)
      for (std::size_t j = i + 1; j < faces.size(); ++j) {
        const Vec3 n = faces[i].normal.cross(faces[j].normal);
        if (n.norm() < 0.3) continue;
        const Vec3 m = n.dot(missing) < 0 ? Vec3(-n.normalized()) : Vec3(n.normalized());
        if (m.dot(missing) > 0.96) trials.push_back({closing_face(on, m)});
      }
    trials.push_back({closing_face(on, missing)});
  }
  // Several missing: the one opposite to each face that has none, and those perpendicular to two.
  std::vector<ConvexFace> opposite;
  for (const ConvexFace& f : faces)
    if (std::none_of(faces.begin(), faces.end(), [&](const ConvexFace& g) { return g.normal.dot(f.normal) < -0.9; }))
      opposite.push_back(closing_face(on, -f.normal));
  for (const ConvexFace& f : opposite) trials.push_back({f});
  if (opposite.size() > 1) trials.push_back(opposite);
  std::vector<ConvexFace> likely = opposite;
  if (faces.size() <= 6) {
    for (std::size_t i = 0; i < faces.size(); ++i)
      for (std::size_t j = i + 1; j < faces.size(); ++j) {
        const Vec3 z = faces[i].normal.cross(faces[j].normal);
        if (z.norm() < 0.3) continue;
        for (const Vec3& n : {Vec3(z), Vec3(-z), Vec3(z.cross(faces[i].normal)), Vec3(-z.cross(faces[i].normal)),
                              Vec3(z.cross(faces[j].normal)), Vec3(-z.cross(faces[j].normal))}) {
          const Vec3 unit = n.normalized();
          const auto near = [&](const ConvexFace& f) { return f.normal.dot(unit) > 0.97; };
          if (likely.size() < 14 && std::none_of(faces.begin(), faces.end(), near) &&
              std::none_of(likely.begin(), likely.end(), near))
            likely.push_back(closing_face(on, unit));
        }
      }
    for (std::size_t i = 0; i < likely.size(); ++i) {
      trials.push_back({likely[i]});
      for (std::size_t j = i + 1; j < likely.size(); ++j) {
        trials.push_back({likely[i], likely[j]});
        for (std::size_t k = j + 1; k < likely.size(); ++k) trials.push_back({likely[i], likely[j], likely[k]});
      }
    }
  }

  // Shadows hide edges as well: where there are outliers, there were shadows.
  double best = input.outlier_share > 0 ? 0.45 : 0.6;
  std::vector<ConvexFace> closed;
  for (const auto& added : trials) {
    std::vector<ConvexFace> all = faces;
    all.insert(all.end(), added.begin(), added.end());
    const auto body = body_of(all, input);
    if (!body) continue;
    // A further face must reduce the cost enough.
    const double share = edges_reached(*body, all, input, reach) - 0.04 * double(added.size() - 1);
    if (share > best + 0.02) best = share, closed = all;
  }
  if (closed.empty()) return false;
  faces = closed;
  return true;
}

/// A face has as many points of a cloud of this size, or is none.
std::size_t least_members(std::size_t points) { return std::max<std::size_t>(20, points / 200); }

/// Together: every point belongs to the face it is outermost of; faces with few points are dropped.
void settle(std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  const auto& points = input.cloud.points;
  const bool outliers = among_outliers(input);
  for (int round = 0; round < (outliers ? 12 : 3); ++round) {
    std::vector<std::vector<Vec3>> members(faces.size()), inner(faces.size());
    for (const Vec3& p : points) {
      std::size_t f = 0;
      double second = 0;
      if (!(std::abs(convex_distance(faces, p, &f, &second)) < 2 * reach)) continue;
      members[f].push_back(p);
      if (second < -4 * reach) inner[f].push_back(p);
    }
    std::vector<ConvexFace> kept;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      if (members[f].size() < least_members(points.size())) continue;
      // Real edges are rounded and tilt narrow faces, so the plane is taken from the points away from them. Outliers
      // tilt it more, and most where few points are left.
      const auto& used = !outliers && 5 * inner[f].size() > 2 * members[f].size() ? inner[f] : members[f];
      fit_plane(faces[f], used,
                outliers ? 1.2 * input.sampling.sigma : std::max(input.sampling.sigma * 2, 0.5 * input.tolerance), 6);
      faces[f].points = members[f].size();
      kept.push_back(faces[f]);
    }
    faces = kept;
  }
}

/// Drops faces whose points the others explain nearly as well: bevels that outliers beside an edge make, and twins.
void drop_superfluous(std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  constexpr double least_gain = 2;  // nats per point; a true face has 2.5 to 6
  while (faces.size() > 2) {
    const double with_all = misfit_of(faces, input);
    double least = least_gain;
    std::size_t worst = faces.size();
    for (std::size_t f = 0; f < faces.size(); ++f) {
      std::vector<ConvexFace> others = faces;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(f));
      const double gain = (misfit_of(others, input) - with_all) / double(faces[f].points);
      if (gain < least) least = gain, worst = f;
    }
    if (worst == faces.size()) return;
    faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(worst));
    settle(faces, input, reach);
  }
}

Vec3 robust_middle(const std::vector<Vec3>& points) {
  Vec3 middle;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> v;
    for (const Vec3& p : points) v.push_back(p[k]);
    middle[k] = 0.5 * (quantile(v, 0.02) + quantile(v, 0.98));
  }
  return middle;
}

}  // namespace

std::vector<ConvexFace> scanned_faces(const FitInput& input, Context& context) {
  const auto& points = input.cloud.points;
  if (points.size() < 100) return {};
  const double reach = reach_of(input);
  std::vector<ConvexFace> faces = planes_of(input, robust_middle(points), reach);
  context.report("plane faces", 0.5);
  context.say("plane faces: " + print_number(double(faces.size())) + " directions");
  // A face is a supporting plane: one with many points outside it belongs to a hollow. Outliers are not counted.
  std::vector<char> surface(points.size(), 1);
  std::size_t surface_points = points.size();
  if (input.surface_share.size() == points.size())
    for (std::size_t i = 0; i < points.size(); ++i)
      if (input.surface_share[i] < 0.8f) surface[i] = 0, --surface_points;
  const double allowed = 0.02 + std::min(0.06, 0.3 * input.outlier_share);
  for (std::size_t i = faces.size(); i-- > 0;) {
    std::size_t beyond = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
      beyond += surface[k] && faces[i].normal.dot(points[k]) - faces[i].offset > 2 * reach;
    if (double(beyond) > allowed * double(surface_points)) faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(i));
  }
  settle(faces, input, reach);
  if (among_outliers(input)) drop_superfluous(faces, input, reach);
  std::stable_sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.points > b.points; });
  std::size_t on = 0;
  for (std::size_t k = 0; k < points.size(); ++k)
    on += surface[k] && std::abs(convex_distance(faces, points[k])) < 1.5 * reach;
  const double share = static_cast<double>(on) / static_cast<double>(std::max<std::size_t>(surface_points, 1));
  context.say("plane faces: " + print_number(double(faces.size())) + " hold " +
              print_number(snapped(100 * share, 0.1)) + " % of the points");
  if (share < 0.97 - allowed) return {};
  context.report("plane faces", 1);
  return faces;
}

std::vector<ConvexFace> with_a_face_more(std::vector<ConvexFace> scanned, const std::vector<ConvexFace>& closed,
                                         const FitInput& input, Context& context) {
  constexpr int draws = 400;
  constexpr double surely = 7;  // nats; odds of a thousand
  const auto& points = input.cloud.points;
  const double reach = reach_of(input);
  std::vector<Vec3> open;
  for (const Vec3& p : points)
    if (std::abs(convex_distance(closed, p)) > reach) open.push_back(p);
  if (open.size() < least_members(points.size())) return {};
  const Vec3 middle = robust_middle(points);
  Random random(11);
  const auto through_three = [&](auto offer) {
    const Vec3 &a = drawn_from(open, random), &b = drawn_from(open, random), &c = drawn_from(open, random);
    Vec3 n = (b - a).cross(c - a);
    if (!(n.norm() > 0)) return;
    n.normalize();
    if (n.dot(a - middle) < 0) n = -n;
    offer({n, n.dot(a), 0});
  };
  // Every point beyond a face counts against it as much as a point on it counts for it.
  const auto support = [&](const ConvexFace& face, double most) {
    double score = 0;
    for (const Vec3& p : open) score += std::abs(face.normal.dot(p) - face.offset) < reach;
    if (score <= most) return score;
    for (const Vec3& p : points) score -= face.normal.dot(p) - face.offset > 2 * reach;
    return score;
  };
  const auto drawn = consensus<ConvexFace>(draws, 0, through_three, support);
  if (!drawn || drawn->support < double(least_members(points.size()))) return {};
  ConvexFace best = drawn->hypothesis;
  best.points = static_cast<std::size_t>(drawn->support);
  // By chance, of points scattered through the body: the best of all planes through three of them (Chernoff's bound).
  std::size_t on = 0;
  for (const Vec3& p : open) on += std::abs(best.normal.dot(p) - best.offset) < reach;
  std::vector<double> along;
  for (const Vec3& p : points) along.push_back(best.normal.dot(p));
  const double chance = 2 * reach / (quantile(along, 0.98) - quantile(along, 0.02)), others = double(open.size() - 3);
  const double share = std::min(double(on - 3) / others, 1 - 1e-9), tests = others * others * others / 6;
  if (!(share > chance)) return {};
  const double nats = others * (share * std::log(share / chance) + (1 - share) * std::log((1 - share) / (1 - chance))) -
                      std::log(tests);
  context.say("plane faces: one more through " + print_number(double(on)) + " of " + print_number(double(open.size())) +
              " points in no other, " + print_number(std::round(nats)) + " nats above chance");
  if (nats < surely) return {};
  const std::size_t before = scanned.size();
  scanned.push_back(best);
  settle(scanned, input, reach);
  std::stable_sort(scanned.begin(), scanned.end(), [](const auto& a, const auto& b) { return a.points > b.points; });
  return scanned.size() > before ? scanned : std::vector<ConvexFace>{};
}

std::vector<ConvexFace> closed_body(std::vector<ConvexFace> faces, const FitInput& input, Context& context) {
  const std::size_t scanned = faces.size();
  const double reach = reach_of(input);
  const bool closed = scanned >= 3 && (body_of(faces, input) || close_regularly(faces, input, reach) ||
                                       close_freely(faces, input, reach));
  if (!closed) {
    context.say("plane faces: the data do not tell how the body is closed");
    return {};
  }
  if (faces.size() > scanned)
    context.say("plane faces: closed by " + print_number(double(faces.size() - scanned)) + " that were not scanned");

  // Planes that only touch the body say nothing.
  const auto body = convex_polyhedron(planes_only(faces));
  ensure(body.has_value(), "a body that was closed is closed");
  std::vector<ConvexFace> result;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (body->faces[f].size() >= 3) result.push_back(faces[f]);
  return result;
}

}  // namespace partscribe::fit
