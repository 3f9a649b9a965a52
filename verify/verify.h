/// The verdict: does what the artifacts describe agree with the scan, everywhere and in both directions?
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/points/point_cloud.h"
#include "model/model.h"
#include "verify/evaluate/evaluate.h"
#include "verify/evaluate/second_opinion.h"

namespace partscribe::verify {

enum class Outcome { verified, out_of_tolerance, cannot_decide, not_run };
const char* name_of(Outcome outcome);  ///< "verified", ...
int exit_code_of(Outcome outcome);     ///< 0, 1, 6, 4

enum class AlignBy { none, best_fit, datums };  ///< how the scan is laid onto the artifact; see verify/align/align.h
const char* name_of(AlignBy method);            ///< "best-fit", ...

enum class Rule { local, max };  ///< judge the local robust mean, or the raw maximum

struct VerifyOptions {
  double tolerance = 0.1;
  Rule rule = Rule::local;
  bool strict = false;  ///< true: surface that was not scanned fails too
  double seconds = 600;
  double memory_mb = 8192;
  double outlier_rate = 0.02;     ///< share of the scan's points that may be outliers
  AlignBy align = AlignBy::none;  ///< none: both are in one frame
  bool second_opinion = false;    ///< ask other programs, where installed, what a script describes
};

struct DataToModel {
  std::size_t points = 0, rejected = 0;  ///< judged, and set aside as outliers
  std::size_t set_aside = 0;             ///< of these, before the comparison: by a filter or by the fit
  double local_max = 0, rms = 0, p50 = 0, p95 = 0, p99 = 0, max = 0;  ///< mm
  Vec3 worst = Vec3::Zero();                                          ///< where local_max is
};

struct ModelToData {
  double area = 0, supported = 0, not_scanned = 0, contradicted = 0;  ///< mm^2
};

/// One number of a feature as an inspector reads it.
struct FeatureDimension {
  std::string name;  ///< "diameter", "offset", "half angle", "position x"
  Quantity quantity = Quantity::length;
  double nominal = 0;    ///< mm or rad, as the artifact says
  double measured = 0;   ///< fitted to the scanned points of the feature alone
  double sigma = 0;      ///< of `measured`
  double deviation = 0;  ///< measured - nominal
  bool within = true;    ///< the surface it moves stays within the tolerance
};

struct FeatureVerdict {
  std::string name;  ///< "hole 3", "left bore": unique in the artifact
  /// as in verify/features/features.h: "plane", "hole", ...; empty if no one feature makes up the row
  std::string kind;
  std::vector<FeatureDimension> dimensions;
  std::size_t points = 0;
  double rms = 0, max = 0;  ///< mm; max of the local robust mean
  double covered = 0;       ///< share of its surface with data
  Outcome verdict = Outcome::verified;
};

/// A connected patch where artifact and scan disagree, or where nobody looked; one line for a person.
struct Finding {
  enum class Kind {
    displaced,          ///< the scan has this face, elsewhere: too far out, in, or aside
    missing_material,   ///< the scan has surface that the artifact lacks
    invented_material,  ///< the artifact has surface that the scan contradicts
    not_scanned,        ///< the artifact has surface that no view could see or no data cover; no fault by itself
    rejected,           ///< points were set aside as outliers where they crowd
  };
  Kind kind = Kind::displaced;
  std::string feature;            ///< name of the nearest row of `objects`; empty if there is none
  Vec3 place = Vec3::Zero();      ///< on the surface, scan frame
  Vec3 direction = Vec3::Zero();  ///< unit; where the scan lies, seen from the artifact; zero if it has no direction
  double deviation = 0;           ///< mm along `direction`
  double area = 0;                ///< mm^2
  double extent = 0;              ///< mm, largest width of the patch
  std::size_t points = 0;         ///< scanned points in it
  std::string reason;  ///< why: "no view faces it", "view 3 saw what lies behind it", "its points were rejected"
  std::string text;    ///< "hole 3: 0.31 mm too far in +x over 14 mm^2 at (10, 20, 5)"
};
const char* name_of(Finding::Kind kind);  ///< "displaced", ...

/// How the scan was moved before it was compared; only on request.
struct Alignment {
  AlignBy method = AlignBy::best_fit;
  Pose scan_to_artifact;            ///< scan_to_artifact * p_scan is the place on the artifact as it was written
  double rotation = 0;              ///< rad
  Vec3 translation = Vec3::Zero();  ///< mm, by which it moves the middle of the scan
  double rms = 0;                   ///< mm, of the points that count
  std::size_t points = 0;           ///< that count
  std::string remark;               ///< what a person must know: "the part fits as well in 3 other positions ..."
  bool moves() const { return rotation != 0 || translation.squaredNorm() != 0; }  ///< false: it lay right already
};

struct ArtifactVerdict {
  std::string file, backend, program, version;
  Outcome verdict = Outcome::not_run;
  double seconds = 0, evaluation_error = 0;
  std::optional<Alignment> alignment;  ///< set if the scan was aligned; `mesh` and all places are in the scan's frame
  DataToModel data_to_model;
  ModelToData model_to_data;
  std::vector<FeatureVerdict> objects;
  std::vector<Finding> findings;               ///< the worst first; of those that are faults, then the not scanned ones
  std::vector<SecondOpinion> second_opinions;  ///< if asked for
  std::vector<std::string> reasons;            ///< why it is not verified, one line each
  std::vector<float> point_deviation;  ///< local signed deviation per kept source point, for pictures; not in the JSON
  std::vector<std::int32_t> point_object;     ///< its row in `objects`, or -1; as long, for pictures too
  std::vector<std::int32_t> triangle_object;  ///< of each triangle of `mesh`; for pictures too
  std::vector<std::uint8_t> sample_support;   ///< Support of even_samples(mesh, this size); for pictures too
  TriangleMesh mesh;                          ///< the evaluated geometry, for pictures; not in the JSON
  bool true_surfaces = false;                 ///< the file holds surfaces, not triangles alone
  std::shared_ptr<const BrepDistance> exact;  ///< the surfaces that `mesh` approaches, where known; not in the JSON
};

struct BackendPair {
  std::string first, second;
  double distance = 0;  ///< mm, both directions
  bool agree = true;    ///< within tolerance / 5, what the programs approximate aside
};

struct Verdict {
  Outcome verdict = Outcome::not_run;  ///< the worst of all artifacts
  double tolerance = 0, smallest_honest_tolerance = 0;
  double noise = 0;  ///< mm, local noise of the scan along the normal
  std::vector<ArtifactVerdict> artifacts;
  std::vector<BackendPair> between_backends;
};

/// Evaluates and judges every artifact. With a model its named faces get rows of their own; without one the faces
/// of the artifact do. A missing program is an outcome (not_run), a file that cannot be read an error.
Result<Verdict> verify_artifacts(const std::vector<Path>& artifacts, const Scan& scan,
                                 const std::optional<Model>& model, const VerifyOptions& options, Context& context);

std::string write_verdict_json(const Verdict& verdict);
std::string write_verdict_csv(const Verdict& verdict);
std::string write_verdict_junit(const Verdict& verdict);
/// A table for a terminal, 100 columns.
std::string verdict_table(const Verdict& verdict);

}  // namespace partscribe::verify
