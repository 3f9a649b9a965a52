/// The verdict: does what the artifacts describe agree with the scan, everywhere and in both directions?
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/point_cloud.h"
#include "model/model.h"
#include "verify/evaluate.h"

namespace partscribe {

enum class Outcome { verified, out_of_tolerance, cannot_decide, not_run };
const char* name_of(Outcome outcome);  ///< "verified", ...
int exit_code_of(Outcome outcome);     ///< 0, 1, 6, 4

enum class Rule { local, max };  ///< judge the local robust mean, or the raw maximum

struct VerifyOptions {
  double tolerance = 0.1;
  Rule rule = Rule::local;
  bool strict = false;        ///< true: surface that was not scanned fails too
  double seconds = 600;
  double memory_mb = 8192;
  double outlier_rate = 0.02; ///< expected share of outliers in the scan
};

struct DataToModel {
  std::size_t points = 0, rejected = 0;
  double local_max = 0, rms = 0, p50 = 0, p95 = 0, p99 = 0, max = 0;  ///< mm
  Vec3 worst = Vec3::Zero();  ///< where local_max is
};

struct ModelToData {
  double area = 0, supported = 0, not_scanned = 0, contradicted = 0;  ///< mm^2
};

struct FeatureVerdict {
  std::string name;
  std::size_t points = 0;
  double rms = 0, max = 0;    ///< mm; max of the local robust mean
  double covered = 0;         ///< share of its surface with data
  Outcome verdict = Outcome::verified;
};

struct ArtifactVerdict {
  std::string file, backend, program, version;
  Outcome verdict = Outcome::not_run;
  double seconds = 0, evaluation_error = 0;
  DataToModel data_to_model;
  ModelToData model_to_data;
  std::vector<FeatureVerdict> objects;
  std::vector<std::string> reasons;   ///< why it is not verified, one line each
  std::vector<float> point_deviation; ///< local signed deviation per kept source point, for pictures; not in the JSON
  TriangleMesh mesh;                  ///< the evaluated geometry, for pictures; not in the JSON
};

struct BackendPair {
  std::string first, second;
  double distance = 0;  ///< mm, both directions
  bool agree = true;    ///< within tolerance / 5
};

struct Verdict {
  Outcome verdict = Outcome::not_run;   ///< the worst of all artifacts
  double tolerance = 0, smallest_honest_tolerance = 0;
  double noise = 0;                     ///< mm, local noise of the scan along the normal
  std::vector<ArtifactVerdict> artifacts;
  std::vector<BackendPair> between_backends;
};

/// Evaluates and judges every artifact. With a model its named faces get rows of their own; without one the faces
/// of the artifact do. A missing program is an outcome (not_run), a file that cannot be read an error.
Result<Verdict> verify(const std::vector<Path>& artifacts, const Scan& scan, const std::optional<Model>& model,
                       const VerifyOptions& options, Context& context);

std::string write_verdict_json(const Verdict& verdict);
std::string write_verdict_csv(const Verdict& verdict);
std::string write_verdict_junit(const Verdict& verdict);
/// A table for a terminal, 100 columns.
std::string verdict_table(const Verdict& verdict);

}  // namespace partscribe
