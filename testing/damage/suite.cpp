#include "testing/damage/suite.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <thread>

#include "codegen/emit.h"
#include "core/number.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/mesh_distance.h"
#include "model/distance/distance.h"
#include "testing/damage/file_damage.h"
#include "testing/damage/parts.h"
#include "verify/compare/samples.h"
#include "verify/evaluate/evaluate.h"

namespace partscribe::testing {

using namespace codegen;

namespace {

struct Subject {
  Model truth;
  Scan scan;
  TriangleMesh mesh;
  double extent = 0, spacing = 0;
  bool sheet = false;
};

std::string suffix_of(const std::string& backend) {
  for (const auto& b : backends())
    if (b.name == backend) return b.suffix;
  return ".stl";
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c | 0x20) : c; });
  return text;
}

/// The artifact of a model; no files where the backend cannot write it.
Artifact written(const Model& model, const std::string& backend) {
  Context context;
  const auto fine = checked(model, "damaged model");
  if (!fine.ok()) return {};
  const auto artifact = emit(*fine, backend, {}, context);
  return artifact.ok() ? *artifact : Artifact{};
}

Path put(const Artifact& artifact, const Path& folder) {
  std::filesystem::create_directories(folder);
  for (const auto& f : artifact.files)
    if (!write_file(folder / f.name, f.bytes).ok()) return {};
  return folder / artifact.files[0].name;
}

/// What the exact body looks like as facets.
TriangleMesh mesh_of(const Model& model, const Path& folder) {
  Context context;
  const Artifact artifact = written(model, "step");
  if (artifact.files.empty()) return {};
  const auto evaluation = evaluate_artifact(put(artifact, folder), {model.tolerance}, context);
  return evaluation.ok() ? evaluation->mesh : TriangleMesh{};
}

std::string stl_of(const Model& model, const Path& folder) {
  const TriangleMesh mesh = mesh_of(model, folder);
  return mesh.empty() ? std::string() : write_stl(mesh);
}

/// Every n-th, so that at most `most` are left, the first among them.
template <class T>
void thin_out(std::vector<T>& list, std::size_t most) {
  if (list.size() <= most) return;
  std::vector<T> kept;
  for (std::size_t i = 0; i < most; ++i) kept.push_back(std::move(list[i * list.size() / most]));
  list = std::move(kept);
}

void judge(DamageCase& c, const Subject& subject) {
  Context context;
  VerifyOptions options;
  options.tolerance = subject.truth.tolerance;
  options.seconds = c.seconds;
  const auto verdict = verify_artifacts({c.file}, subject.scan, subject.truth, options, context);
  const bool a_refusal = verdict.ok() && verdict->artifacts[0].mesh.empty() && !verdict->artifacts[0].reasons.empty();
  if (!verdict.ok()) {
    c.outcome = "error";
    c.words = verdict.error().message;
  } else {
    const auto& a = verdict->artifacts[0];
    c.outcome = name_of(verdict->verdict);
    c.kept = verdict->verdict == Outcome::verified;
    for (const auto& reason : a.reasons) c.words += reason + "\n";
    for (const auto& f : a.findings)
      if (f.kind != Finding::Kind::not_scanned) c.words += f.text + "\n";
    // Findings that are faults come first.
    const bool found = !a.findings.empty() && a.findings[0].kind != Finding::Kind::not_scanned;
    Vec3 place = Vec3::Zero();
    if (found) {
      c.feature = a.findings[0].feature;
      place = a.findings[0].place;
    } else {
      const auto worst = std::max_element(a.objects.begin(), a.objects.end(),
                                          [](const auto& x, const auto& y) { return x.max < y.max; });
      if (worst != a.objects.end()) c.feature = worst->name;
    }
    // A damage of the whole file may be described by the mesh that came out.
    if (c.says.empty() && !c.harmless && c.harm.faces.empty() && !a.mesh.empty())
      c.harm = partscribe::testing::harm_between(subject.mesh, a.mesh, subject.truth.tolerance);
    // What moves no thousandth of the surface beyond T is no damage of this part.
    if (c.says.empty() && !c.harmless && c.kept && c.harm.places.size() < 2) c.not_applicable = true;
    if (c.harm.faces.empty()) {
      const ModelDistance truth(subject.truth);
      const auto by_face = [&](const std::vector<Vec3>& places) {
        std::map<std::string, std::size_t> hits;
        for (const auto& p : places)
          if (const auto hit = truth(p); hit.face >= 0) ++hits[truth.faces()[std::size_t(hit.face)].name];
        return hits;
      };
      const auto hits = by_face(c.harm.places);
      std::vector<Vec3> everywhere;
      for (const auto& s : even_samples(subject.mesh, 1000)) everywhere.push_back(s.point);
      auto all = by_face(everywhere);
      std::size_t most = 0;
      for (const auto& [name, n] : hits) most = std::max(most, n);
      // Faces that hold much of the damage, and small ones of which it is a good part: a face that was tilted stays
      // where it was in its middle.
      for (const auto& [name, n] : hits)
        if (5 * n >= most || (n >= 5 && 3 * n >= all[name])) c.harm.faces.push_back(name);
    }
    const auto& faces = c.harm.faces;
    c.named = std::any_of(faces.begin(), faces.end(), [&](const std::string& f) { return f == c.feature; });
    const bool a_face =
        std::any_of(a.objects.begin(), a.objects.end(), [&](const auto& o) { return o.name == c.feature; }) && [&] {
          const ModelDistance truth(subject.truth);
          return std::any_of(truth.faces().begin(), truth.faces().end(),
                             [&](const auto& f) { return f.name == c.feature; });
        }();
    // Features that the verifier found and named itself are right if they are where the damage is; so are neighbours of
    // a face that the artifact no longer has.
    if (!c.named && found && (!a_face || c.kind == "fillet or edge missing"))
      c.named = std::any_of(c.harm.places.begin(), c.harm.places.end(), [&](const Vec3& p) {
        return (p - place).norm() < 3 * subject.spacing + 2 * subject.truth.tolerance;
      });
  }
  // What its own program refuses to make has no features; the program's complaint is what can be said.
  if (!c.kept && c.says.empty() && a_refusal) c.named = true;
  if (!c.says.empty()) {
    const std::string said = lower(c.words);
    c.named = std::any_of(c.says.begin(), c.says.end(),
                          [&](const std::string& w) { return said.find(w) != std::string::npos; });
  }
}

}  // namespace

