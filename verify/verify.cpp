#include "verify/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/number.h"
#include "core/parallel.h"
#include "model/distance/distance.h"
#include "model/tri_faces.h"
#include "verify/align/align.h"
#include "verify/align/misplaced_part.h"
#include "verify/compare/compare.h"
#include "verify/compare/source.h"
#include "verify/evaluate/solid.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t fewest_points = 30;
constexpr double least_seen = 0.01;  // share of the surface that a pass needs

/// Outcomes from best to worst.
int badness(Outcome outcome) {
  switch (outcome) {
    case Outcome::verified:
      return 0;
    case Outcome::not_run:
      return 1;
    case Outcome::cannot_decide:
      return 2;
    case Outcome::out_of_tolerance:
      return 3;
  }
  return 3;
}

bool describes_a_sheet(const Model& model) { return !model.objects.empty() && is_sheet(model.objects.back().shape); }

/// mm between the triangles of a model and the surfaces that it says they stand for; 0 unless it states both.
double drawn_off(const std::optional<Model>& model) {
  const auto* surface = model ? std::get_if<TriSurface>(&model->objects.back().shape) : nullptr;
  if (!surface || surface->faces.empty()) return 0;
  return facet_depth(std::get<TriSurfaceOf<double>>(evaluate(*surface, values_of(*model))));
}

/// Rows by the model's named faces; a place on the artifact belongs to the face of the model that is nearest.
FaceNames model_faces(const Model& model) {
  auto distance = std::make_shared<ModelDistance>(model);
  FaceNames names;
  for (const auto& face : distance->faces()) names.names.push_back(face.name);
  names.face_of = [distance](const Vec3& point, std::uint32_t) { return (*distance)(point).face; };
  return names;
}

/// "0.8 mm at the vertex (20, 0, 0)".
std::string gap_text(const BrepGap& gap, double tolerance) {
  return shown(gap.width, 0.0001) + " mm at the " + gap.kind + " " + Words(tolerance).place(gap.place);
}

/// Its vertices, edges and faces describe bodies that differ by so much that one of them may be wrong.
bool contradicts_itself(const Evaluation& evaluation, double tolerance) { return evaluation.gap.width > tolerance / 2; }

void note_evaluation(ArtifactVerdict& verdict, const Evaluation& evaluation, bool sheet, double tolerance) {
  verdict.backend = evaluation.backend;
  verdict.program = evaluation.program;
  verdict.version = evaluation.version;
  verdict.seconds = evaluation.seconds;
  verdict.evaluation_error = evaluation.error;
  verdict.true_surfaces = evaluation.exact != nullptr;
  verdict.verdict = Outcome::verified;
  const bool refused = evaluation.failed || evaluation.mesh.empty() || (!evaluation.solid && !sheet);
  if (refused) {
    verdict.verdict = Outcome::out_of_tolerance;
    verdict.reasons = evaluation.complaints;
    if (verdict.reasons.empty()) verdict.reasons = check_solid(evaluation.mesh).faults;
    if (verdict.reasons.empty()) verdict.reasons.push_back("the program delivered no solid");
  } else if (evaluation.error > tolerance / 4) {
    verdict.verdict = Outcome::cannot_decide;
    verdict.reasons.push_back("the evaluation itself is only good to " + shown(evaluation.error, 0.0001) + " mm");
  } else if (evaluation.gap.width > share_of_gap * tolerance) {
    verdict.verdict = Outcome::cannot_decide;
    verdict.reasons.push_back("the file itself is only good to " + gap_text(evaluation.gap, tolerance));
  }
  if (contradicts_itself(evaluation, tolerance)) {
    verdict.verdict = Outcome::out_of_tolerance;
    verdict.reasons.insert(
        verdict.reasons.begin(),
        "the file contradicts itself: its curves and faces miss one another by " + gap_text(evaluation.gap, tolerance));
  }
}

/// Another program that reads the script differently is a fault; one that turns polygons into circles is only reported.
void ask_others(const Path& artifact, const Evaluation& evaluation, const EvaluateOptions& how, ArtifactVerdict& result,
                Context& context) {
  result.second_opinions = second_opinions(artifact, evaluation, how, context);
  for (const auto& opinion : result.second_opinions)
    if (opinion.delivered && !opinion.agrees && !opinion.exact_circles) {
      result.verdict = Outcome::out_of_tolerance;
      result.reasons.push_back(opinion.program + " " + opinion.version +
                               " reads it differently: " + shown(opinion.distance, 0.0001) + " mm apart");
    }
}

