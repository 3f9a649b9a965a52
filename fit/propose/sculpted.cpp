#include "fit/propose/sculpted.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "core/number.h"
#include "fit/evidence/evidence.h"
#include "fit/refine/refine.h"
#include "fit/surface/piece_fit.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/kd_tree.h"
#include "model/distance/distance.h"
#include "model/surface_patches.h"

namespace partscribe::fit {
namespace {

constexpr double least_share = 0.02;  // of the part: what is smaller is neither a face nor a region of its own
const double steepest = std::cos(radians(72));  // of a region, from the direction in which it is seen

/// A piece of the part that is to be one B-spline surface.
struct Region {
  std::vector<std::uint32_t> points;  // of the cloud, ascending
  Vec3 out = Vec3::UnitZ();           // unit: from there all of it is seen
  double lid = 0;                     // mm along `out`: the stock ends there
};

/// A region's surface, and how far above its lowest place the stock is cut away.
struct Cut {
  NurbsSurface surface;
  Vec3 direction;
};

/// Of every point of the fit; no_face as there.
std::vector<std::uint32_t> face_of_points(const Faces& faces, const FitInput& input, const Context& context) {
  const auto& points = input.cloud.points;
  if (!faces.of_mesh && faces.face_of.size() == points.size()) return faces.face_of;
  std::vector<std::uint32_t> result;
  if (faces.of_mesh) {
    const MeshDistance distance(input.scan->mesh, context.threads);
    for (const auto& hit : distance.closest(points, context.threads)) result.push_back(faces.face_of[hit.triangle]);
  } else {
    const KdTree tree(input.scan->cloud.points);
    for (const Vec3& p : points) result.push_back(faces.face_of[tree.nearest_one(p).index]);
  }
  return result;
}

/// Large enough, and bent enough, that it is no piece of something else.
bool is_plain(const Face& face, double whole) {
  const double least_arc = radians(90);
  if (face.area < least_share * whole) return false;
  // Normals of a cone turn by less than its points do; those of a flat one hardly at all.
  return face.kind == FaceKind::plane || (face.kind == FaceKind::cylinder && face.arc > least_arc) ||
         (face.kind == FaceKind::cone && face.arc * std::cos(face.surface().half_angle) > least_arc);
}

/// Directions in which parts of such faces are worked: along normals and axes, and along the edges of planes.
std::vector<Vec3> directions_of(const std::vector<const Face*>& plain) {
  std::vector<Vec3> result, normals;
  for (const Face* face : plain) {
    result.push_back(face->surface().axis), result.push_back(-face->surface().axis);
    if (face->kind == FaceKind::plane) normals.push_back(face->surface().axis);
  }
  for (std::size_t i = 0; i < normals.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (const Vec3 along = normals[i].cross(normals[j]); along.norm() > 0.5)
        result.push_back(along.normalized()), result.push_back(-along.normalized());
  return result;
}

/// The neighbours of a point.
std::span<const std::uint32_t> around(const Surroundings& s, std::size_t i) {
  return {s.index.data() + s.first[i], s.first[i + 1] - s.first[i]};
}

/// The connected pieces of what is marked, without its seams: a point most of whose neighbours are not marked joins no
/// two of them.
std::vector<std::vector<std::uint32_t>> pieces_of(const std::vector<std::uint8_t>& marked, const Surroundings& near) {
  constexpr double inner = 0.8;  // share of the neighbours
  const auto n = static_cast<std::uint32_t>(marked.size());
  std::vector<std::uint8_t> inside(n, 0);
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto others = around(near, i);
    const auto count = std::ranges::count_if(others, [&](std::uint32_t j) { return marked[j]; });
    inside[i] = marked[i] && double(count) >= inner * double(others.size());
  }
  std::vector<std::uint8_t> done(n, 0);
  std::vector<std::vector<std::uint32_t>> pieces;
  for (std::uint32_t start = 0; start < n; ++start) {
    if (!inside[start] || done[start]) continue;
    std::vector<std::uint32_t> piece = {start};
    done[start] = 1;
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const bool goes_on = inside[piece[k]];
      for (const std::uint32_t j : around(near, piece[k]))
        if (goes_on && marked[j] && !done[j]) done[j] = 1, piece.push_back(j);
    }
    std::ranges::sort(piece);
    if (double(piece.size()) >= least_share * n) pieces.push_back(std::move(piece));
  }
  return pieces;
}

/// Where a piece is seen from: a direction in which the part is worked, if one is near. Nothing where a good share of
/// the piece is too steep from there; single points that are do not belong to it.
std::optional<Region> seen(const std::vector<std::uint32_t>& piece, const std::vector<Vec3>& directions,
                           const FitInput& input) {
  const double near = std::cos(radians(25));
  constexpr double most = 0.9;  // share of the points
  Mat3 scatter = Mat3::Zero();
  Vec3 middle = Vec3::Zero(), whole = Vec3::Zero(), mean = Vec3::Zero();
  for (const std::uint32_t i : piece) {
    const Vec3& n = input.cloud.normals[i];
    scatter += n * n.transpose(), mean += n;
    middle += input.cloud.points[i] / double(piece.size());
  }
  for (const Vec3& p : input.cloud.points) whole += p / double(input.cloud.size());
  Vec3 out = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(2);
  if (out.dot(input.oriented ? mean : middle - whole) < 0) out = -out;
  Region region;
  region.out = out;
  double best = near;
  for (const Vec3& d : directions)
    if (d.dot(out) > best) best = d.dot(out), region.out = d;
  for (const std::uint32_t i : piece)
    if (std::abs(input.cloud.normals[i].dot(region.out)) > steepest) region.points.push_back(i);
  if (double(region.points.size()) < most * double(piece.size())) return std::nullopt;
  return region;
}

/// Together with the faces around it that are seen from the same direction.
Region grown(const Region& region, const Surroundings& near, const FitInput& input) {
  const double steep = std::cos(radians(60));
  std::vector<std::uint8_t> in(input.cloud.size(), 0);
  Region result = region;
  for (const std::uint32_t i : region.points) in[i] = 1;
  for (std::size_t k = 0; k < result.points.size(); ++k)
    for (const std::uint32_t j : around(near, result.points[k]))
      if (!in[j] && std::abs(input.cloud.normals[j].dot(region.out)) > steep) in[j] = 1, result.points.push_back(j);
  std::ranges::sort(result.points);
  return result;
}

/// Where the stock ends: at the plane that the region is sunk into, or a little above all of it.
double lid_of(const Region& region, const std::vector<const Face*>& plain, const FitInput& input) {
  const double along = std::cos(radians(1));
  double highest = -1e300;
  for (const std::uint32_t i : region.points) highest = std::max(highest, input.cloud.points[i].dot(region.out));
  for (const Face* face : plain)
    if (face->kind == FaceKind::plane && std::abs(face->surface().axis.dot(region.out)) > along)
      if (const double at = face->middle.dot(region.out); std::abs(at - highest) < 2 * input.tolerance) return at;
  return highest + 2 * input.tolerance;
}

/// The scan with a lid over each region in place of its points.
FitInput with_lids(const std::vector<Region>& regions, const FitInput& input, Context& context) {
  FitInput stock = input;
  for (const Region& region : regions) {
    for (const std::uint32_t i : region.points) {
      Vec3& p = stock.cloud.points[i];
      p += (region.lid - p.dot(region.out)) * region.out;
      stock.cloud.normals[i] = region.out;
    }
  }
  stock.closed = false;
  stock.bounds = stock.cloud.bounds();
  stock.surroundings = surroundings_of(stock, context);
  return stock;
}

/// The surface over a rectangle along the part's own directions that is somewhat larger than the region.
std::optional<Cut> cut_of(const Region& region, const std::vector<Vec3>& directions, const FitInput& input,
                          Context& context) {
  Vec3 x = region.out.unitOrthogonal();
  double best = 1e-3;
  for (const Vec3& d : directions)
    if (std::abs(d.dot(region.out)) < best) best = std::abs(d.dot(region.out)), x = d;
  x = (x - x.dot(region.out) * region.out).normalized();
  const Vec3 y = region.out.cross(x);
  SplineData data;
  double lowest = 1e300;
  for (const std::uint32_t i : region.points) {
    const Vec3& p = input.cloud.points[i];
    data.points.push_back(p), data.places.emplace_back(p.dot(x), p.dot(y));
    lowest = std::min(lowest, p.dot(region.out));
  }
  auto fit = fit_piece(data, input, context);
  if (!fit) return std::nullopt;
  for (const Vec3& p : fit->surface.points) lowest = std::min(lowest, p.dot(region.out));
  const double depth = region.lid - lowest + 5 * input.tolerance, unit = power_of_ten_below(depth);
  return Cut{std::move(fit->surface), unit * std::ceil(depth / unit) * region.out};
}

/// The direction itself, or the axis that it is nearly along.
Vec3 along_axis(const Vec3& d) {
  const double near = std::cos(radians(1));
  int k = 0;
  const double most = d.cwiseAbs().maxCoeff(&k);
  if (most < near * d.norm()) return d;
  return (d[k] > 0 ? d.norm() : -d.norm()) * Vec3::Unit(k);
}

/// The body without what lies before the surfaces.
Candidate sculpted(const Candidate& body, const std::vector<Cut>& cuts, const FitInput& input) {
  Candidate part = body;
  Difference whole;
  if (const auto* earlier = std::get_if<Difference>(&body.shape)) {
    whole = *earlier;
  } else {
    part.steps.push_back({body.object_name, body.shape, {}, {}, "the body before it is cut"});
    whole.objects = {body.object_name};
    part.object_name = "sculpted_" + body.object_name;
  }
  part.procedure = "body with free-form faces";
  part.otherwise.reset();
  const Pose part_from_scan = body.scan_from_part.inverse();
  const double step = power_of_ten_below(input.tolerance / 50);
  for (const Cut& cut : cuts) {
    TrimmedSurface surface{cut.surface, {}};
    for (Vec3& p : surface.surface.points) p = part_from_scan * p;
    round_numbers(surface, input.tolerance);
    const std::string name = "free_form_cut" + (cuts.size() == 1 ? "" : "_" + std::to_string(whole.objects.size()));
    const Vec3 direction = along_axis(part_from_scan.rotation * cut.direction);
    SweptSurface swept{trimmed_patch(surface, "surface"), {}};
    for (int k = 0; k < 3; ++k) swept.direction.push_back(snapped(direction[k], step));
    part.steps.push_back({name, std::move(swept), {}, {}, "what is cut away down to the free-form face"});
    part.extra_numbers += static_cast<int>(3 * cut.surface.points.size());
    whole.objects.push_back(name);
  }
  part.shape = std::move(whole);
  return part;
}

/// What remains of the stock's lids is nothing: its lengths up to there are open.
void hold_lids(Candidate& part, const FitInput& input) {
  const Model model = bare_model(part);
  const Pose part_from_scan = part.scan_from_part.inverse();
  const ModelDistance before(model);
  const std::size_t stride = input.cloud.size() / 1000 + 1;
  for (Parameter& p : part.parameters) {
    if (p.quantity != Quantity::length || p.formula) continue;
    Values values = values_of(model);
    values[p.name] += input.tolerance;
    const ModelDistance after(model, values, &before);
    bool matters = false;
    for (std::size_t i = 0; i < input.cloud.size() && !matters; i += stride) {
      const Vec3 q = part_from_scan * input.cloud.points[i];
      matters = std::abs(after(q).distance - before(q).distance) > 1e-3 * input.tolerance;
    }
    if (matters) continue;
    p.note += ", of the stock: this end is cut away and was not scanned";
    part.held.push_back({p.name, 0});
  }
}

}  // namespace

