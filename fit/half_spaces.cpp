/// Convex bodies with plane faces: found by their normals, closed where the data end, named as simply as possible.
#include "fit/half_spaces.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "core/number.h"
#include "core/statistics.h"
#include "geometry/convex.h"

namespace partscribe {

namespace {

constexpr std::size_t most_faces = 24;
constexpr double square_angle = 3 * pi / 180;  // faces this near to a right angle may be meant as one

/// A plane face of a convex body.
struct ConvexFace {
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  double offset = 0;           ///< normal . p = offset, scan's frame
  std::size_t points = 0;      ///< that lie on it; 0: not scanned, the plane closes the body at the end of the data
};

/// Which plane of a convex body a point is nearest to, and how far outside (inside: negative) it is.
/// `second`: the same for the next nearest plane, which tells how near an edge is.
double convex_distance(const std::vector<ConvexFace>& faces, const Vec3& p, std::size_t* face = nullptr,
                       double* second = nullptr) {
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

/// Orthogonal-distance plane through `points` by reweighting from the plane that `face` has; the scale falls to `reach`.
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
  for (std::size_t attempt = 0; attempt < 2 * most_faces && faces.size() < most_faces && open.size() >= least; ++attempt) {
    // The direction that most normals share, among a few hundred of them, judged by a few thousand.
    const std::size_t seed_step = std::max<std::size_t>(1, open.size() / 300), judge_step = std::max<std::size_t>(1, open.size() / 5000);
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
      const bool on = std::abs(face.normal.dot(points[i]) - face.offset) < 1.5 * reach && normals[i].dot(face.normal) > 0.8;
      if (on) ++face.points;
      else left.push_back(i);
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

std::vector<Plane3> planes_only(const std::vector<ConvexFace>& faces) {
  std::vector<Plane3> planes;
  for (const ConvexFace& f : faces) planes.push_back({f.normal, f.offset});
  return planes;
}

double polygon_area(const ConvexPolyhedron& body, std::size_t face) {
  const auto& f = body.faces[face];
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < f.size(); ++i)
    sum += (body.vertices[f[i]] - body.vertices[f[0]]).cross(body.vertices[f[i + 1]] - body.vertices[f[0]]);
  return 0.5 * sum.norm();
}

/// The body, if it is bounded and no larger than the data: walls that are parallel but for noise meet far away.
std::optional<ConvexPolyhedron> body_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  auto body = convex_polyhedron(planes_only(faces));
  if (!body) return std::nullopt;
  const double slack = 0.15 * input.bounds.diagonal();
  for (const Vec3& v : body->vertices)
    if (!((v - input.bounds.low).minCoeff() > -slack && (input.bounds.high - v).minCoeff() > -slack)) return std::nullopt;
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
        scanned = scanned || (f != closing && faces[f].points > 0 &&
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

/// Points on scanned faces: only they say where the data end.
std::vector<Vec3> points_on(const std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  std::vector<Vec3> on;
  for (const Vec3& p : input.cloud.points)
    if (std::abs(convex_distance(faces, p)) < 1.5 * reach) on.push_back(p);
  return on;
}

/// The plane with outward normal `normal` at the end of the points.
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

/// Area of the scanned faces, cut off at a box well around the data where nothing else bounds them.
double scanned_area(std::vector<ConvexFace> faces, const Box3& around) {
  for (int k = 0; k < 3; ++k)
    faces.push_back({Vec3::Unit(k), around.high[k], 0}), faces.push_back({-Vec3::Unit(k), -around.low[k], 0});
  const auto body = convex_polyhedron(planes_only(faces));
  if (!body) return 1e300;
  double area = 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (faces[f].points > 0) area += polygon_area(*body, f);
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
      if (area < best * (1 - 1e-6)) best = area, better = true;
      else faces.back() = before;
    }
    if (!better) step /= 2;
  }
  return best;
}

/// The smallest body around the points: unscanned faces, each where it cuts most off the scanned ones. Where the hidden
/// side has more faces than these, nothing in the data tells.
bool close_freely(std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  constexpr std::size_t most_added = 5;
  constexpr int directions = 80;
  constexpr double worth_it = 0.04;  // of the area
  const std::vector<Vec3> all = points_on(faces, input, reach);
  std::vector<Vec3> on;
  for (std::size_t i = 0, step = std::max<std::size_t>(1, all.size() / 4000); i < all.size(); i += step) on.push_back(all[i]);
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
    std::rotate(faces.begin() + static_cast<std::ptrdiff_t>(scanned), faces.begin() + static_cast<std::ptrdiff_t>(scanned) + 1, faces.end());
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

/// Adds unscanned faces that are opposite or square to scanned ones, until the body is bounded; false if the data do not
/// reach the edges that this gives.
bool close_regularly(std::vector<ConvexFace>& faces, const FitInput& input, double reach) {
  const std::vector<Vec3> on = points_on(faces, input, reach);
  // One missing face: the areas times normals of a closed body sum to zero, so the scanned ones name the last. What
  // is measured so is rough; opposite to a face or square to two it is taken as exactly that.
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
  // Several missing: the one opposite to each face that has none, and those square to two.
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
          if (likely.size() < 14 && std::none_of(faces.begin(), faces.end(), near) && std::none_of(likely.begin(), likely.end(), near))
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

  // Shadows hide edges as well: where there are strays, there were shadows.
  double best = input.stray_share > 0 ? 0.45 : 0.6;
  std::vector<ConvexFace> closed;
  for (const auto& added : trials) {
    std::vector<ConvexFace> all = faces;
    all.insert(all.end(), added.begin(), added.end());
    const auto body = body_of(all, input);
    if (!body) continue;
    // A face more must be worth it.
    const double share = edges_reached(*body, all, input, reach) - 0.04 * double(added.size() - 1);
    if (share > best + 0.02) best = share, closed = all;
  }
  if (closed.empty()) return false;
  faces = closed;
  return true;
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

double reach_of(const FitInput& input) { return std::max(3 * input.sampling.sigma, input.tolerance); }

/// The scanned faces of the convex body that explains the points, largest first; empty if they are not those of one.
std::vector<ConvexFace> scanned_faces(const FitInput& input, Context& context) {
  const auto& points = input.cloud.points;
  if (points.size() < 100) return {};
  const double reach = reach_of(input);
  std::vector<ConvexFace> faces = planes_of(input, robust_middle(points), reach);
  context.report("plane faces", 0.5);
  context.say("plane faces: " + print_number(double(faces.size())) + " directions");
  // A face is a supporting plane: one with many points outside it belongs to a hollow. Strays have no say.
  std::vector<char> surface(points.size(), 1);
  std::size_t surface_points = points.size();
  if (input.surface_share.size() == points.size())
    for (std::size_t i = 0; i < points.size(); ++i)
      if (input.surface_share[i] < 0.8f) surface[i] = 0, --surface_points;
  const double allowed = 0.02 + std::min(0.06, 0.3 * input.stray_share);
  for (std::size_t i = faces.size(); i-- > 0;) {
    std::size_t beyond = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
      beyond += surface[k] && faces[i].normal.dot(points[k]) - faces[i].offset > 2 * reach;
    if (double(beyond) > allowed * double(surface_points)) faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(i));
  }
  // Together: every point belongs to the face it is outermost of.
  for (int round = 0; round < 3; ++round) {
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
      if (members[f].size() < std::max<std::size_t>(20, points.size() / 200)) continue;
      // Real edges are rounded and tilt narrow faces, so the plane is taken from the points away from them.
      const auto& used = 5 * inner[f].size() > 2 * members[f].size() ? inner[f] : members[f];
      fit_plane(faces[f], used, std::max(input.sampling.sigma * 2, 0.5 * input.tolerance), 6);
      faces[f].points = members[f].size();
      kept.push_back(faces[f]);
    }
    faces = kept;
  }
  std::stable_sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.points > b.points; });
  std::size_t on = 0;
  for (std::size_t k = 0; k < points.size(); ++k) on += surface[k] && std::abs(convex_distance(faces, points[k])) < 1.5 * reach;
  const double share = static_cast<double>(on) / static_cast<double>(std::max<std::size_t>(surface_points, 1));
  context.say("plane faces: " + print_number(double(faces.size())) + " hold " + print_number(snapped(100 * share, 0.1)) + " % of the points");
  if (share < 0.97 - allowed) return {};
  context.report("plane faces", 1);
  return faces;
}

