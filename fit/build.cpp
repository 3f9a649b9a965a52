#include "fit/build.h"

#include <algorithm>
#include <optional>

#include "core/number.h"
#include "fit/input/prepare.h"
#include "fit/outliers/outliers.h"
#include "fit/refine/tidy.h"
#include "fit/search/rivals.h"
#include "fit/search/search.h"
#include "fit/surface/fallback.h"
#include "geometry/points/keep_points.h"
#include "geometry/segment/faces.h"

namespace partscribe::fit {
namespace {

Provenance provenance_of(const Scan& scan, const FitInput& input, const BuildOptions& options) {
  Provenance p;
  for (std::size_t i = 0; i < scan.files.size(); ++i)
    p.sources.push_back({scan.files[i], i < scan.sha256.size() ? scan.sha256[i] : ""});
  p.points = scan.cloud.size();
  // Outliers are recognised among the thinned points of the fit; each of these stands for an equal number of points of
  // the scan.
  const auto rejected = static_cast<std::size_t>(std::count(scan.cloud.rejected.begin(), scan.cloud.rejected.end(), 1));
  const std::size_t aside = input.set_aside.size(), looked_at = input.cloud.size() + aside,
                    kept = scan.cloud.size() - rejected + aside;
  p.rejected = rejected - aside + aside * kept / std::max<std::size_t>(looked_at, 1);
  p.views = static_cast<int>(scan.views.size());
  p.noise =
      input.sampling.sigma > 0 ? snapped(input.sampling.sigma, power_of_ten_below(input.sampling.sigma / 100)) : 0;
  p.spacing = input.sampling.spacing > 0
                  ? snapped(input.sampling.spacing, power_of_ten_below(input.sampling.spacing / 100))
                  : 0;
  p.unit_scale = scan.unit_scale;
  p.options = "--tolerance " + print_number(options.tolerance) + (options.nominal ? "" : " --no-nominal") +
              (options.force.empty() ? "" : " --procedure " + options.force);
  return p;
}

double rounded(double v) { return v > 0 ? snapped(v, power_of_ten_below(v / 1000)) : 0; }

/// A scan, with or without its outliers, and what was found in it.
struct Attempt {
  FitInput input;
  std::vector<std::uint8_t> rejected;  ///< of the scan's points
  ProcedureSearch search;
};

constexpr double beside_from = 4, beside_to = 16;  // sigmas off a face: as near as outliers lie that are not on it
constexpr double least_spared = 12;                // points on a face that were taken for outliers

/// What lies on a face of the part is no outlier, however small the face is: the wall of a hole has few neighbours on
/// any local plane.
void spare_faces(const PointCloud& cloud, double tolerance, SurfacePoints& found, Context& context) {
  FaceOptions options;
  options.tolerance = tolerance;
  const Faces faces = faces_of_cloud(cloud, options, context);
  std::vector<std::uint32_t> outliers;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (found.outlier[i]) outliers.push_back(i);
  for (std::uint32_t f = 0; f < faces.faces.size(); ++f) {
    const Face& face = faces.faces[f];
    if (face.kind == FaceKind::free_form) continue;
    // Outliers lie beside the face as densely as on it: what they put there by chance does not make a face.
    Box3 box;
    for (const auto i : face.members) box.add(cloud.points[i]);
    const Vec3 margin = Vec3::Constant(beside_to * faces.noise);
    double on = 0, beside = 0;
    for (const auto i : outliers) {
      const Vec3& p = cloud.points[i];
      if ((p.array() < (box.low - margin).array()).any() || (p.array() > (box.high + margin).array()).any()) continue;
      const double off = std::abs(distance(face.surface(), p)) / faces.noise;
      if (faces.face_of[i] == f)
        on += 1;
      else if (off > beside_from && off < beside_to)
        beside += 1;
    }
    const double chance = beside * beside_from / (beside_to - beside_from);
    if (on < 3 * chance + 3 * std::sqrt(chance) + least_spared) continue;
    for (const auto i : outliers)
      if (faces.face_of[i] == f) found.outlier[i] = 0, --found.outliers;
  }
}

/// The scan without its outliers. The planes by which outliers are recognised also give better normals and a better
/// estimate of the noise than neighbourhoods that contain outliers.
std::optional<Attempt> without_outliers(const Scan& scan, FitInput input, Context& context) {
  constexpr std::size_t least_outliers = 9;  // fewer never judge a candidate
  if (!scan.mesh.empty() || input.cloud.normals.size() != input.cloud.size()) return std::nullopt;
  SurfacePoints found = surface_points_of(input.cloud.points, input.cloud.rays, input.sampling.sigma, context);
  PointCloud& cloud = input.cloud;
  if (found.outliers >= least_outliers) spare_faces(cloud, input.tolerance, found, context);
  const std::size_t n = cloud.size();
  if (found.outliers < least_outliers || n - found.outliers < 50) return std::nullopt;
  context.say("outliers: " + print_number(double(found.outliers)) + " of " + print_number(double(n)) +
              " points set aside");
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& towards = cloud.rays.size() == n ? Vec3(-cloud.rays[i]) : cloud.normals[i];
    cloud.normals[i] = found.normals[i].dot(towards) < 0 ? Vec3(-found.normals[i]) : found.normals[i];
  }
  std::vector<std::uint8_t> surface(n);
  for (std::size_t i = 0; i < n; ++i) surface[i] = !found.outlier[i];
  input.set_aside = cloud;
  keep_points(input.set_aside, found.outlier);
  std::vector<std::uint8_t> rejected = points_at(scan.cloud, input.set_aside.points);
  for (std::size_t i = 0; i < scan.cloud.rejected.size(); ++i) rejected[i] |= scan.cloud.rejected[i];
  keep_points(cloud, surface);
  for (std::size_t i = 0; i < n; ++i)
    if (surface[i]) input.surface_share.push_back(found.share[i]);
  input.outlier_share = double(found.outliers) / double(n);
  input.sampling.sigma = std::min(input.sampling.sigma, found.sigma);
  input.sampling.rejected += found.outliers;
  input.bounds = cloud.bounds();
  input.surroundings = surroundings_of(input, context);
  return Attempt{std::move(input), std::move(rejected), {}};
}

Rival rival_of(const Judged& j, const CandidateEvidence& evidence, const std::string& reason) {
  return {j.candidate.procedure, j.meets, rounded(evidence.local_max), std::round(evidence.total()), reason};
}

/// Completes a model: its provenance, its evidence, its rivals. `refused` are named first.
Result<CheckedModel> finished(Model model, const CandidateEvidence& found, double covered, const Attempt& attempt,
                              const std::vector<Rival>& refused, const Scan& scan, const BuildOptions& options,
                              Context& context) {
  const auto& [input, rejected, search] = attempt;
  model.name = options.name;
  model.provenance = provenance_of(scan, input, options);
  model.hypothesis = search.hypothesis.hypothesis;
  Evidence& evidence = model.objects.back().evidence;
  evidence.points = input.cloud.size();
  evidence.rms = rounded(found.rms);
  evidence.max = rounded(found.local_max);
  evidence.covered = snapped(covered, 0.001);
  evidence.views = static_cast<int>(scan.views.size());
  const auto& judged = search.judged;
  const Judged* winner = search.found ? &judged[search.winner] : nullptr;
  for (const Judged& j : judged) {
    if (&j == winner || j.refused) continue;
    model.rivals.push_back(rival_of(j, j.evidence, winner ? reason_of(*winner, j, input, context) : j.reason));
  }
  model.rivals = worth_naming(std::move(model.rivals));
  const auto put_first = [&](Rival rival) {
    if (!rival.reason.empty()) model.rivals.insert(model.rivals.begin(), std::move(rival));
  };
  if (winner) {
    const double cost = winner->evidence.total(), off = rounded(found.local_max);
    // A bent sheet is closer to the data than the winner: its numbers are the most that can be said.
    put_first({"cylinder", true, off, std::round(cost), bent_sheet(winner->candidate, input)});
    put_first(
        {"convex polyhedron", false, off, std::round(cost), open_polyhedron(winner->candidate, cost, input, context)});
  }
  for (auto rival = refused.rbegin(); rival != refused.rend(); ++rival) put_first(*rival);
  return checked(std::move(model), "the fitted model");
}

/// The triangulation of an attempt's points.
Result<CheckedModel> triangulated(const Attempt& attempt, const std::vector<Rival>& refused, const Scan& scan,
                                  const BuildOptions& options, Context& context) {
  context.report("triangulation", 0.7);
  const auto fallback = fallback_of(attempt.input, context);
  if (!fallback) return fallback.error();
  Model model = model_of(fallback->mesh, attempt.input);
  const Vec3 shift = fallback->mesh.scan_from_part.translation;
  model.scan_from_part = {};
  model.scan_from_part.x = shift.x(), model.scan_from_part.y = shift.y(), model.scan_from_part.z = shift.z();
  model.fallback = options.force != only_a_mesh;
  const double covered = coverage_of(fallback->mesh, attempt.input, context).covered;
  return finished(std::move(model), fallback->evidence, covered, attempt, refused, scan, options, context);
}

/// The models of a scan that were offered, one after the other, and what was said of them.
class Offers {
 public:
  Offers(Scan& scan, const BuildOptions& options, Context& context)
      : scan_(scan), options_(options), context_(context) {}