Harm harm_between(const TriangleMesh& truth, const TriangleMesh& damaged, double beyond) {
  Harm harm;
  const MeshDistance to_truth(truth), to_damaged(damaged);
  for (const auto& s : even_samples(truth, 1000))
    if (to_damaged.closest(s.point).distance > beyond) harm.places.push_back(s.point);
  for (const auto& s : even_samples(damaged, 1000))
    if (to_truth.closest(s.point).distance > beyond) harm.places.push_back(s.point);
  return harm;
}

std::vector<DamageCase> damage_part(const std::string& part, const SuiteOptions& options) {
  Subject subject{part_named(part), {}, {}, 0, 0, false};
  const Model& truth = subject.truth;
  subject.scan = scan_of(truth);
  subject.sheet = is_sheet(truth.objects.back().shape);
  const TemporaryDirectory folder;
  std::size_t number = 0;
  auto next_folder = [&] { return folder.path() / print_number(double(number++)); };
  subject.mesh = mesh_of(truth, next_folder());
  subject.extent = subject.mesh.bounds().diagonal();
  subject.spacing = std::sqrt(area(subject.mesh) / 1000);

  std::vector<DamageCase> cases;
  std::map<std::string, Artifact> artifacts;
  auto asked = [&](const std::string& kind) {
    return options.kinds.empty() || std::find(options.kinds.begin(), options.kinds.end(), kind) != options.kinds.end();
  };
  auto wanted = [&](const std::string& backend) { return !(subject.sheet && backend == "mesh"); };
  auto add = [&](const std::string& backend, const std::string& kind, const std::string& damage, bool harmless,
                 const Path& file) -> DamageCase& {
    auto& c = cases.emplace_back();
    c.part = part, c.backend = backend, c.kind = kind, c.damage = damage, c.harmless = harmless, c.file = file;
    c.not_applicable = file.empty();
    return c;
  };
  auto put_model = [&](const Model& model, const std::string& backend) -> Path {
    if (backend != "mesh") {
      const Artifact artifact = written(model, backend);
      return artifact.files.empty() ? Path() : put(artifact, next_folder());
    }
    const std::string bytes = stl_of(model, next_folder());
    return bytes.empty() ? Path() : put({"mesh", {{"part.stl", bytes}}}, next_folder());
  };
  for (const auto& backend : options.backends) {
    if (!wanted(backend)) continue;
    if (backend != "mesh")
      artifacts[backend] = written(truth, backend);
    else
      artifacts[backend] = {"mesh", {{"part.stl", write_stl(subject.mesh)}}};
    add(backend, "harmless edits", "none", true, put(artifacts[backend], next_folder()));
  }

  std::size_t turn = options.turn;
  if (options.models) {
    std::map<Mutation::Kind, std::vector<Mutation>> by_kind;
    for (auto& m : mutations_of(truth)) by_kind[m.kind].push_back(std::move(m));
    for (auto& [kind, list] : by_kind) {
      const bool harmless = kind == Mutation::Kind::harmless;
      const std::string row = harmless ? "a tenth of T" : name_of(kind);
      if (!asked(row)) continue;
      thin_out(list, options.most);
      for (const auto& m : list) {
        const Harm harm = harmless ? Harm{} : harm_of(truth, m.model, 0.9 * truth.tolerance);
        for (std::size_t b = 0; b < (options.in_turn ? 1 : options.backends.size()); ++b) {
          const auto& backend = options.backends[(turn + b) % options.backends.size()];
          if (!wanted(backend)) continue;
          auto& c = add(backend, row, m.name, harmless, put_model(m.model, backend));
          c.moved = m.moved;
          c.harm = harm;
          c.whole = of_whole_part(kind);
          if (c.whole) c.says = {"whole part"};
          if (kind == Mutation::Kind::body_added) c.says = {"separate body"};
        }
        turn += options.in_turn;
      }
    }
  }
  if (options.files)
    for (const auto& backend : options.backends) {
      if (!wanted(backend)) continue;
      const auto& artifact = artifacts[backend];
      const std::string other = backend == "step" ? "iges" : "step";
      const FileSubject file{backend,
                             suffix_of(backend),
                             artifact.files[0].bytes,
                             truth,
                             subject.mesh,
                             [&](const Model& m) {
                               if (backend == "mesh") return stl_of(m, next_folder());
                               const Artifact a = written(m, backend);
                               return a.files.empty() ? std::string() : a.files[0].bytes;
                             },
                             written(truth, other).files[0].bytes,
                             subject.extent};
      std::map<std::string, std::vector<FileDamage>> by_kind;
      for (auto& d : file_damages(file)) by_kind[d.kind].push_back(std::move(d));
      for (auto& [kind, list] : by_kind) {
        if (!asked(kind)) continue;
        thin_out(list, kind == "harmless edits" ? 2 * options.most : options.most);
        for (auto& d : list) {
          Artifact damaged = artifact;
          damaged.files[0].bytes = d.bytes;
          if (d.without_companions) damaged.files.resize(1);
          auto& c = add(backend, d.kind, d.name, d.harmless, put(damaged, next_folder()));
          c.says = d.says;
          c.seconds = d.seconds;
        }
      }
    }

  std::atomic<std::size_t> next = 0;
  std::vector<std::thread> workers;
  for (int t = 0; t < options.threads; ++t)
    workers.emplace_back([&] {
      for (std::size_t i; (i = next++) < cases.size();)
        if (!cases[i].not_applicable) judge(cases[i], subject);
    });
  for (auto& worker : workers) worker.join();
  std::erase_if(cases, [](const DamageCase& c) { return c.not_applicable; });
  return cases;
}

