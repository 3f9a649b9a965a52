// Which faces of the file were found, and which are none.
#include "score.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/number.h"
#include "core/statistics.h"

namespace bench {
namespace {

std::string printed(const char* format, auto... values) {
  char text[300];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string words_of(FaceKind kind, const Primitive& p, bool hollow, const Vec3& middle) {
  std::string text = name_of(kind);
  if (kind != FaceKind::plane && kind != FaceKind::free_form)
    text += printed(hollow ? ", hollow, radius %.3f" : ", radius %.3f", p.radius);
  if (kind == FaceKind::torus) text += printed(", tube %.3f", p.tube);
  if (kind == FaceKind::cone) text += printed(", half angle %.2f", degrees(p.half_angle));
  text += printed(" about (%.2f %.2f %.2f)", middle.x(), middle.y(), middle.z());
  if (kind != FaceKind::sphere && kind != FaceKind::free_form)
    text += printed(kind == FaceKind::plane ? ", normal (%.3f %.3f %.3f)" : ", axis (%.3f %.3f %.3f)", p.axis.x(),
                    p.axis.y(), p.axis.z());
  return text;
}

std::string words_of(const TrueFace& face) { return words_of(face.kind, face.surface, face.hollow, face.middle); }
std::string words_of(const Face& face) { return words_of(face.kind, face.surface(), face.hollow, face.middle); }

bool closed_form(FaceKind kind) { return kind != FaceKind::free_form; }

/// How far a reported surface is from that of the file.
struct Difference {
  double place = 0;   // mm, median over the face
  double radius = 0;  // largest relative error of a radius
  double angle = 0;   // degrees, axis or half angle
  bool inside_out = false;
};

double radius_beside(const Primitive& truth, const Primitive& p) {
  if (p.kind != PrimitiveKind::cone) return p.radius;
  return p.radius + (truth.point - p.point).dot(p.axis) * std::tan(p.half_angle);
}

Difference difference(const Truth& truth, const TrueFace& face, const Face& reported) {
  const Primitive &t = face.surface, &p = reported.surface();
  Difference d;
  std::vector<double> distances;
  for (const auto triangle : face.triangles)
    for (int k = 0; k < 3; ++k) distances.push_back(std::abs(distance(p, truth.mesh.corner(triangle, k))));
  d.place = median(std::move(distances));
  if (face.kind != FaceKind::sphere)
    d.angle = degrees(std::atan2(t.axis.cross(p.axis).norm(), std::abs(t.axis.dot(p.axis))));
  if (face.kind == FaceKind::cone) d.angle = std::max(d.angle, degrees(std::abs(t.half_angle - p.half_angle)));
  if (face.kind != FaceKind::plane) d.radius = std::abs(radius_beside(t, p) / t.radius - 1);
  if (face.kind == FaceKind::torus) d.radius = std::max(d.radius, std::abs(p.tube / t.tube - 1));
  d.inside_out = face.kind == FaceKind::plane ? t.axis.dot(p.axis) < 0 : face.hollow != reported.hollow;
  return d;
}

bool same_surface(const Difference& d, const ScoreOptions& options) {
  if (!(d.place <= options.place)) return false;
  return options.of_scan || (d.radius <= options.radius && d.angle <= options.angle);
}

bool lies_on(const Truth& truth, std::uint32_t triangle, const Primitive& surface, double bound) {
  for (int k = 0; k < 3; ++k)
    if (!(std::abs(distance(surface, truth.mesh.corner(triangle, k))) <= bound)) return false;
  return true;
}

/// Numbers of a face found in a scan beside the sigmas stated for them; those outside are put into words.
void judge_numbers(const TrueFace& face, const Face& reported, Score& score) {
  const Primitive &t = face.surface, &p = reported.surface();
  const PrimitiveFit& fit = reported.fit;
  const auto judge = [&](Within& within, const char* what, double error, double sigma) {
    within.add(error, sigma);
    if (error > 3 * sigma)
      score.words.push_back(std::string("  outside: ") + name_of(face.kind) + ", " + what + " off by " +
                            std::to_string(error) + ", sigma " + std::to_string(sigma) + ", " +
                            std::to_string(reported.points) + " points, rms " + std::to_string(fit.rms));
  };
  const Vec3 away = p.point - t.point;
  const Vec3 across = away - away.dot(t.axis) * t.axis;
  switch (face.kind) {
    case FaceKind::plane:
      judge(score.offsets, "offset", std::abs(away.dot(t.axis)), fit.sigma_point);
      break;
    case FaceKind::cylinder:
    case FaceKind::cone:
      judge(score.offsets, "axis", across.norm(), fit.sigma_point);
      break;
    default:
      judge(score.offsets, "centre", away.norm(), fit.sigma_point);
  }
  if (face.kind == FaceKind::cone)  // where the fit states its sigma
    judge(score.radii, "radius", std::abs(p.radius - t.radius - away.dot(t.axis) * std::tan(t.half_angle)),
          fit.sigma_radius);
  else if (face.kind != FaceKind::plane)
    judge(score.radii, "radius", std::abs(p.radius - t.radius), fit.sigma_radius);
  if (face.kind == FaceKind::torus) judge(score.radii, "tube", std::abs(p.tube - t.tube), fit.sigma_tube);
  if (face.kind != FaceKind::sphere)
    score.axes.add(std::atan2(t.axis.cross(p.axis).norm(), std::abs(t.axis.dot(p.axis))), fit.sigma_axis);
}

/// One reported face on one face of the file.
struct Overlap {
  std::uint32_t face;
  double share;  // of the face of the file
  bool same;
};

}  // namespace

Score& Score::operator+=(const Score& o) {
  truth += o.truth, unseen += o.unseen, found += o.found, inside_out += o.inside_out, split += o.split;
  wrong_kind += o.wrong_kind, off += o.off, missing += o.missing, reported += o.reported, none += o.none;
  free += o.free, free_found += o.free_found, vague += o.vague, alike += o.alike, area += o.area,
      right_area += o.right_area;
  radii += o.radii, offsets += o.offsets, axes += o.axes, seconds += o.seconds;
  return *this;
}

Score score(const Truth& truth, const std::vector<Place>& places, const Faces& faces, const ScoreOptions& options) {
  Score result;
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> common;
  std::vector<double> true_weight(truth.faces.size(), 0), weight(faces.faces.size(), 0), right(faces.faces.size(), 0),
      closed(faces.faces.size(), 0), alike(faces.faces.size(), 0);
  double all = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [triangle, w] = places[i];
    const auto t = triangle == no_triangle ? no_face : truth.face_of[triangle];
    const auto r = faces.face_of[i];
    if (t != no_face) true_weight[t] += w, all += w;
    if (r != no_face) weight[r] += w;
    if (t == no_face || r == no_face) continue;
    common[{t, r}] += w;
    if (closed_form(truth.faces[t].kind))
      closed[r] += w;
    else if (closed_form(faces.faces[r].kind) && lies_on(truth, triangle, faces.faces[r].surface(), options.alike))
      alike[r] += w;
  }