/// The evaluated mesh in the artifact's own frame.
TriangleMesh as_written(const ArtifactVerdict& artifact) {
  return artifact.alignment ? transformed(artifact.mesh, artifact.alignment->scan_to_artifact) : artifact.mesh;
}

/// What explains all that follows, said first.
Finding about_the_whole(const ArtifactVerdict& verdict, const std::string& text) {
  const Box3 box = verdict.mesh.bounds();
  Finding finding;
  finding.place = verdict.data_to_model.worst, finding.extent = box.diagonal();
  finding.deviation = verdict.data_to_model.local_max, finding.area = verdict.model_to_data.area;
  finding.points = verdict.data_to_model.points;
  finding.reason = "the artifact as a whole is off";
  finding.text = text;
  return finding;
}

}  // namespace

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::verified:
      return "verified";
    case Outcome::out_of_tolerance:
      return "out_of_tolerance";
    case Outcome::cannot_decide:
      return "cannot_decide";
    case Outcome::not_run:
      return "not_run";
  }
  return "not_run";
}

const char* name_of(AlignBy method) {
  switch (method) {
    case AlignBy::none:
      return "none";
    case AlignBy::best_fit:
      return "best-fit";
    case AlignBy::datums:
      return "datums";
  }
  return "none";
}

const char* name_of(Finding::Kind kind) {
  switch (kind) {
    case Finding::Kind::displaced:
      return "displaced";
    case Finding::Kind::missing_material:
      return "missing_material";
    case Finding::Kind::invented_material:
      return "invented_material";
    case Finding::Kind::not_scanned:
      return "not_scanned";
    case Finding::Kind::rejected:
      return "rejected";
  }
  return "displaced";
}

int exit_code_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::verified:
      return 0;
    case Outcome::out_of_tolerance:
      return 1;
    case Outcome::cannot_decide:
      return 6;
    case Outcome::not_run:
      return 4;
  }
  return 4;
}