/// The faces with those that close the body where nothing was scanned; empty if the data do not tell.
std::vector<ConvexFace> closed_body(std::vector<ConvexFace> faces, const FitInput& input, Context& context) {
  const std::size_t scanned = faces.size();
  const double reach = reach_of(input);
  const bool closed = scanned >= 3 && (body_of(faces, input) || close_regularly(faces, input, reach) || close_freely(faces, input, reach));
  if (!closed) {
    context.say("plane faces: the data do not tell how the body is closed");
    return {};
  }
  if (faces.size() > scanned) context.say("plane faces: closed by " + print_number(double(faces.size() - scanned)) + " that were not scanned");

  // Planes that only touch the body say nothing.
  const auto body = convex_polyhedron(planes_only(faces));
  ensure(body.has_value(), "a body that was closed is closed");
  std::vector<ConvexFace> result;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (body->faces[f].size() >= 3) result.push_back(faces[f]);
  return result;
}

Parameter length_parameter(const std::string& name, double value, const std::string& note) {
  Parameter p;
  p.name = name, p.quantity = Quantity::length, p.value = p.fitted = value, p.note = note;
  return p;
}

/// The rotation whose columns are nearest to the measured directions, each with its weight.
Mat3 frame_from(const std::vector<std::pair<int, Vec3>>& directions, const std::vector<double>& weights) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < directions.size(); ++i)
    sum += weights[i] * directions[i].second * Vec3::Unit(directions[i].first).transpose();
  const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 fix = Mat3::Identity();
  fix(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * fix * svd.matrixV().transpose();
}

