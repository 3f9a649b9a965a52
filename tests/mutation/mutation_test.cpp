/// A verifier that never refused has verified nothing: damaged parts, written by every backend and run by its own
/// program, against points of the true part.
///
/// Every damage of a parameter, every missing feature, mirror and scale goes through all backends; placements, other
/// numbers and harmless changes, of which there are many, take the backends in turn. PARTSCRIBE_MUTATION_ALL=1: all
/// through all. PARTSCRIBE_MUTATION_TABLE=FILE appends a line per damage and backend to FILE.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <set>
#include <thread>

#include "codegen/emit.h"
#include "core/number.h"
#include "core/random.h"
#include "model/json.h"
#include "verify/mutate.h"
#include "verify/verify.h"

using namespace partscribe;

namespace {

constexpr std::size_t scanned_points = 8000;

/// Parts whose curved surfaces take a second or more to mesh at a tenth of their 0.1 mm: judged at 0.4 mm, with
/// damages and noise four times as large.
const std::set<std::string> coarser = {"ellipsoid", "nurbs_vase", "sphere", "superellipsoid", "torus"};

/// Where one run takes many seconds, only the first damage of each kind is tried, and nothing harmless.
struct Heavy {
  std::string part, backend, reason;
};
const std::vector<Heavy> heavy = {
    {"lens", "openscad", "2021.01 intersects and cuts polyhedral spheres exactly: four seconds on an idle machine"},
};

Model golden(const std::string& part) {
  const Path file = Path(PARTSCRIBE_SOURCE_DIR) / "tests" / "golden" / part / "model.json";
  const auto text = read_file(file);
  REQUIRE(text.ok());
  auto model = read_model_json(*text, file.string());
  REQUIRE(model.ok());
  if (coarser.count(part)) model->tolerance = 0.4;
  return std::move(model).value();
}

/// Even points of the true surface with a tenth of the tolerance as noise.
Scan scan_of(const Model& model) {
  Scan scan;
  scan.views.push_back({});
  Random random(3);
  for (const auto& p : surface_points(model, scanned_points, 5))
    scan.cloud.points.push_back(p.point + 0.1 * model.tolerance * random.normal() * p.normal);
  return scan;
}

/// One artifact to be judged.
struct Job {
  const Mutation* mutation = nullptr;  // null: the undamaged part
  std::string backend;
  Path file = {};
  std::string found = "", reasons = "";

  bool harmless() const { return !mutation || mutation->kind == Mutation::Kind::harmless; }
  std::string expected() const { return harmless() ? "verified" : "out_of_tolerance"; }
  std::string damage() const { return mutation ? mutation->name : "undamaged"; }
};

std::vector<Job> jobs_for(const std::string& part, const std::vector<Mutation>& mutations) {
  const bool everything = std::getenv("PARTSCRIBE_MUTATION_ALL") != nullptr;
  std::vector<Job> jobs;
  for (const auto& backend : backends()) jobs.push_back({nullptr, backend.name});
  std::set<std::pair<std::string, Mutation::Kind>> tried;
  std::size_t turn = 0;
  for (const auto& mutation : mutations) {
    const auto kind = mutation.kind;
    const bool in_turn =
        kind == Mutation::Kind::number || kind == Mutation::Kind::moved || kind == Mutation::Kind::harmless;
    const bool one = in_turn && !everything;
    for (std::size_t i = 0; i < (one ? 1 : backends().size()); ++i) {
      const std::string& backend = backends()[(turn + i) % backends().size()].name;
      const bool is_heavy = std::any_of(heavy.begin(), heavy.end(),
                                        [&](const Heavy& h) { return h.part == part && h.backend == backend; });
      if (is_heavy && (kind == Mutation::Kind::harmless || !tried.insert({backend, kind}).second)) continue;
      jobs.push_back({&mutation, backend});
    }
    turn += one;
  }
  return jobs;
}

/// Writes the job's artifact into `folder`. One at a time: OpenCASCADE's writers and readers share state.
void write_artifact(Job& job, const Model& truth, const Path& folder) {
  Context context;
  const auto model = checked(job.mutation ? job.mutation->model : truth, "damaged model");
  if (!model.ok()) return void(job.found = model.error().message);
  const auto artifact = emit(*model, job.backend, {}, context);
  if (!artifact.ok()) return void(job.found = artifact.error().message);
  std::filesystem::create_directory(folder);
  for (const auto& f : artifact->files)
    if (const auto written = write_file(folder / f.name, f.bytes); !written.ok())
      return void(job.found = written.error().message);
  job.file = folder / artifact->files[0].name;
}

void judge(Job& job, const Model& truth, const Scan& scan) {
  Context context;
  VerifyOptions options;
  options.tolerance = truth.tolerance;
  // Only a model can say that an open sheet is what was meant.
  const auto* surface = std::get_if<TriSurface>(&truth.objects.back().shape);
  const auto verdict =
      verify({job.file}, scan, surface && !surface->closed ? std::optional(truth) : std::nullopt, options, context);
  if (!verdict.ok()) return void(job.found = verdict.error().message);
  job.found = name_of(verdict->verdict);
  for (const auto& reason : verdict->artifacts[0].reasons) job.reasons += reason + "; ";
}

void refuses_damages(const std::string& part) {
  const Model truth = golden(part);
  const Scan scan = scan_of(truth);
  const auto mutations = mutations_of(truth);
  auto jobs = jobs_for(part, mutations);
  const TemporaryDirectory folder;
  for (std::size_t i = 0; i < jobs.size(); ++i) write_artifact(jobs[i], truth, folder.path() / print_number(double(i)));
  std::atomic<std::size_t> next = 0;
  std::vector<std::thread> workers;
  for (unsigned t = 0; t < std::max(2u, std::thread::hardware_concurrency()); ++t)
    workers.emplace_back([&] {
      for (std::size_t i; (i = next++) < jobs.size();)
        if (!jobs[i].file.empty()) judge(jobs[i], truth, scan);
    });
  for (auto& worker : workers) worker.join();

  std::ofstream table;
  if (const char* file = std::getenv("PARTSCRIBE_MUTATION_TABLE")) table.open(file, std::ios::app);
  for (const auto& job : jobs) {
    INFO(part << ", " << job.damage() << ", " << job.backend << ": " << job.reasons);
    CHECK(job.found == job.expected());
    table << part << '\t' << (job.mutation ? name_of(job.mutation->kind) : "none") << '\t' << job.damage() << '\t'
          << print_number(job.mutation ? job.mutation->moved : 0) << '\t' << job.backend << '\t' << job.found << '\t'
          << job.reasons << '\n';
  }
}

std::size_t count_of(const std::vector<Mutation>& mutations, Mutation::Kind kind) {
  return static_cast<std::size_t>(
      std::count_if(mutations.begin(), mutations.end(), [&](const Mutation& m) { return m.kind == kind; }));
}

}  // namespace