Result<Verdict> verify_artifacts(const std::vector<Path>& artifacts, const Scan& scan,
                                 const std::optional<Model>& model, const VerifyOptions& options, Context& context) {
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    return usage_error("the tolerance must be a positive number of mm");
  if (artifacts.empty()) return usage_error("no artifact was given to verify");

  context.report("evaluate", 0);
  Box3 scanned;
  for (const auto& p : scan.cloud.points)
    if (p.allFinite()) scanned.add(p);
  for (const auto& v : scan.mesh.vertices) scanned.add(v);
  const EvaluateOptions how{options.tolerance, options.seconds, options.memory_mb,
                            scanned.empty() ? 0 : scanned.diagonal()};
  std::vector<std::optional<Result<Evaluation>>> evaluations(artifacts.size());
  parallel_for(
      artifacts.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) evaluations[i].emplace(evaluate_artifact(artifacts[i], how, context));
      },
      1);
  if (context.cancelled) return Error{"cancelled during verification", ErrorKind::stopped};
  for (const auto& evaluation : evaluations)
    if (!evaluation->ok() && evaluation->error().kind != ErrorKind::missing_program &&
        evaluation->error().kind != ErrorKind::stopped)
      return evaluation->error();

  context.report("read the scan's noise", 0);
  const ScanSource source = prepare_source(scan, context);
  if (source.points.empty()) return bad_input("the scan has no point that was kept, so nothing can be verified");
  Verdict verdict;
  verdict.tolerance = options.tolerance;
  verdict.noise = source.noise;
  verdict.smallest_honest_tolerance = smallest_honest_tolerance(source);

  const bool sheet = model && describes_a_sheet(*model);
  std::optional<FaceNames> named;
  if (model) named = model_faces(*model);
  for (std::size_t i = 0; i < artifacts.size(); ++i) {
    if (context.cancelled) return Error{"cancelled during verification", ErrorKind::stopped};
    ArtifactVerdict& result = verdict.artifacts.emplace_back();
    result.file = artifacts[i].filename().string();
    if (!evaluations[i]->ok()) {
      result.verdict = Outcome::not_run;
      result.reasons.push_back(evaluations[i]->error().message);
      continue;
    }
    Evaluation& evaluation = evaluations[i]->value();
    note_evaluation(result, evaluation, sheet, options.tolerance);
    if (options.second_opinion) ask_others(artifacts[i], evaluation, how, result, context);
    result.mesh = std::move(evaluation.mesh);
    if (options.align == AlignBy::none) result.exact = std::move(evaluation.exact);  // alignment moves the mesh alone
    if (result.mesh.empty() || area(result.mesh) == 0) continue;
    FaceNames rows_of;
    if (named) rows_of = *named;
    if (options.align != AlignBy::none) {
      if (auto ok = lay_onto_scan(source, options, result, context); !ok) {
        result.verdict = Outcome::cannot_decide;
        result.reasons.push_back(ok.error().message);
        continue;
      }
      if (named)
        rows_of.face_of = [face_of = named->face_of, pose = result.alignment->scan_to_artifact](
                              const Vec3& p, std::uint32_t t) { return face_of(pose * p, t); };
    }
    compare(source, named ? &rows_of : nullptr, options, result, context);
    if (options.align == AlignBy::none && result.verdict == Outcome::out_of_tolerance && (evaluation.solid || sheet))
      if (const auto hint = hint_at_frame(source, options, result, context)) result.reasons.push_back(*hint);
    if (evaluation.failed) continue;
    // Below the noise no deviation means anything: neither a pass nor a fault of the data.
    const bool too_fine = options.tolerance < verdict.smallest_honest_tolerance;
    if (too_fine && (evaluation.solid || sheet) && !contradicts_itself(evaluation, options.tolerance)) {
      result.verdict = Outcome::cannot_decide;
      result.reasons = {"this scan cannot decide at " + print_number(options.tolerance) +
                        " mm: its smallest honest tolerance is " + shown(verdict.smallest_honest_tolerance, 0.0001) +
                        " mm" +
                        (view_reach * source.disagreement > options.tolerance
                             ? ", since its views lie " + shown(source.disagreement, 0.0001) + " mm apart"
                             : "")};
    } else if (result.verdict == Outcome::verified &&
               result.model_to_data.supported < least_seen * result.model_to_data.area) {
      result.verdict = Outcome::cannot_decide;
      result.reasons.push_back("this scan cannot decide: it shows less than a hundredth of the artifact's surface");
    } else if (source.points.size() < fewest_points && result.verdict == Outcome::verified) {
      result.verdict = Outcome::cannot_decide;
      result.reasons.push_back("this scan cannot decide: it has only " + std::to_string(source.points.size()) +
                               " points");
    } else if (result.verdict == Outcome::out_of_tolerance) {
      const auto whole = misplacement(source, result.mesh, MeshDistance(result.mesh), options, context);
      if (whole) {
        result.reasons.insert(result.reasons.begin(), *whole);
        result.findings.insert(result.findings.begin(), about_the_whole(result, *whole));
      }
    }
  }

  const double drawn = drawn_off(model);
  for (std::size_t a = 0; a < verdict.artifacts.size(); ++a)
    for (std::size_t b = a + 1; b < verdict.artifacts.size(); ++b) {
      const auto &first = verdict.artifacts[a], &second = verdict.artifacts[b];
      if (first.mesh.empty() || second.mesh.empty()) continue;
      BackendPair pair{first.file, second.file,
                       distance_between(as_written(first), as_written(second), context.threads), true};
      const double apart = first.true_surfaces == second.true_surfaces ? 0 : drawn;
      pair.agree = pair.distance <= options.tolerance / 5 + apart + first.evaluation_error + second.evaluation_error;
      verdict.between_backends.push_back(pair);
    }

  verdict.verdict = Outcome::verified;
  for (const auto& artifact : verdict.artifacts)
    if (badness(artifact.verdict) > badness(verdict.verdict)) verdict.verdict = artifact.verdict;
  for (const auto& pair : verdict.between_backends)
    if (!pair.agree) verdict.verdict = Outcome::out_of_tolerance;
  context.report("verify", 1);
  return verdict;
}

}  // namespace partscribe::verify
