// Figures 13 and 14: CAD models of the pin and of the face, and the pin as procedures.
#include <algorithm>
#include <sstream>

#include "cli/describe.h"
#include "cli/paper/lit_pictures.h"
#include "cli/paper/paper_figure.h"
#include "codegen/emit.h"
#include "core/number.h"
#include "fit/build.h"
#include "geometry/surfaces/trimmed_surface.h"
#include "model/surface_patches.h"

namespace partscribe::cli {
namespace {

/// The first lines of a text, and how many follow.
std::string beginning(const std::string& text, int lines) {
  std::istringstream stream(text);
  std::string result, line;
  int count = 0;
  for (; std::getline(stream, line); ++count)
    if (count < lines) result += line + "\n";
  if (count > lines) result += "... " + std::to_string(count - lines) + " more lines\n";
  return result;
}

}  // namespace

Result<std::vector<PaperFigure>> model_figures(const PaperSubjects& subjects, Context& context) {
  constexpr double pin_tolerance = 0.1, face_tolerance = 1.0;  // mm
  Scan pin_scan = subjects.pin_scan;                           // the fit fills in normals and noise
  const auto pin = fit::build_model(pin_scan, {.tolerance = pin_tolerance, .name = "pin"}, context);
  if (!pin) return pin.error();
  Scan face_scan = scan_of(subjects.mask);
  const auto face = fit::build_model(face_scan, {.tolerance = face_tolerance, .name = "face"}, context);
  if (!face) return face.error();

  PaperFigure models;
  models.title = "Figure 13: CAD models";
  models.text = "The pin at " + print_number(pin_tolerance) + " mm, from six views: " + procedure_text(**pin) +
                ". The face mask at " + print_number(face_tolerance) + " mm, from one: " + procedure_text(**face) +
                ", whose distance from the points, averaged over neighbours, is at most " +
                readable((*face)->objects.back().evidence.max) + " mm.";
  models.table = {{"parameter of the pin", "found, mm"}};
  for (const auto& parameter : (*pin)->parameters)
    if (parameter.fitted > 0) models.table.push_back({parameter.name, with_sigma(parameter.fitted, parameter.sigma)});
  models.pictures.push_back({"figure-13-pin.png",
                             write_png(lit_surface(scan::surface_of(**pin), {0.8, -1, 0.5}, {0, 0, 1}, 400)),
                             "the pin as a solid"});
  TriangleMesh mesh;
  if (const auto* set = std::get_if<model::SurfaceSet>(&(*face)->objects.back().shape))
    mesh = triangulated(model::trimmed_surfaces(set->patches), 0.2).mesh;
  if (const auto* triangles = std::get_if<model::TriSurface>(&(*face)->objects.back().shape)) {
    const Pose placed = model::evaluate((*face)->scan_from_part, model::values_of(**face));
    for (const auto& v : triangles->vertices) mesh.vertices.push_back(placed * Vec3(v[0], v[1], v[2]));
    mesh.triangles = triangles->triangles;
  }
  if (!mesh.empty())
    for (const auto& [file, to_eye] :
         {std::pair{"figure-13-face.png", Vec3(0.1, 0, 1)}, std::pair{"figure-13-face-side.png", Vec3(1, -0.2, 0.7)}})
      models.pictures.push_back(
          {file, write_png(lit_mesh(mesh, to_eye, {0, 1, 0}, 400, false)), "the face: " + procedure_text(**face)});

  PaperFigure procedures;
  procedures.title = "Figure 14: the pin as an Alpha_1 procedure and in IGES";
  procedures.text = "Parts of the two files as they are written.";
  codegen::EmitOptions options;
  options.stem = "pin";
  for (const auto& [backend, lines] : {std::pair{"alpha1", 60}, std::pair{"iges", 40}}) {
    const auto artifact = codegen::emit(*pin, backend, options, context);
    if (!artifact) return artifact.error();
    procedures.listing += beginning(artifact->files.front().bytes, lines) + "\n";
  }
  return std::vector<PaperFigure>{models, procedures};
}

}  // namespace partscribe::cli
