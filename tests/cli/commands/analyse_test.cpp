/// partscribe analyse, as a user runs it on models whose mass is known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/number.h"
#include "geometry/io/read_geometry.h"
#include "model/json.h"
#include "testing/json_schema.h"
#include "testing/models.h"
#include "testing/program.h"
#include "testing/xml_elements.h"

namespace partscribe::testing {

using namespace geometry;

namespace {

using Json = nlohmann::json;

/// 30 x 20 x 10 mm with a bore of 4 mm radius, laid into the scan's frame by a motion.
Model bored_block() {
  const auto p = [](const char* name) { return Expr::of(name); };
  Model m;
  m.name = "bored_block";
  m.parameters = {length("length", 30), length("bore_radius", 4)};
  m.parameters[0].sigma = 0.02;
  m.objects = {{"block", Box{p("length"), 20, 10}, {}, {}, {}},
               {"drill", Cylinder{p("bore_radius"), 12}, {p("length") / Expr(2), 10, -1, 0, 0, 0}, {}, {}},
               {"body", Difference{{"block", "drill"}}, {}, {}, {}}};
  m.scan_from_part = {100, 0, 0, 0, 0, pi / 2};
  return m;
}

const double bored_volume = 6000 - 160 * pi;

/// Writes the model as model.json into the folder and runs the command there.
ProcessOutput analysed(const TemporaryDirectory& folder, const Model& m, std::vector<std::string> more) {
  REQUIRE(write_file(folder.path() / "model.json", write_model_json(m)).ok());
  more.insert(more.begin(), {"analyse", "model.json"});
  return run_partscribe(more, folder.path());
}

Json json_of(const ProcessOutput& output) {
  INFO(output.out << output.err);
  REQUIRE(output.exit_code == 0);
  const auto json = Json::parse(output.out);
  CHECK(JsonSchema(source_file("docs/analysis.schema.json")).fault(json, JsonSchema::Keys::named) == "");
  return json;
}

Json row_of(const Json& json, const std::string& parameter) {
  for (const auto& row : json.at("sensitivities"))
    if (row.at("parameter") == parameter) return row;
  FAIL("no row for " << parameter);
  return {};
}

/// The same without a word of progress: one line is left, if something is wrong.
ProcessOutput quietly(const TemporaryDirectory& folder, const Model& m, std::vector<std::string> more) {
  more.emplace_back("--quiet");
  return analysed(folder, m, more);
}

void check_refused(const ProcessOutput& output, int code, const std::string& words) {
  INFO(output.out << output.err);
  CHECK(output.exit_code == code);
  CHECK(output.out.empty());
  CHECK(output.err.starts_with("partscribe: "));
  CHECK(std::count(output.err.begin(), output.err.end(), '\n') == 1);
  CHECK(output.err.find(words) != std::string::npos);
}

}  // namespace

TEST_CASE("analyse: a bored block of aluminium has its mass, centroid and inertia, in the frame of the scan") {
  const TemporaryDirectory folder;
  const auto json = json_of(analysed(folder, bored_block(), {"--density", "aluminium", "--json"}));
  CHECK(json["volume"].get<double>() == Approx(bored_volume).epsilon(1e-8));
  CHECK(json["mass"].get<double>() == Approx(bored_volume * 2700e-9).epsilon(1e-8));
  CHECK(json["area"].get<double>() == Approx(2200 - 32 * pi + 80 * pi).epsilon(1e-8));
  // A quarter turn about z, then 100 mm along x: (15, 10, 5) comes to lie at (90, 15, 5).
  const Vec3 centroid(json["centroid"][0], json["centroid"][1], json["centroid"][2]);
  CHECK((centroid - Vec3(90, 15, 5)).norm() < 1e-7);
  const double rho = 2700e-9, bore = 160 * pi;
  const double along = rho * (6000 * (400 + 100) / 12.0 - bore * (3 * 16 + 100) / 12);
  const double across = rho * (6000 * (900 + 100) / 12.0 - bore * (3 * 16 + 100) / 12);
  const double upright = rho * (6000 * (900 + 400) / 12.0 - bore * 16 / 2);
  CHECK(json["inertia"][0][0].get<double>() == Approx(across).epsilon(1e-7));
  CHECK(json["inertia"][1][1].get<double>() == Approx(along).epsilon(1e-7));
  CHECK(json["inertia"][2][2].get<double>() == Approx(upright).epsilon(1e-7));
  CHECK(json["principal"][0]["moment"].get<double>() == Approx(along).epsilon(1e-7));
  CHECK(json["principal"][0]["axis"] == Json({0, 1, 0}));
  CHECK(json["principal"][2]["gyration"].get<double>() ==
        Approx(std::sqrt(upright / (rho * bored_volume))).epsilon(1e-7));
  CHECK(json["sigma"]["mass"].get<double>() == Approx(200 * 0.02 * rho).epsilon(2e-3));
  CHECK(json["sigma"]["parameters"] == Json({"length"}));

  const auto own = json_of(run_partscribe({"analyse", folder.path().string(), "--frame", "part", "--quick", "--json"}));
  CHECK(own["centroid"][0].get<double>() == Approx(15).epsilon(1e-9));
  CHECK(own["material"] == "steel");  // the default
  CHECK(own["mass"].get<double>() == Approx(bored_volume * 7850e-9).epsilon(1e-8));
  CHECK_FALSE(own.contains("sensitivities"));
}

TEST_CASE("analyse: sensitivities are the derivatives, and the table begins with what matters most") {
  const TemporaryDirectory folder;
  const auto json = json_of(analysed(folder, bored_block(), {"--density", "1000", "--json"}));
  CHECK(row_of(json, "length")["volume"].get<double>() == Approx(200).epsilon(1e-6));
  CHECK(row_of(json, "length")["mass"].get<double>() == Approx(2e-4).epsilon(1e-6));
  CHECK(row_of(json, "length")["centroid"][1].get<double>() == Approx(0.5).epsilon(1e-6));
  CHECK(row_of(json, "bore_radius")["volume"].get<double>() == Approx(-80 * pi).epsilon(1e-6));
  const auto weight = [&](std::size_t row) { return json["sensitivities"][row]["weight"].get<double>(); };
  CHECK(weight(0) > weight(1));
  const auto table = run_partscribe({"analyse", (folder.path() / "model.json").string()});
  CHECK(table.exit_code == 0);
  const std::string first = json["sensitivities"][0]["parameter"], second = json["sensitivities"][1]["parameter"];
  const auto begin = table.out.find("What each dimension does");
  REQUIRE(begin != std::string::npos);
  CHECK(table.out.find(first + " ", begin) < table.out.find(second + " ", begin));
}

TEST_CASE("analyse: the value for a wished mass is found, and the model written with it weighs that") {
  const TemporaryDirectory folder;
  // 0.1 kg of steel are 12738.85 mm^3.
  const auto json = json_of(
      analysed(folder, bored_block(), {"--target", "mass=0.1kg", "--by", "length", "--out", "heavier.json", "--json"}));
  const double expected = (0.1 / 7850 * 1e9 + 160 * pi) / 200;
  CHECK(json["target"]["value"].get<double>() == Approx(expected).epsilon(1e-6));
  CHECK(json["target"]["mass"].get<double>() == Approx(0.1).epsilon(1e-6));
  CHECK(json["target"]["before"] == 30);
  CHECK(json["files"] == Json({"heavier.json"}));
  const auto again = json_of(run_partscribe({"analyse", "heavier.json", "--quick", "--json"}, folder.path()));
  CHECK(again["mass"].get<double>() == Approx(0.1).epsilon(1e-6));
  const auto written = Json::parse(bytes_of(folder.path() / "heavier.json"));
  CHECK(written["parameters"][0]["value"] == json["target"]["value"]);
  CHECK(written["parameters"][0]["note"] == "chosen for 100 g");
  CHECK(written["parameters"][1]["value"] == 4);
  // The frame of the numbers is no frame of the model.
  CHECK(json_of(run_partscribe({"analyse", "model.json", "--frame", "part", "--target", "volume=5cm3", "--by",
                                "bore_radius", "--out", "lighter", "--json"},
                               folder.path()))["target"]["value"]
            .get<double>() == Approx(std::sqrt(100 / pi)).epsilon(1e-6));
  CHECK(Json::parse(bytes_of(folder.path() / "lighter/model.json"))["scan_from_part"] == written["scan_from_part"]);
}

TEST_CASE("analyse: URDF and MJCF have the mass and inertia, and a closed mesh in metres beside them") {
  const TemporaryDirectory folder;
  const auto json =
      json_of(analysed(folder, bored_block(), {"--urdf", "bored.urdf", "--mjcf", "bored.xml", "--quick", "--json"}));
  CHECK(json["files"] == Json({"bored.urdf", "bored.xml", "bored.stl"}));
  const auto urdf = xml_elements(bytes_of(folder.path() / "bored.urdf"));
  const std::string inertial = "robot/link/inertial/";
  CHECK(xml_numbers(urdf, inertial + "mass", "value")[0] == Approx(json["mass"].get<double>()).epsilon(1e-8));
  const auto origin = xml_numbers(urdf, inertial + "origin", "xyz");
  REQUIRE(origin.size() == 3);
  for (int k = 0; k < 3; ++k) CHECK(1000 * origin[k] == Approx(json["centroid"][k].get<double>()).epsilon(1e-6));
  const char* const keys[3][3] = {{"ixx", "ixy", "ixz"}, {"ixy", "iyy", "iyz"}, {"ixz", "iyz", "izz"}};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      CHECK(1e6 * xml_numbers(urdf, inertial + "inertia", keys[r][c])[0] ==
            Approx(json["inertia"][r][c].get<double>()).epsilon(1e-8).margin(1e-12));
  for (const char* use : {"visual", "collision"})
    CHECK(xml_attribute(urdf, std::string("robot/link/") + use + "/geometry/mesh", "filename") == "bored.stl");
  const auto mjcf = xml_elements(bytes_of(folder.path() / "bored.xml"));
  CHECK(xml_attribute(mjcf, "mujoco/asset/mesh", "file") == "bored.stl");
  CHECK(xml_numbers(mjcf, "mujoco/worldbody/body/inertial", "mass")[0] ==
        Approx(json["mass"].get<double>()).epsilon(1e-8));

  Context context;
  const auto read = read_geometry(folder.path() / "bored.stl", context);
  REQUIRE(read.ok());
  const auto mesh = welded(read->mesh, 1e-7);
  CHECK(topology(mesh).closed());
  CHECK(1e9 * volume(mesh) == Approx(bored_volume).epsilon(1e-3));
  const Box3 bounds = mesh.bounds();
  CHECK((1000 * bounds.low - Vec3(80, 0, 0)).norm() < 1e-4);
  CHECK((1000 * bounds.high - Vec3(100, 30, 10)).norm() < 1e-4);
}

TEST_CASE("analyse: the bundled pin, whose numbers come from the bundled model") {
  const auto json = json_of(run_partscribe({"analyse", source_file("corpus/pin").string(), "--json"}));
  const auto model = Json::parse(bytes_of(source_file("corpus/pin/model.json")));
  std::set<std::string> free;
  for (const auto& p : model.at("parameters"))
    if (!p.contains("formula")) free.insert(p.at("name"));
  CHECK(json["sensitivities"].size() == free.size());
  for (const auto& row : json["sensitivities"]) {
    CHECK(free.count(row["parameter"]) == 1);
    CHECK_FALSE(row.contains("fault"));
  }
}

TEST_CASE("analyse: the same model gives the same bytes, and --json names a file") {
  const TemporaryDirectory folder;
  const auto first = analysed(folder, bored_block(), {"--json"});
  CHECK(analysed(folder, bored_block(), {"--json", "--threads", "1"}).out == first.out);
  const auto named = analysed(folder, bored_block(), {"--json", "mass.json"});
  CHECK(named.exit_code == 0);
  CHECK(named.out.find("Wrote mass.json") != std::string::npos);
  CHECK(bytes_of(folder.path() / "mass.json") == first.out);
}

TEST_CASE("analyse: bad_input: an open surface, a missing file and a broken model end with 3 and one line") {
  const TemporaryDirectory folder;
  check_refused(quietly(folder, model_with(cowl()), {}), 3,
                "expected a solid, found an open surface_set, which has a surface but no volume");
  const Model sheet = model_with(TriSurface{{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}, {{0, 1, 2}}, false, 0});
  check_refused(quietly(folder, sheet, {}), 3, "expected a solid, found an open tri_surface");
  check_refused(run_partscribe({"analyse", "missing.json", "--quiet"}, folder.path()), 3, "missing.json");
  check_refused(run_partscribe({"analyse", source_file("corpus").string(), "--quiet"}), 3, "model.json");
  for (const char* text : {"", "{", "[]", "null", "{\"format\": 1}", "\xff\xfe", "{\"format\": 1, \"objects\": 3}"}) {
    REQUIRE(write_file(folder.path() / "broken.json", text).ok());
    INFO(text);
    check_refused(run_partscribe({"analyse", "broken.json", "--quiet"}, folder.path()), 3, "broken.json");
  }
  Model nothing = bored_block();
  nothing.parameters[1].value = 40;  // the drill leaves nothing
  check_refused(quietly(folder, nothing, {}), 3, "body");
}

TEST_CASE("analyse: bad_usage: every wish that cannot be met ends with 2 and one line that says why") {
  const TemporaryDirectory folder;
  const std::vector<std::pair<std::vector<std::string>, std::string>> bad = {
      {{"--density", "unobtainium"}, "--density: expected kg/m^3"},
      {{"--density", "0"}, "--density: expected kg/m^3"},
      {{"--target", "mass=1"}, "the unit is missing"},
      {{"--target", "mass=1kg"}, "--by NAME"},
      {{"--by", "length"}, "--target mass="},
      {{"--out", "x.json"}, "--target"},
      {{"--target", "mass=1kg", "--by", "lenght"}, "(length, bore_radius)"},
      {{"--target", "volume=7000mm3", "--by", "bore_radius"}, "no value of bore_radius gives 7000 mm^3"},
      {{"--urdf", "part.stl"}, "its mesh goes into the .stl of the same name"},
      {{"--urdf", "missing/part.urdf"}, "there is no folder missing"},
      {{"--urdf", "model.json"}, "is read by this command"},
      {{"--urdf", "a.xml", "--mjcf", "a.xml"}, "two options name the same file"},
      {{"--urdf", "a.json", "--json-file", "./a.json"}, "two options name the same file"},
      {{"--frame", "world"}, "expected one of scan, part"},
      {{"--target", "mass=0.1kg", "--by", "length", "--out", "model.json"}, "exists already"},
  };
  for (const auto& [arguments, words] : bad) {
    INFO(arguments.back());
    check_refused(quietly(folder, bored_block(), arguments), 2, words);
  }
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

}  // namespace partscribe::testing