  /// Offers what was found in an attempt, and for as long as that is refused the next best. True if one was taken.
  Result<bool> take(Attempt& attempt) {
    ProcedureSearch& search = attempt.search;
    while (search.found && !context_.cancelled) {
      scan_.cloud.rejected = attempt.rejected;
      auto model =
          finished(search.model, search.evidence, search.covered, attempt, refused_, scan_, options_, context_);
      if (!model) return model.error();
      auto reason = offer(std::move(*model));
      if (!reason) return reason.error();
      if (reason->empty()) return true;
      *reason = "refused: " + *reason;
      refused_.push_back(rival_of(search.judged[search.winner], search.evidence, *reason));
      if (enough())
        search.found = false;
      else
        choose_another(search, *reason, attempt.input, options_, context_);
    }
    return false;
  }

  /// Why the model is not taken; empty if it is the answer.
  Result<std::string> offer(CheckedModel model) {
    auto reason = options_.refusal ? options_.refusal(model) : Result<std::string>(std::string());
    if (!reason) return reason;
    if (reason->empty()) {
      answer_ = std::move(model);
    } else if (!first_) {
      first_ = std::move(model);
      first_rejected_ = scan_.cloud.rejected;
    }
    return reason;
  }

  /// Each trial costs a verification; after so many no procedure describes the part.
  bool enough() const { return refused_.size() >= 3; }
  const std::vector<Rival>& refused() const { return refused_; }