double face_weight(const ConvexFace& f) { return static_cast<double>(f.points) + 1; }

/// Median position along `axis` of the points on a face; for a face that was not scanned, where its plane was put.
double level_along(const Vec3& axis, const ConvexFace& face, const std::vector<ConvexFace>& faces, const FitInput& input,
                   double reach) {
  std::vector<double> v;
  if (face.points > 0)
    for (const Vec3& p : input.cloud.points) {
      std::size_t f = 0;
      if (std::abs(convex_distance(faces, p, &f)) < 2 * reach && &faces[f] == &face) v.push_back(axis.dot(p));
    }
  if (!v.empty()) return median(std::move(v));
  return face.offset * (face.normal.dot(axis) < 0 ? -1 : 1);
}

std::string closing_note(const ConvexFace& a, const ConvexFace& b) {
  return a.points > 0 && b.points > 0 ? "" : "; one of its two faces was not scanned, the data end there";
}

/// Three pairs of parallel faces at right angles.
std::optional<Candidate> box_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  if (faces.size() != 6) return std::nullopt;
  const double parallel = std::cos(square_angle), square = std::sin(square_angle);
  std::array<std::pair<std::size_t, std::size_t>, 3> pairs;
  std::vector<bool> used(6, false);
  for (int k = 0; k < 3; ++k) {
    std::size_t a = 0;
    while (used[a]) ++a;
    used[a] = true;
    std::size_t b = 6;
    for (std::size_t j = 0; j < 6; ++j)
      if (!used[j] && faces[j].normal.dot(faces[a].normal) < -parallel) b = j;
    if (b == 6) return std::nullopt;
    used[b] = true;
    pairs[static_cast<std::size_t>(k)] = {a, b};
  }
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < k; ++l)
      for (std::size_t i : {pairs[static_cast<std::size_t>(k)].first, pairs[static_cast<std::size_t>(k)].second})
        for (std::size_t j : {pairs[static_cast<std::size_t>(l)].first, pairs[static_cast<std::size_t>(l)].second})
          if (std::abs(faces[i].normal.dot(faces[j].normal)) > square) return std::nullopt;

  // Longest side along x, next along y; within each pair the face to the front is that towards +x, +y, +z of the scan.
  std::array<double, 3> size;
  for (std::size_t k = 0; k < 3; ++k) size[k] = faces[pairs[k].first].offset + faces[pairs[k].second].offset;
  std::array<std::size_t, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b] + 1e-9; });
  std::array<std::pair<std::size_t, std::size_t>, 3> axis;  // (far face, near face)
  for (std::size_t k = 0; k < 3; ++k) {
    axis[k] = pairs[order[k]];
    int big = 0;
    faces[axis[k].first].normal.cwiseAbs().maxCoeff(&big);
    if (faces[axis[k].first].normal[big] < 0) std::swap(axis[k].first, axis[k].second);
  }
  if (faces[axis[0].first].normal.cross(faces[axis[1].first].normal).dot(faces[axis[2].first].normal) < 0)
    std::swap(axis[1].first, axis[1].second);  // z keeps its way up
  std::vector<std::pair<int, Vec3>> directions;
  std::vector<double> weights;
  for (int k = 0; k < 3; ++k) {
    const auto& [far, near] = axis[static_cast<std::size_t>(k)];
    directions.emplace_back(k, faces[far].normal), weights.push_back(face_weight(faces[far]));
    directions.emplace_back(k, -faces[near].normal), weights.push_back(face_weight(faces[near]));
  }
  const Mat3 frame = frame_from(directions, weights);
  const double reach = reach_of(input);
  Vec3 corner, far_corner;
  std::array<std::string, 3> notes;
  for (int k = 0; k < 3; ++k) {
    const auto& [far, near] = axis[static_cast<std::size_t>(k)];
    corner[k] = level_along(frame.col(k), faces[near], faces, input, reach);
    far_corner[k] = level_along(frame.col(k), faces[far], faces, input, reach);
    notes[static_cast<std::size_t>(k)] = closing_note(faces[far], faces[near]);
  }
  const Vec3 extent = far_corner - corner;
  if (!(extent.minCoeff() > 0)) return std::nullopt;
  Candidate c;
  c.procedure = "box", c.object_name = "block";
  c.shape = Box{Expr::of("length"), Expr::of("width"), Expr::of("height")};
  c.parameters = {length_parameter("length", extent.x(), "longest side of the block" + notes[0]),
                  length_parameter("width", extent.y(), "second side of the block" + notes[1]),
                  length_parameter("height", extent.z(), "shortest side of the block" + notes[2])};
  c.scan_from_part = {frame, frame * corner};
  return c;
}