  auto at = common.begin();
  for (std::uint32_t t = 0; t < truth.faces.size(); ++t) {
    const TrueFace& face = truth.faces[t];
    std::vector<Overlap> overlaps;
    for (; at != common.end() && at->first.first == t; ++at) {
      const auto r = at->first.second;
      const Face& reported = faces.faces[r];
      Overlap overlap{r, at->second / true_weight[t], false};
      if (reported.kind == face.kind)
        overlap.same = !closed_form(face.kind) || same_surface(difference(truth, face, reported), options);
      if (overlap.same) right[r] += at->second;
      overlaps.push_back(overlap);
    }
    if (face.area < options.least_share * truth.area) continue;
    double same = 0, any = 0, largest = 0;
    int pieces = 0;
    const Overlap *first = nullptr, *best = nullptr;
    for (const auto& o : overlaps) {
      any += o.share;
      if (!best || o.share > best->share) best = &o;
      if (!o.same) continue;
      same += o.share;
      pieces += o.share > 0.05;
      if (o.share > largest) largest = o.share, first = &o;
    }
    if (!closed_form(face.kind)) {
      ++result.free, result.free_found += same >= 0.5;
      continue;
    }
    // Half a percent of the area should bear half a percent of the points; less than a twentieth of it is unseen.
    if (true_weight[t] < std::max(options.of_scan ? 30.0 : 0.0, 0.05 * all * face.area / truth.area)) {
      ++result.unseen;
      continue;
    }
    ++result.truth;
    result.area += face.area, result.right_area += same * face.area;
    if (same >= 0.5) {
      ++result.found, result.split += pieces > 1;
      result.inside_out += difference(truth, face, faces.faces[first->face]).inside_out;
      if (options.of_scan) judge_numbers(face, faces.faces[first->face], result);
      continue;
    }
    std::string words =
        printed("missed: %s, %.1f mm2 (%.2f %%): ", words_of(face).c_str(), face.area, 100 * face.area / truth.area);
    if (!best || any < 0.5) {
      ++result.missing;
      words += printed("%.0f %% of it belongs to no face", 100 * (1 - any));
    } else if (faces.faces[best->face].kind != face.kind) {
      ++result.wrong_kind;
    } else {
      ++result.off;
    }
    if (best) {
      const Face& reported = faces.faces[best->face];
      words += printed("%s%.0f %% is face %u: %s", any < 0.5 ? "; " : "", 100 * best->share, best->face,
                       words_of(reported).c_str());
      if (reported.kind == face.kind) {
        const Difference d = difference(truth, face, reported);
        words += printed("; off by %.4f mm, radius %.2f %%, angle %.3f", d.place, 100 * d.radius, d.angle);
      }
      if (same > 0) words += printed("; right %.0f %%", 100 * same);
    }
    result.words.push_back(words);
  }

  for (std::uint32_t r = 0; r < faces.faces.size(); ++r) {
    const Face& face = faces.faces[r];
    if (face.area < options.least_share * truth.area) continue;
    if (!closed_form(face.kind)) {
      result.vague += closed[r] > 0.5 * weight[r];
      continue;
    }
    ++result.reported;
    if (right[r] >= 0.5 * weight[r] && weight[r] > 0) continue;
    if (right[r] + alike[r] >= 0.9 * weight[r] && weight[r] > 0) {
      ++result.alike;
      continue;
    }
    ++result.none;
    std::string words =
        printed("false: face %u: %s, %.1f mm2 (%.2f %%), right %.0f %%; there:", r, words_of(face).c_str(), face.area,
                100 * face.area / truth.area, 100 * right[r] / std::max(weight[r], 1e-300));
    std::vector<std::pair<double, std::uint32_t>> there;
    for (const auto& [pair, w] : common)
      if (pair.second == r) there.push_back({-w, pair.first});
    std::sort(there.begin(), there.end());
    for (std::size_t k = 0; k < std::min<std::size_t>(there.size(), 3); ++k) {
      const TrueFace& t = truth.faces[there[k].second];
      words += printed(" %.0f %% %s;", -100 * there[k].first / weight[r], words_of(t).c_str());
    }
    result.words.push_back(words);
  }
  return result;
}

}  // namespace bench