  /// The accepted model; else the first one, which was the best candidate.
  CheckedModel answer() {
    if (answer_) return std::move(*answer_);
    ensure(first_.has_value(), "a build that offered no model");
    scan_.cloud.rejected = first_rejected_;
    return std::move(*first_);
  }

 private:
  Scan& scan_;
  const BuildOptions& options_;
  Context& context_;
  std::optional<CheckedModel> answer_, first_;
  std::vector<std::uint8_t> first_rejected_;
  std::vector<Rival> refused_;
};

}  // namespace

Result<CheckedModel> build_model(Scan& scan, const BuildOptions& options, Context& context) {
  if (!options.force.empty() && !is_procedure(options.force))
    return usage_error("expected the name of a procedure, found '" + options.force + "'");
  context.report("normals", 0.0);
  auto prepared = prepare(scan, options.tolerance, context);
  if (!prepared) return prepared.error();
  const FitInput input = std::move(*prepared);
  // Outliers hide procedures or bias them; but recognising them takes time and removes small and strongly curved faces.
  // A scan of which many points were rejected contains more of them; any other scan is tried as it is first.
  constexpr double many = 0.005;
  const bool littered = double(input.sampling.rejected) > many * double(scan.cloud.size());
  const std::vector<std::uint8_t> rejected = scan.cloud.rejected;
  std::vector<Attempt> attempts;
  Offers offers(scan, options, context);
  const auto search = [&](Attempt& a, bool last_resort) {
    scan.cloud.rejected = a.rejected;
    search_procedure(a.search, last_resort, a.input, options, context);
  };
  const auto done = [&](const Result<bool>& taken) { return !taken || *taken || context.cancelled || offers.enough(); };
  Result<bool> taken = false;
  for (const bool without : {littered, !littered}) {
    auto next = without ? without_outliers(scan, input, context) : std::optional(Attempt{input, rejected, {}});
    if (!next) continue;
    if (!attempts.empty() && !without) next->input.outliers_left = attempts.front().input.outlier_share;
    attempts.push_back(std::move(*next));
    Attempt& attempt = attempts.back();
    search(attempt, false);
    if (!context.cancelled && is_rough(attempt.search, attempt.input)) search(attempt, true);
    if (done(taken = offers.take(attempt))) break;
  }
  for (auto& a : attempts) {
    if (done(taken)) break;
    search(a, true);
    taken = offers.take(a);
  }
  if (context.cancelled) return Error{"cancelled", ErrorKind::stopped};
  if (!taken) return taken.error();
  // If nothing was found the scan is taken as it is, unless many points were rejected and a good part of the others are
  // outliers.
  const Attempt& rest = attempts[attempts.size() == 2 && littered && !among_outliers(attempts[0].input) ? 1 : 0];
  if (!*taken && !options.triangulate) {
    const auto& judged = rest.search.judged;
    const std::string best =
        judged.empty() ? "none was proposed" : "nearest: " + judged[0].candidate.procedure + ", " + judged[0].reason;
    return bad_input((scan.files.empty() ? "scan" : scan.files[0]) +
                     ": expected a procedure within tolerance of the data, found none (" + best + ")");
  }
  if (!*taken) {
    scan.cloud.rejected = rest.rejected;
    auto mesh = triangulated(rest, offers.refused(), scan, options, context);
    // If a triangulation fails as well, a refused procedure is still better than no model.
    if (!mesh && (offers.refused().empty() || mesh.error().kind == ErrorKind::stopped)) return mesh.error();
    if (mesh)
      if (const auto offered = offers.offer(std::move(*mesh)); !offered) return offered.error();
  }
  context.report("fitted", 1.0);
  return offers.answer();
}

}  // namespace partscribe::fit
