/// The models of the 1993 paper's face and hand: what no primitive describes is bounded by spline surfaces.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "cli/paper/paper_figure.h"
#include "codegen/emit.h"
#include "core/files.h"
#include "fit/input/prepare.h"
#include "fit/propose/superellipsoid.h"
#include "fit/refine/tidy.h"
#include "fit/surface/fallback.h"
#include "fit/surface/triangulate.h"
#include "model/distance/distance.h"
#include "testing/paper_subjects.h"
#include "verify/verify.h"

using namespace partscribe;
using namespace partscribe::cli;
using partscribe::testing::subjects_of_paper;

namespace {

/// What `build` does where no procedure is found.
struct Bounded {
  Scan scan;
  model::CheckedModel model;
};

Bounded bounded(const PaperSubject& subject, double tolerance, Context& context) {
  Scan scan = scan_of(subject);
  const auto input = fit::prepare(scan, tolerance, context);
  REQUIRE(input);
  fit::Triangulator triangulator(*input, context);
  const auto surfaces = fit::free_form_of(*input, triangulator, context);
  REQUIRE(surfaces);
  CHECK(surfaces->evidence.local_max < tolerance);
  auto model = model::checked(fit::model_of(surfaces->candidate, *input), subject.name);
  REQUIRE(model);
  return {scan, std::move(*model)};
}

}  // namespace

TEST_CASE("paper models: the face is one trimmed spline surface in four files, verified at 1 mm") {
  constexpr double tolerance = 1;
  Context context;
  const Bounded face = bounded(subjects_of_paper().mask, tolerance, context);
  const auto* set = std::get_if<model::SurfaceSet>(&face.model->objects.back().shape);
  REQUIRE(set);
  REQUIRE(set->patches.size() == 1);
  CHECK(set->patches[0].control.size() < 1000);
  CHECK(set->patches[0].trims.back().loop == 0);  // an outline without holes

  // Its rim, the steepest of it, is there as well: no single point lies far from it.
  const model::ModelDistance distance(*face.model);
  const Pose part_from_scan = model::evaluate(face.model->scan_from_part, model::values_of(*face.model)).inverse();
  double farthest = 0;
  for (const Vec3& p : face.scan.cloud.points)
    farthest = std::max(farthest, std::abs(distance(part_from_scan * p).distance));
  CHECK(farthest < 1.5 * tolerance);

  const TemporaryDirectory folder;
  std::vector<Path> files;
  for (const auto& backend : codegen::backends()) {
    codegen::EmitOptions options;
    options.stem = "face";
    const auto artifact = codegen::emit(face.model, backend.name, options, context);
    REQUIRE(artifact);
    for (const auto& file : artifact->files) {
      REQUIRE(write_file(folder.path() / file.name, file.bytes).ok());
      if (&file == &artifact->files.front()) files.push_back(folder.path() / file.name);
    }
  }
  verify::VerifyOptions options;
  options.tolerance = tolerance;
  const auto verdict = verify::verify_artifacts(files, face.scan, *face.model, options, context);
  REQUIRE(verdict);
  INFO(verify::verdict_table(*verdict));
  CHECK(verdict->artifacts.size() == 4);
  int judged = 0;
  for (const auto& artifact : verdict->artifacts) {
    INFO(artifact.backend);
    if (artifact.verdict == verify::Outcome::not_run) continue;  // OpenSCAD may be missing
    ++judged;
    CHECK(artifact.verdict == verify::Outcome::verified);
    CHECK(artifact.data_to_model.local_max < tolerance);
  }
  CHECK(judged >= 3);
}

TEST_CASE("paper models: superellipsoids of face and hand fit badly, and bounding surfaces describe both within 1 mm") {
  Context context;
  const auto& subjects = subjects_of_paper();
  const Scan pin = scan_of(subjects.pin);
  const auto rod = fit::recover_superellipsoid(pin.cloud.points, context);
  CHECK(rod.hypothesis.suggests != "none");
  for (const PaperSubject* subject : {&subjects.mask, &subjects.hand}) {
    INFO(subject->name);
    const Scan scan = scan_of(*subject);
    const auto fit = fit::recover_superellipsoid(scan.cloud.points, context);
    CHECK(fit.hypothesis.suggests == "none");
    CHECK(fit.hypothesis.gof > 5 * rod.hypothesis.gof);
    CHECK(fit.hypothesis.gof_mm > 1);
  }
  const Bounded hand = bounded(subjects.hand, 1, context);  // of the face see above
  CHECK(std::holds_alternative<model::SurfaceSet>(hand.model->objects.back().shape));
}

TEST_CASE("paper models: figure 13 shows the pin as procedures and the face as a spline surface", "[.statistics]") {
  Context context;
  const auto figures = model_figures(subjects_of_paper(), context);
  REQUIRE(figures);
  REQUIRE(figures->size() == 2);
  const PaperFigure& models = figures->front();
  INFO(models.text);
  CHECK(models.text.find("a sheet of 1 B-spline surface") != std::string::npos);
  REQUIRE(models.pictures.size() == 3);
  for (const auto& picture : models.pictures) CHECK(picture.png.size() > 2500);
  const auto at = models.text.find("is at most ");
  REQUIRE(at != std::string::npos);
  CHECK(std::atof(models.text.c_str() + at + 11) < 1);
}
