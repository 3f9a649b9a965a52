/// The intermediate model: what a part is, in named parameters and named steps.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/vec.h"
#include "model/shapes.h"

namespace partscribe::model {

enum class Quantity { length, angle, count, ratio };

/// Why a value was, or was not, replaced by a nominal one.
struct NominalEvidence {
  double candidate = 0;  ///< mm or rad
  double z = 0;          ///< (candidate - fitted) / sigma
  bool kept = false;
  std::string series;      ///< "multiples of 0.5 mm", "diameter, clearance of M6, medium", ...
  double probability = 0;  ///< that the size was meant, by the evidence of all sizes of the part; 0: not known
};

/// A named number. `value` is printed; `fitted` +- `sigma` is what the data said. Lengths in mm, angles in rad.
struct Parameter {
  std::string name;  ///< lower_snake_case, a valid identifier in every backend
  Quantity quantity = Quantity::length;
  double value = 0;
  double fitted = 0;
  double sigma = 0;                  ///< sqrt(sigma_noise^2 + sigma_systematic^2); 0: not fitted
  double sigma_noise = 0;            ///< falls with the number of points
  double sigma_systematic = 0;       ///< does not
  std::size_t points = 0;            ///< that determine it
  std::size_t effective_points = 0;  ///< as many independent ones would tell as much; 0: not known
  std::optional<NominalEvidence> nominal;
  std::string note;             ///< what it measures, for a person: "radius of the shank"
  std::optional<Expr> formula;  ///< of earlier parameters; `value` is then what it gives
};

/// Where an object stands in its parent: turned by rotation_from_euler, then moved.
struct Frame {
  Expr x = 0, y = 0, z = 0;     ///< mm
  Expr rx = 0, ry = 0, rz = 0;  ///< rad; x first, then y, then z
  bool identity() const;
  bool operator==(const Frame&) const = default;
};

/// What the data say for one object.
struct Evidence {
  std::size_t points = 0;
  double rms = 0;      ///< mm, of the robust residuals
  double max = 0;      ///< mm, largest local robust mean of the signed distance
  double covered = 0;  ///< share of the object's surface with data, 0..1
  int views = 0;
};

/// A named step.
struct Object {
  std::string name;
  Shape shape;
  Frame frame;  ///< part_from_object
  Evidence evidence;
  std::string note;
  // Where an object of a lowered model comes from; empty in models as they are written and read.
  std::string feature{};  ///< the object of the written model
  std::string repeats{};  ///< the pattern or mirror of the written model that this is one copy of
};

/// Another way to describe the part, and why it was not taken.
struct Rival {
  std::string procedure;  ///< "surface of revolution"
  bool meets_tolerance = false;
  double deviation = 0;           ///< mm, largest local robust mean
  double description_length = 0;  ///< nats; less is better
  std::string reason;
};

/// The superellipsoid that was recovered first and ordered the procedures.
struct Hypothesis {
  double a1 = 0, a2 = 0, a3 = 0, e1 = 0, e2 = 0, taper_x = 0, taper_y = 0;  ///< mm, -, -
  double gof = 0;                                                           ///< the paper's, on unit-scaled data
  double gof_mm = 0;                                                        ///< mean radial distance
  std::string suggests;  ///< "surface of revolution", "box", ..., "none"
};

struct SourceFile {
  std::string file, sha256;
};

struct Provenance {
  std::vector<SourceFile> sources;
  std::size_t points = 0;    ///< read
  std::size_t rejected = 0;  ///< set aside as outliers
  int views = 0;
  double noise = 0;       ///< mm, median along the normal
  double spacing = 0;     ///< mm, median to the nearest neighbour
  double unit_scale = 1;  ///< file units to mm
  std::string program = "partscribe";
  std::string version;
  std::string options;  ///< as on the command line, without folders
};

/// Surface or data that the model says nothing about.
struct Unexplained {
  std::string reason;
  double area = 0;  ///< mm^2
  std::size_t points = 0;
};

struct Model {
  std::string name = "part";
  double tolerance = 0.1;  ///< mm
  Provenance provenance;
  std::vector<Parameter> parameters;  ///< order of presentation
  std::vector<Object> objects;        ///< each refers to earlier ones only; the last is the part
  Frame scan_from_part;               ///< the one placement: part's own frame to the scan's
  bool as_scanned = true;             ///< false: artifacts stay in the part's frame
  bool fallback = false;              ///< true: a triangulation, because no procedure met the tolerance
  std::optional<Hypothesis> hypothesis;
  std::vector<Rival> rivals;
  std::vector<Unexplained> unexplained;
};

/// Calls `visit` with the six expressions of a frame.
void visit_expressions(Frame& frame, const std::function<void(Expr&)>& visit);
void visit_expressions(const Frame& frame, const std::function<void(const Expr&)>& visit);

/// Names and values of all parameters, those with a formula computed by it.
Values values_of(const Model& model);

/// Values that somebody chose, with those that follow from others by a formula computed anew.
Values with_formulas(const Model& model, Values values);

/// The frame as a rigid motion.
Pose evaluate(const Frame& frame, const Values& values);

}  // namespace partscribe::model