/// A block by the two largest faces that are square to each other, whatever the others say: a weak face may be a curtain's or
/// lean. Sides that were not scanned are put where the data end.
std::optional<Candidate> block_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  constexpr double nearly = 0.12;  // of a right angle, 7 degrees
  if (faces.size() < 2) return std::nullopt;
  std::size_t second = 1;
  while (second < faces.size() && std::abs(faces[second].normal.dot(faces[0].normal)) > nearly) ++second;
  if (second == faces.size()) return std::nullopt;
  const Mat3 frame = frame_from({{0, faces[0].normal}, {1, faces[second].normal}, {2, faces[0].normal.cross(faces[second].normal)}},
                                {face_weight(faces[0]), face_weight(faces[second]), 1});
  std::vector<ConvexFace> sides;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0})
      for (const ConvexFace& f : faces)
        if (sign * frame.col(k).dot(f.normal) > 1 - nearly * nearly / 2) {
          sides.push_back(f);
          break;
        }
  // A face beside these that is more than strays make is none of a block.
  const auto points = [](const std::vector<ConvexFace>& list) {
    double sum = 0;
    for (const ConvexFace& f : list) sum += double(f.points);
    return sum;
  };
  if (points(sides) < (1 - input.stray_share) * points(faces)) return std::nullopt;
  const double reach = reach_of(input);
  const std::vector<Vec3> on = points_on(sides, input, reach);
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0}) {
      const Vec3 n = sign * frame.col(k);
      const auto same = [&](const ConvexFace& f) { return f.normal.dot(n) > 1 - nearly * nearly / 2; };
      if (std::none_of(sides.begin(), sides.end(), same)) sides.push_back(closing_face(on, n));
    }
  for (ConvexFace& f : sides) {
    // Square, about the middle of its points.
    Vec3 n = f.normal;
    int axis = 0;
    (frame.transpose() * f.normal).cwiseAbs().maxCoeff(&axis);
    n = (frame.col(axis).dot(f.normal) < 0 ? -1 : 1) * frame.col(axis);
    std::vector<double> levels;
    if (f.points > 0)
      for (const Vec3& p : on)
        if (std::abs(f.normal.dot(p) - f.offset) < reach) levels.push_back(n.dot(p));
    f = {n, levels.empty() ? f.offset : median(std::move(levels)), f.points};
  }
  return box_of(sides, input);
}

