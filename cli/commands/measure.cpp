/// measure: the faces, features and relations of a scan or mesh, without building anything.
#include <memory>

#include "cli/commands.h"
#include "cli/commands/stages.h"
#include "cli/commands/views.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/measure/face_words.h"
#include "cli/measure/faces_file.h"
#include "cli/measure/measured_part.h"
#include "cli/pictures/face_picture.h"
#include "verify/report/words.h"

namespace partscribe::cli {
namespace {

constexpr const char* measure_help =
    R"(Examples
  partscribe measure bracket.stl                          its holes, walls, rounds and faces, with their sizes
  partscribe measure folder/scan.json                     range images with poses
  partscribe measure v*.ply --poses turntable             several views, brought into one frame first
  partscribe measure bracket.stl --tolerance 0.02         smaller faces; what is left over shrinks
  partscribe measure scan.ply --csv sheet.csv             the table of the faces for a sheet
  partscribe measure scan.ply --json | jq '.features[]'   for a program

Divides the surface into planes, cylinders, cones, spheres, tori and free form, and says what a machinist would call
them (holes, slots, bosses, rounds, chamfers, walls, bolt circles), what is parallel, square, coaxial or equal within
its uncertainty, and what belongs to no face. Nothing is rounded to nominal sizes: every number is as measured, with one
standard deviation. Writes faces.json (all of it), faces.csv (a row for each face), features.csv (a row for each size of
a feature) and faces.png (the part with its faces coloured; the numbers are those of the tables). Exit code 0 when they
were written, whatever the part is like; 3 if a file cannot be read, 2 if one exists already.)";

struct MeasureArguments {
  std::vector<Path> scans;
  PoseArguments poses;
  Path json, csv;
};

/// "Read 1202 points in 1 view; tolerance ..." and what the program takes the data for.
std::string reading_line(const Scan& scan, const MeasuredPart& part, const ChosenTolerance& tolerance) {
  const std::string views =
      scan.views.size() > 1 ? " in " + std::to_string(scan.views.size()) + " views" : std::string();
  return "Read " +
         (part.faces.of_mesh ? "a mesh of " + std::to_string(scan.mesh.triangles.size()) + " triangles"
                             : std::to_string(scan.cloud.size()) + " points") +
         views + "; " + tolerance.reason + ".\n";
}

std::string found_line(const MeasuredPart& part) {
  return "Found " + verify::counted(part.faces.faces.size(), "face") + " and " +
         verify::counted(part.features.size(), "feature") +
         (part.faces.of_mesh ? "" : "; noise " + readable(part.faces.noise) + " mm") + ".\n";
}

Result<int> work(const MeasureArguments& given, const Path& folder, Session& session) {
  if (auto ok = session.stage("read"); !ok) return ok.error();
  auto placed = read_views(given.scans, given.poses, Points::measured, session);
  if (!placed) return placed.error();
  Scan& scan = placed->scan;
  const auto tolerance = tolerance_for(scan, session);
  const auto part = measure_stage(scan, tolerance.tolerance, session);
  if (!part) return part.error();
  if (auto ok = session.stage("write"); !ok) return ok.error();
  const std::string picture = write_png(draw_faces(scan, part->faces, session.context));
  const std::string csv = faces_csv(*part), json = faces_json(*part);
  const std::string features = features_csv(*part);
  std::vector<std::pair<Path, const std::string*>> files = {{folder / "faces.json", &json},
                                                            {folder / "faces.csv", &csv},
                                                            {folder / "features.csv", &features},
                                                            {folder / "faces.png", &picture}};
  if (!given.json.empty()) files.emplace_back(given.json, &json);
  if (!given.csv.empty()) files.emplace_back(given.csv, &csv);
  if (auto ok = make_folder(folder); !ok) return ok.error();
  std::vector<Path> written;
  for (const auto& [file, bytes] : files) {
    if (auto ok = write_file(file, *bytes); !ok) return ok.error();
    written.push_back(file);
  }
  session.finish_stage();
  session.print(reading_line(scan, *part, tolerance) + found_line(*part) + "\n" + measured_text(*part) +
                "\nTables in " + (folder / "faces.csv").string() +
                " and features.csv, all of it in faces.json; the "
                "numbers of the faces are drawn in faces.png\n" +
                seconds_line(session) + "\n");
  session.print_json(faces_json(*part, written, scan.warnings));
  return 0;
}

Result<int> run_measure(const MeasureArguments& given, Session& session) {
  for (const auto& file : {given.json, given.csv})
    if (!file.empty())
      if (auto ok = check_overwriting(file, session.options.force, given.scans); !ok) return ok.error();
  const Path folder = output_folder(session.options, given.scans.front(), given.scans.front());
  if (auto ok = check_same_part(session.options, folder, given.scans); !ok) return ok.error();
  if (auto ok =
          check_overwriting(folder, {"faces.json", "faces.csv", "features.csv", "faces.png"}, session.options.force);
      !ok)
    return ok.error();
  return work(given, folder, session);
}

}  // namespace

Command measure_command() {
  auto arguments = std::make_shared<MeasureArguments>();
  return {"measure", "say what faces, holes, walls and rounds a scan or mesh has, with their sizes", measure_help,
          [arguments](Arguments& a) {
            a.paths(arguments->scans, "scan", "scan files of one part, or a mesh");
            declare(arguments->poses, a);
            a.path(arguments->json, "--json-file", "FILE",
                   "write faces.json under this name too; '--json FILE' means the same when FILE ends in .json");
            a.path(arguments->csv, "--csv", "FILE", "write the table of the faces under this name too");
          },
          [arguments](Session& session) { return run_measure(*arguments, session); }};
}

}  // namespace partscribe::cli
