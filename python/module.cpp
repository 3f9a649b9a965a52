/// partscribe._native: what the Python package is made of. Answers come as the JSON that the program writes, everything
/// that is as long as a scan as arrays over the memory of C++.
#include <pybind11/numpy.h>  // before anything of ours: its functions are called as our macro ensure
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <memory>

#include "cli/commands/build_json.h"
#include "cli/commands/built.h"
#include "cli/commands/judged.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/measure/faces_file.h"
#include "cli/names.h"
#include "cli/report/report_scene.h"
#include "fit/procedures.h"
#include "model/json.h"
#include "python/arrays.h"
#include "python/run.h"

namespace partscribe::python {
namespace {

using namespace partscribe::cli;
using Paths = std::vector<Path>;

/// A scan, and what it was read from; never changed, because arrays look at its memory.
struct ReadScan {
  PlacedViews placed;
  Paths files;
  std::string units;
  bool registered = false;
  const Scan& scan() const { return placed.scan; }
};
using ScanPtr = std::shared_ptr<ReadScan>;

struct Judged {
  Verdict verdict;
  std::vector<std::vector<float>> deviations;  ///< of each artifact: one for each point of the scan, or none
};

struct Measured {
  std::string json;
  Faces faces;
};

struct Built {
  std::string json, model;  ///< as build --json prints them, model.json
  std::vector<ArtifactFile> artifacts;
  ScanPtr scan;
  std::shared_ptr<Judged> judged;
};

SharedOptions shared(std::optional<double> tolerance, int threads, const std::string& units = {}) {
  SharedOptions options;
  options.tolerance = tolerance, options.threads = threads, options.units = units;
  return options;
}

std::shared_ptr<Judged> judged(Verdict verdict, const Scan& scan) {
  auto result = std::make_shared<Judged>();
  result->verdict = std::move(verdict);
  for (const auto& artifact : result->verdict.artifacts)
    result->deviations.push_back(deviations_of(scan.cloud, &artifact));
  return result;
}

ScanPtr read(const Paths& files, const std::string& units, const std::string& poses, const std::string& registration,
             const Path& fiducials, bool correct_depth, const std::string& filter, int threads,
             const py::object& progress) {
  if (files.empty()) raise(usage_error("expected the files of a scan, found none"));
  PoseArguments how;
  how.poses = poses, how.method = registration, how.fiducials = fiducials, how.correct_depth = correct_depth;
  return run<ScanPtr>(shared({}, threads, units), progress, [&](Session& session) -> Result<ScanPtr> {
    if (auto ok = session.stage("read"); !ok) return ok.error();
    auto placed = read_views(files, how, filter == "none" ? Points::measured : Points::flagged, session,
                             filter == "profile" ? RltsForm::profile : RltsForm::combined);
    if (!placed) return placed.error();
    return std::make_shared<ReadScan>(ReadScan{std::move(*placed), files, units, poses != "given"});
  });
}

Measured measure(const ScanPtr& given, std::optional<double> tolerance, int threads, const py::object& progress) {
  return run<Measured>(shared(tolerance, threads), progress, [&](Session& session) -> Result<Measured> {
    Scan scan = given->scan();
    auto part = measure_stage(scan, tolerance_for(scan, session).tolerance, session);
    if (!part) return part.error();
    std::string json = faces_json(*part);
    return Measured{std::move(json), std::move(part->faces)};
  });
}

/// What the caller wants built.
struct Wanted {
  std::optional<double> tolerance;
  Path out;
  std::string name;
  std::vector<std::string> to;
  bool nominal = true;
  std::string procedure;
  Path templates;
  bool force = false;
};

Result<Built> built(const ReadScan& given, const Wanted& wanted, Session& session) {
  if (!wanted.procedure.empty() && !is_procedure(wanted.procedure))
    return usage_error("procedure: expected the name of one, found '" + wanted.procedure + "'");
  const auto backends = chosen_backends(wanted.to);
  if (!backends) return backends.error();
  BuildFolder into = build_folder(wanted.out, given.files, given.registered);
  if (!wanted.out.empty())
    if (auto ok = into.results.check(wanted.force); !ok) return ok.error();

  auto scan = std::make_shared<ReadScan>(given);
  const PointCloud as_read = scan->scan().cloud;
  BuildRequest request{part_name(wanted.name.empty() ? given.files.front() : Path(wanted.name)),
                       tolerance_for(scan->scan(), session).tolerance,
                       *backends,
                       wanted.templates,
                       {}};
  request.fit.no_nominal = !wanted.nominal, request.fit.procedure = wanted.procedure;
  auto part = build_part(scan->placed.scan, request, session);
  if (!part) return part.error();
  Trial& trial = part->tried[part->answer];
  Paths files;
  if (!wanted.out.empty()) {
    if (auto ok = make_folder(wanted.out); !ok) return ok.error();
    const auto pictures = write_built(*part, scan->placed, into, session);
    const auto closed = into.results.close(pictures ? Result<int>(0) : Result<int>(pictures.error()));
    if (!closed) return closed.error();
    files = built_files(wanted.out);
  }
  std::optional<Wider> wider;
  if (part->model->fallback || trial.verdict.verdict == Outcome::out_of_tolerance) {
    auto found = wider_procedure(*part, scan->scan(), as_read, request, session);
    if (!found) return found.error();
    wider = *found;
  }
  session.finish_stage();
  Built result;
  result.json = build_json(*part->model, wanted.procedure, wider, write_verdict_json(trial.verdict), files,
                           scan->scan().warnings);
  result.model = std::move(trial.model);
  for (auto& artifact : trial.emitted.artifacts)
    for (auto& file : artifact.files) result.artifacts.push_back(std::move(file));
  result.judged = judged(std::move(trial.verdict), scan->scan());
  result.scan = std::move(scan);
  return result;
}

Built build(const ScanPtr& scan, std::optional<double> tolerance, const Path& out, const std::string& name,
            const std::vector<std::string>& to, bool nominal, const std::string& procedure, const Path& templates,
            bool force, int threads, const py::object& progress) {
  const Wanted wanted{tolerance, out, name, to, nominal, procedure, templates, force};
  return run<Built>(shared(tolerance, threads, scan->units), progress,
                    [&](Session& session) { return built(*scan, wanted, session); });
}

std::shared_ptr<Judged> verify(const Paths& artifacts, const ScanPtr& scan, std::optional<double> tolerance,
                               const CheckedModel* model, const std::string& rule, bool strict,
                               const std::string& align, std::optional<double> outliers, double time_limit,
                               bool second_opinion, int threads, const py::object& progress) {
  using Answer = std::shared_ptr<Judged>;
  if (artifacts.empty()) raise(usage_error("expected an artifact to verify, found none"));
  return run<Answer>(shared(tolerance, threads), progress, [&](Session& session) -> Result<Answer> {
    auto known = model ? Result<std::optional<Model>>(std::optional<Model>(**model)) : model_of(artifacts.front());
    if (!known) return known.error();
    VerifyOptions options = verify_options(*known, scan->scan(), outliers, session);
    options.rule = rule == "max" ? Rule::max : Rule::local;
    options.strict = strict;
    options.align = align == "best-fit" ? AlignBy::best_fit : align == "datums" ? AlignBy::datums : AlignBy::none;
    options.seconds = time_limit;
    options.second_opinion = second_opinion;
    if (auto ok = session.stage("verify"); !ok) return ok.error();
    auto verdict = verify_artifacts(artifacts, scan->scan(), *known, options, session.context);
    if (!verdict) return verdict.error();
    return judged(std::move(*verdict), scan->scan());
  });
}

std::map<std::string, py::bytes> bytes_of(const std::vector<ArtifactFile>& files) {
  std::map<std::string, py::bytes> result;
  for (const auto& file : files) result.emplace(file.name, py::bytes(file.bytes));
  return result;
}

std::map<std::string, py::bytes> emit(const CheckedModel& model, const std::vector<std::string>& to, const Path& out,
                                      const Path& templates, bool force) {
  using Artifacts = std::vector<Artifact>;
  const auto artifacts = run<Artifacts>(shared({}, 0), py::none(), [&](Session& session) -> Result<Artifacts> {
    const auto chosen = chosen_backends(to);
    if (!chosen) return chosen.error();
    if (!out.empty())
      for (const auto& names : {artifact_names(), judgement_names})
        if (auto ok = check_overwriting(out, names, force); !ok) return ok.error();
    auto emitted = emit_all(model, *chosen, templates, session);
    if (!emitted) return emitted.error();
    if (!emitted->failures.empty())
      return bad_input(emitted->failures.front().file + " cannot be written: " + emitted->failures.front().reason);
    if (out.empty()) return std::move(emitted->artifacts);
    if (auto ok = make_folder(out); !ok) return ok.error();
    if (auto written = write_artifacts(emitted->artifacts, out); !written) return written.error();
    return std::move(emitted->artifacts);
  });
  std::vector<ArtifactFile> files;
  for (const auto& artifact : artifacts) files.insert(files.end(), artifact.files.begin(), artifact.files.end());
  return bytes_of(files);
}

CheckedModel model_from_file(const Path& file) {
  auto model = read_model(file);
  if (!model) raise(model.error());
  return std::move(*model);
}

CheckedModel model_from_text(const std::string& json) {
  auto model = read_model_json(json, "the model");
  if (!model) raise(model.error());
  auto whole = checked(std::move(*model), "the model");
  if (!whole) raise(whole.error());
  return std::move(*whole);
}

py::list texts(const std::vector<std::string>& lines) {
  py::list result;
  for (const auto& line : lines) result.append(text(line));
  return result;
}

/// A property whose array looks at the memory of its object.
template <class Owner, class Get>
auto looking(Get get) {
  return py::cpp_function([get](const py::object& self) { return get(self.cast<const Owner&>(), self); });
}

void declare_scan(py::module_& module) {
  const auto cloud = [](auto column) {
    return looking<ReadScan>(
        [column](const ReadScan& s, py::handle self) { return array_of(s.scan().cloud.*column, self); });
  };
  const auto mesh = [](auto part) {
    return looking<ReadScan>(
        [part](const ReadScan& s, py::handle self) { return array_of(s.scan().mesh.*part, self); });
  };
  py::class_<ReadScan, std::shared_ptr<ReadScan>>(module, "Scan",
                                                  "All files of one part in one frame, in mm. Arrays are read-only "
                                                  "views of the scan's own memory, without a copy,\n"
                                                  "and keep it alive; what a scan does not have is None.")
      .def_property_readonly("points", cloud(&PointCloud::points),
                             "(N, 3) float64, mm; of a mesh its corners, and more on large facets")
      .def_property_readonly("normals", cloud(&PointCloud::normals),
                             "(N, 3) float64, unit, outward where that is known; zero where unknown")
      .def_property_readonly("rays", cloud(&PointCloud::rays), "(N, 3) float64, unit, from the sensor to the point")
      .def_property_readonly("sigma", cloud(&PointCloud::sigma),
                             "(N,) float32, mm: standard deviation along the normal")
      .def_property_readonly("view", cloud(&PointCloud::view), "(N,) int32: index into views")
      .def_property_readonly("rejected", looking<ReadScan>([](const ReadScan& s, py::handle self) {
                               return truths_of(s.scan().cloud.rejected, self);
                             }),
                             "(N,) bool: a filter or the fit says that it is an outlier")
      .def_property_readonly("vertices", mesh(&TriangleMesh::vertices), "(V, 3) float64, mm, of a mesh")
      .def_property_readonly("triangles", mesh(&TriangleMesh::triangles),
                             "(M, 3) uint32: vertices, counter-clockwise seen from outside")
      .def_property_readonly(
          "views",
          [](const ReadScan& s) {
            py::list names;
            for (const auto& view : s.scan().views) names.append(text(view.file));
            return names;
          },
          "file of each view")
      .def_property_readonly(
          "files", [](const ReadScan& s) { return s.files; }, "what was read, as it was given")
      .def_property_readonly(
          "warnings", [](const ReadScan& s) { return texts(s.scan().warnings); },
          "what was mended or left out, one line each")
      .def_property_readonly(
          "unit_scale", [](const ReadScan& s) { return s.scan().unit_scale; }, "mm per unit of the files")
      .def("__len__", [](const ReadScan& s) { return s.scan().cloud.size(); })
      .def("__repr__", [](const ReadScan& s) {
        return "<partscribe.Scan of " + std::to_string(s.scan().cloud.size()) + " points in " +
               std::to_string(s.scan().views.size()) + (s.scan().views.size() == 1 ? " view>" : " views>");
      });
}

void declare_answers(py::module_& module) {
  py::class_<Measured>(module, "Measured")
      .def_property_readonly(
          "json", [](const Measured& m) { return text(m.json); }, "faces.json")
      .def_property_readonly("face_of", looking<Measured>([](const Measured& m, py::handle self) {
                               return array_of(m.faces.face_of, self);
                             }),
                             "uint32 per triangle or point: index into the faces, or 2**32 - 1");
  py::class_<Judged, std::shared_ptr<Judged>>(module, "Judged")
      .def_property_readonly(
          "json", [](const Judged& j) { return text(write_verdict_json(j.verdict)); }, "verdict.json")
      .def_property_readonly(
          "table", [](const Judged& j) { return text(verdict_table(j.verdict)); }, "what the command prints")
      .def_property_readonly(
          "exit_code", [](const Judged& j) { return exit_code_of(j.verdict.verdict); }, "of the command")
      .def(
          "deviations",
          [](const py::object& self, std::size_t artifact) {
            return array_of(self.cast<const Judged&>().deviations.at(artifact), self);
          },
          py::arg("artifact"), "(N,) float32, mm")
      .def(
          "vertices",
          [](const py::object& self, std::size_t artifact) {
            return array_of(self.cast<const Judged&>().verdict.artifacts.at(artifact).mesh.vertices, self);
          },
          py::arg("artifact"), "(V, 3) float64, mm")
      .def(
          "triangles",
          [](const py::object& self, std::size_t artifact) {
            return array_of(self.cast<const Judged&>().verdict.artifacts.at(artifact).mesh.triangles, self);
          },
          py::arg("artifact"), "(M, 3) uint32");
  py::class_<Built>(module, "Built")
      .def_property_readonly(
          "json", [](const Built& b) { return text(b.json); }, "what build --json prints")
      .def_property_readonly(
          "model", [](const Built& b) { return text(b.model); }, "model.json")
      .def_property_readonly(
          "artifacts", [](const Built& b) { return bytes_of(b.artifacts); }, "files by name")
      .def_property_readonly(
          "scan", [](const Built& b) { return b.scan; }, "as the fit saw it")
      .def_property_readonly(
          "judged", [](const Built& b) { return b.judged; }, "the verdict");
  py::class_<CheckedModel>(module, "Model")
      .def_static("read", &model_from_file, py::arg("file"), "of a model.json")
      .def_static("parse", &model_from_text, py::arg("json"), "of the text of one")
      .def_property_readonly(
          "json", [](const CheckedModel& m) { return text(write_model_json(*m)); }, "model.json")
      .def(
          "explain", [](const CheckedModel& m) { return text(explanation(*m)); }, "what the command prints");
}

}  // namespace

PYBIND11_MODULE(_native, module) {
  module.doc() = "The compiled part of partscribe.";
  module.attr("version") = PARTSCRIBE_VERSION;
  declare_scan(module);
  declare_answers(module);
  module.def("read", &read, py::arg("files"), py::arg("units"), py::arg("poses"), py::arg("registration"),
             py::arg("fiducials"), py::arg("correct_depth"), py::arg("filter"), py::arg("threads"),
             py::arg("progress"));
  module.def("measure", &measure, py::arg("scan"), py::arg("tolerance"), py::arg("threads"), py::arg("progress"));
  module.def("build", &build, py::arg("scan"), py::arg("tolerance"), py::arg("out"), py::arg("name"), py::arg("to"),
             py::arg("nominal"), py::arg("procedure"), py::arg("templates"), py::arg("force"), py::arg("threads"),
             py::arg("progress"));
  module.def("verify", &verify, py::arg("artifacts"), py::arg("scan"), py::arg("tolerance"), py::arg("model"),
             py::arg("rule"), py::arg("strict"), py::arg("align"), py::arg("outliers"), py::arg("time_limit"),
             py::arg("second_opinion"), py::arg("threads"), py::arg("progress"));
  module.def("emit", &emit, py::arg("model"), py::arg("to"), py::arg("out"), py::arg("templates"), py::arg("force"));
}

}  // namespace partscribe::python