std::vector<Candidate> propose_sculpted(const FitInput& input, const Faces& faces, const BodyMaker& bodies,
                                        Context& context) {
  std::vector<Candidate> candidates;
  // Among many outliers what lies beside the faces is no surface.
  if (among_outliers(input) || input.outliers_left > many_outliers) return candidates;
  const auto surroundings = input.surroundings ? input.surroundings : surroundings_of(input, context);
  std::vector<const Face*> plain;
  const double whole = area_of(faces);
  for (const Face& face : faces.faces)
    if (is_plain(face, whole)) plain.push_back(&face);
  if (plain.empty()) return candidates;
  std::vector<std::uint8_t> free_form;
  for (const std::uint32_t f : face_of_points(faces, input, context))
    free_form.push_back(f == no_face || !is_plain(faces.faces[f], whole));
  const std::vector<Vec3> directions = directions_of(plain);
  std::vector<Region> regions;
  for (const auto& piece : pieces_of(free_form, *surroundings)) {
    auto region = seen(piece, directions, input);
    context.say("sculpted: " + print_number(double(piece.size())) + " points beside " +
                print_number(double(plain.size())) + " plain faces" + (region ? "" : ", not seen from one direction"));
    if (!region) return candidates;
    regions.push_back(std::move(*region));
  }
  if (regions.empty()) return candidates;
  // A surface that leaves the faces around it smoothly cannot be cut into them: these become part of it.
  std::vector<std::vector<Region>> choices = {regions};
  for (Region& region : regions) region = grown(region, *surroundings, input);
  choices.push_back(regions);
  for (auto& choice : choices)
    for (Region& region : choice) region.lid = lid_of(region, plain, input);
  bool enough = false;
  for (const auto& choice : choices) {
    std::vector<Cut> cuts;
    for (const Region& region : choice) {
      context.say("sculpted: " + print_number(double(region.points.size())) + " of " +
                  print_number(double(input.cloud.size())) + " points are a free-form face");
      if (auto cut = cut_of(region, directions, input, context)) cuts.push_back(std::move(*cut));
    }
    if (cuts.size() != choice.size() || context.cancelled) continue;
    const FitInput stock = with_lids(choice, input, context);
    for (const Candidate& body : best_bodies(bodies(stock), stock, "sculpted", context)) {
      candidates.push_back(sculpted(body, cuts, input));
      hold_lids(candidates.back(), input);
      enough = enough || evidence_of(candidates.back(), input, context).local_max <= input.tolerance;
    }
    if (enough) break;
  }
  return candidates;
}

}  // namespace partscribe::fit