std::string markdown_table(const std::vector<DamageCase>& cases) {
  const std::vector<std::pair<std::string, std::string>> columns = {
      {"openscad", ".scad"}, {"alpha1", ".scl"}, {"iges", ".igs"}, {"step", ".step"}, {"mesh", ".stl"}};
  struct Count {
    std::size_t tried = 0, right = 0, named = 0;
  };
  std::map<std::string, std::map<std::string, Count>> damages, harmless;
  for (const auto& c : cases) {
    auto& all = c.harmless ? harmless : damages;
    for (const auto& column : {c.backend, std::string("all")}) {
      Count& n = all[c.kind][column];
      ++n.tried, n.right += c.kept == c.harmless, n.named += !c.kept && c.named;
      Count& sum = all["~"][column];
      ++sum.tried, sum.right += c.kept == c.harmless, sum.named += !c.kept && c.named;
    }
  }
  auto table = [&](const std::string& title, std::map<std::string, std::map<std::string, Count>>& rows,
                   bool with_names) {
    std::string text = "| " + title + " |";
    for (const auto& c : columns) text += " " + c.second + " |";
    text += " all |\n|---|" + std::string(6 * 4, '-').replace(0, 24, "---|---|---|---|---|---|") + "\n";
    for (auto& [kind, counts] : rows) {
      text += "| " + (kind == "~" ? std::string("**all**") : kind) + " |";
      for (const auto& column : {"openscad", "alpha1", "iges", "step", "mesh", "all"}) {
        const Count n = counts.count(column) ? counts.at(column) : Count{};
        text += n.tried == 0
                    ? " - |"
                    : " " + print_number(double(n.right)) + (with_names ? " / " + print_number(double(n.named)) : "") +
                          " / " + print_number(double(n.tried)) + " |";
      }
      text += "\n";
    }
    return text;
  };
  return table("damage: refused / named / tried", damages, true) + "\n" +
         table("harmless: verified / tried", harmless, false);
}

std::string line_of(const DamageCase& c) {
  std::string words = c.words;
  std::replace(words.begin(), words.end(), '\n', '|');
  std::string faces;
  for (const auto& f : c.harm.faces) faces += (faces.empty() ? "" : ",") + f;
  const std::string fate = c.harmless ? (c.kept ? "ok" : "HARMLESS REFUSED")
                           : c.kept   ? "NOT REFUSED"
                           : c.named  ? "ok"
                                      : "NOT NAMED";
  return fate + "\t" + c.part + "\t" + c.backend + "\t" + c.kind + "\t" + c.damage + "\t" +
         print_number(snapped(c.moved, 1e-4)) + "\t" + c.outcome + "\t" + c.feature + "\t[" + faces + "]\t" + words;
}

}  // namespace partscribe::testing