/// A prism between two parallel faces whose section is a triangle or trapezoid with a right angle.
std::optional<Candidate> wedge_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  if (faces.size() != 5 && faces.size() != 6) return std::nullopt;
  const double parallel = std::cos(square_angle), square = std::sin(square_angle), reach = reach_of(input);
  const auto body = convex_polyhedron(planes_only(faces));
  if (!body) return std::nullopt;
  for (std::size_t a = 0; a < faces.size(); ++a)
    for (std::size_t b = a + 1; b < faces.size(); ++b) {
      if (faces[a].normal.dot(faces[b].normal) > -parallel) continue;
      const Vec3 z = (faces[a].normal - faces[b].normal).normalized();
      std::vector<std::size_t> sides;
      bool prism = true;
      for (std::size_t i = 0; i < faces.size(); ++i) {
        if (i == a || i == b) continue;
        sides.push_back(i);
        prism = prism && std::abs(faces[i].normal.dot(z)) < square;
      }
      if (!prism) continue;
      // y = 0 and x = 0 at right angles; with four sides the third is parallel to y = 0, shorter, and the last slopes.
      for (std::size_t y0 : sides)
        for (std::size_t x0 : sides) {
          if (x0 == y0 || std::abs(faces[x0].normal.dot(faces[y0].normal)) > square) continue;
          std::vector<std::size_t> rest;
          for (std::size_t i : sides)
            if (i != x0 && i != y0) rest.push_back(i);
          std::size_t slope = rest[0], top = faces.size();
          if (rest.size() == 2) {
            top = faces[rest[0]].normal.dot(faces[y0].normal) < -parallel ? rest[0] : rest[1];
            if (faces[top].normal.dot(faces[y0].normal) > -parallel) continue;
            slope = top == rest[0] ? rest[1] : rest[0];
          }
          const Vec3& ns = faces[slope].normal;
          if (ns.dot(faces[x0].normal) > -std::sin(square_angle) || -ns.dot(faces[y0].normal) < square) continue;
          // Of the two ways to read a triangle take the one with the longer foot.
          if (top == faces.size() && polygon_area(*body, y0) < polygon_area(*body, x0) - 1e-9) continue;

          std::vector<std::pair<int, Vec3>> directions = {{0, -faces[x0].normal}, {1, -faces[y0].normal}};
          std::vector<double> weights = {face_weight(faces[x0]), face_weight(faces[y0])};
          if (top < faces.size()) directions.emplace_back(1, faces[top].normal), weights.push_back(face_weight(faces[top]));
          const Vec3 up = directions[0].second.cross(directions[1].second).dot(z) > 0 ? z : Vec3(-z);
          directions.emplace_back(2, up), weights.push_back(face_weight(faces[a]) + face_weight(faces[b]));
          const Mat3 frame = frame_from(directions, weights);
          const std::size_t low = faces[a].normal.dot(up) < 0 ? a : b, high = low == a ? b : a;
          const Vec3 corner(level_along(frame.col(0), faces[x0], faces, input, reach),
                            level_along(frame.col(1), faces[y0], faces, input, reach),
                            level_along(frame.col(2), faces[low], faces, input, reach));
          const double size_z = level_along(frame.col(2), faces[high], faces, input, reach) - corner.z();
          // The slope's line in the section: nx x + ny y = c from the corner.
          const double nx = frame.col(0).dot(ns), ny = frame.col(1).dot(ns);
          const double c0 = faces[slope].offset - ns.dot(frame * corner);
          const double size_x = c0 / nx;
          double size_y = c0 / ny, top_x = 0;
          if (top < faces.size()) {
            size_y = level_along(frame.col(1), faces[top], faces, input, reach) - corner.y();
            top_x = (c0 - ny * size_y) / nx;
          }
          if (!(size_x > 0 && size_y > 0 && size_z > 0 && top_x >= 0)) continue;
          Candidate c;
          c.procedure = "wedge", c.object_name = "wedge_block";
          Wedge wedge{Expr::of("foot_length"), Expr::of("height"), Expr::of("width"), 0};
          c.parameters = {length_parameter("foot_length", size_x, "length of the foot, along x at y = 0"),
                          length_parameter("height", size_y, "height above the foot, along y"),
                          length_parameter("width", size_z, "width between the two parallel cheeks, along z")};
          if (top < faces.size()) {
            wedge.top_x = Expr::of("top_length");
            c.parameters.push_back(length_parameter("top_length", top_x, "length left at the full height"));
          }
          c.shape = wedge;
          c.scan_from_part = {frame, frame * corner};
          return c;
        }
    }
  return std::nullopt;
}