#define REFUSES_DAMAGES(part) \
  TEST_CASE("mutation: damages of " part " are refused, a tenth of the tolerance is not") { refuses_damages(part); }
REFUSES_DAMAGES("box")
REFUSES_DAMAGES("bracket")
REFUSES_DAMAGES("cone")
REFUSES_DAMAGES("cylinder")
REFUSES_DAMAGES("ellipsoid")
REFUSES_DAMAGES("half_spaces")
REFUSES_DAMAGES("lens")
REFUSES_DAMAGES("nurbs_vase")
REFUSES_DAMAGES("pin")
REFUSES_DAMAGES("sheet")
REFUSES_DAMAGES("sphere")
REFUSES_DAMAGES("superellipsoid")
REFUSES_DAMAGES("tie_bar")
REFUSES_DAMAGES("torus")
REFUSES_DAMAGES("tri_surface")
REFUSES_DAMAGES("wedge")

TEST_CASE("mutation: every golden part has its case") {
  std::size_t parts = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Path(PARTSCRIBE_SOURCE_DIR) / "tests" / "golden"))
    parts += std::filesystem::exists(entry.path() / "model.json");
  CHECK(parts == 16);
}

TEST_CASE("mutation: every visible parameter is damaged, every bore can be missing, a chiral part has three mirrors") {
  const auto bracket = mutations_of(golden("bracket"));
  CHECK(count_of(bracket, Mutation::Kind::parameter) == 7);  // all but the overshoot of the cuts
  CHECK(count_of(bracket, Mutation::Kind::missing) == 5);    // both plates, three bores
  CHECK(count_of(bracket, Mutation::Kind::mirrored) == 2);   // it is its own mirror image across its width
  CHECK(count_of(mutations_of(golden("half_spaces")), Mutation::Kind::mirrored) == 3);
  CHECK(count_of(mutations_of(golden("tie_bar")), Mutation::Kind::missing) == 2);
  CHECK(count_of(mutations_of(golden("sphere")), Mutation::Kind::mirrored) == 0);
}

TEST_CASE("mutation: a damage moves the surface by as much as it says") {
  const Model pin = golden("pin");
  for (const auto& m : mutations_of(pin)) {
    INFO(m.name);
    if (m.kind == Mutation::Kind::harmless)
      CHECK(m.moved < 0.15 * pin.tolerance);
    else
      CHECK(m.moved > 1.5 * pin.tolerance);
  }
  // Half a percent about the middle of a bar of 80 mm: 0.2 mm at its ends.
  const auto bar = mutations_of(golden("cylinder"));
  const auto scaled =
      std::find_if(bar.begin(), bar.end(), [](const Mutation& m) { return m.kind == Mutation::Kind::scaled; });
  REQUIRE(scaled != bar.end());
  CHECK(scaled->name == "scaled by 1.005");
  CHECK(scaled->moved == Approx(0.2).epsilon(0.01));
}

TEST_CASE("mutation: points of a surface are as dense everywhere as its area says") {
  const Model bar = golden("cylinder");  // radius 12, length 80
  const Pose part_from_scan = evaluate(bar.scan_from_part, values_of(bar)).inverse();
  const auto points = surface_points(bar, 20000, 1);
  std::size_t ends = 0;
  for (const auto& p : points) {
    const Vec3 q = part_from_scan * p.point;
    const bool on_end = std::abs(q.z()) < 1e-6 || std::abs(q.z() - 80) < 1e-6;
    ends += on_end;
    if (!on_end) CHECK(std::hypot(q.x(), q.y()) == Approx(12).epsilon(1e-8));
  }
  CHECK(double(ends) / 20000 == Approx(12.0 / (12 + 80)).epsilon(0.06));
}