/// Any convex body: its largest face on top, standing on its lowest place, x along the longest edge of the top.
std::optional<Candidate> half_spaces_of(const std::vector<ConvexFace>& faces) {
  const auto body = convex_polyhedron(planes_only(faces));
  if (!body) return std::nullopt;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < faces.size(); ++i) order.push_back(i);
  std::vector<double> area;
  for (std::size_t i = 0; i < faces.size(); ++i) area.push_back(polygon_area(*body, i));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return area[i] > area[j]; });
  const auto& top = body->faces[order[0]];
  const Vec3 z = faces[order[0]].normal;
  Vec3 edge = Vec3::Zero();
  for (std::size_t k = 0; k < top.size(); ++k) {
    const Vec3 e = body->vertices[top[(k + 1) % top.size()]] - body->vertices[top[k]];
    if (e.norm() > edge.norm() + 1e-9) edge = e;
  }
  Vec3 x = (edge - z * z.dot(edge)).normalized();
  int big = 0;
  x.cwiseAbs().maxCoeff(&big);
  if (x[big] < 0) x = -x;
  Mat3 frame;
  frame << x, z.cross(x), z;
  Vec3 middle = Vec3::Zero();
  double lowest = 1e300;
  for (const Vec3& v : body->vertices)
    middle += v / static_cast<double>(body->vertices.size()), lowest = std::min(lowest, z.dot(v));
  const Vec3 origin = middle + z * (lowest - z.dot(middle));

  Candidate c;
  c.procedure = "convex polyhedron", c.object_name = "polyhedron";
  HalfSpaces shape;
  int number = 0;
  for (std::size_t i : order) {
    const std::string name = "face_" + std::to_string(++number);
    const Vec3 n = frame.transpose() * faces[i].normal;
    HalfSpace half{n.x(), n.y(), n.z(), Expr::of(name + "_offset"), "face " + std::to_string(number)};
    shape.planes.push_back(half);
    Parameter p = length_parameter(name + "_offset", faces[i].offset - faces[i].normal.dot(origin),
                                   "distance of face " + std::to_string(number) + " from the origin along its normal");
    if (faces[i].points == 0) p.note += "; not scanned, the data end there";
    c.parameters.push_back(p);
  }
  c.shape = shape;
  c.scan_from_part = {frame, origin};
  c.extra_numbers = 2 * number;  // a direction is two numbers
  return c;
}

}  // namespace

std::vector<Candidate> propose_polyhedra(const FitInput& input, Context& context) {
  const std::vector<ConvexFace> scanned = scanned_faces(input, context);
  const std::vector<ConvexFace> faces = closed_body(scanned, input, context);
  std::vector<Candidate> result;
  if (auto box = box_of(faces, input)) {
    result.push_back(*box);
  } else {
    const bool strays = input.stray_share > 0;
    if (auto block = strays ? block_of(scanned, input) : std::nullopt) result.push_back(*block);
    if (auto wedge = wedge_of(faces, input)) result.push_back(*wedge);
  }
  if (faces.size() >= 4)
    if (auto any = half_spaces_of(faces)) result.push_back(*any);
  return result;
}

}  // namespace partscribe
