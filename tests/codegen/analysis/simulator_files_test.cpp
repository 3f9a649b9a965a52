/// What a simulator reads in URDF and MJCF, parsed by expat.
#include "codegen/analysis/simulator_files.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "codegen/analysis/density.h"
#include "geometry/io/read_geometry.h"
#include "testing/xml_elements.h"

namespace partscribe::testing {

using namespace codegen;
using namespace geometry;

namespace {

/// 30 x 20 x 10 mm of steel, off its centre.
SimulatedBody bar() {
  SimulatedBody body{"bar", "bar.stl", {}, 7850};
  body.mass.volume = 6000;
  body.mass.centroid = {15, 10, 5};
  body.mass.inertia = Vec3(250000, 500000, 650000).asDiagonal();
  body.mass.inertia(0, 1) = body.mass.inertia(1, 0) = -1234;
  return body;
}

}  // namespace

TEST_CASE("simulator files: URDF has mass, centre and inertia in SI units") {
  const auto xml = xml_elements(urdf_text(bar()));
  CHECK(xml_attribute(xml, "robot", "name") == "bar");
  CHECK(xml_attribute(xml, "robot/link", "name") == "bar");
  const std::string inertial = "robot/link/inertial/";
  CHECK(xml_numbers(xml, inertial + "mass", "value")[0] == Approx(6e-6 * 7850).epsilon(1e-8));
  CHECK(xml_numbers(xml, inertial + "origin", "xyz") == std::vector<double>{0.015, 0.01, 0.005});
  CHECK(xml_numbers(xml, inertial + "origin", "rpy") == std::vector<double>{0, 0, 0});
  const double scale = 7850 * 1e-15;
  for (const auto& [key, value] : std::map<std::string, double>{
           {"ixx", 250000}, {"iyy", 500000}, {"izz", 650000}, {"ixy", -1234}, {"ixz", 0}, {"iyz", 0}})
    CHECK(xml_numbers(xml, inertial + "inertia", key)[0] == Approx(value * scale).epsilon(1e-8));
  for (const char* use : {"visual", "collision"})
    CHECK(xml_attribute(xml, std::string("robot/link/") + use + "/geometry/mesh", "filename") == "bar.stl");
}

TEST_CASE("simulator files: MJCF says the same of a free body") {
  const auto xml = xml_elements(mjcf_text(bar()));
  CHECK(xml_attribute(xml, "mujoco/asset/mesh", "file") == "bar.stl");
  const std::string inertial = "mujoco/worldbody/body/inertial";
  CHECK(xml_numbers(xml, inertial, "mass")[0] == Approx(6e-6 * 7850).epsilon(1e-8));
  CHECK(xml_numbers(xml, inertial, "pos") == std::vector<double>{0.015, 0.01, 0.005});
  const auto inertia = xml_numbers(xml, inertial, "fullinertia");
  REQUIRE(inertia.size() == 6);
  CHECK(inertia[2] == Approx(650000.0 * 7850 * 1e-15).epsilon(1e-8));
  CHECK(inertia[3] == Approx(-1234 * 7850 * 1e-15).epsilon(1e-8));  // xy comes before xz and yz
  CHECK(xml_attribute(xml, "mujoco/worldbody/body/geom", "mesh") == "bar");
}

TEST_CASE("simulator files: bad_name: what XML keeps for itself is written so that it reads back") {
  SimulatedBody body = bar();
  body.name = "a<b>&\"c'\x01", body.mesh = "Größe \"1\" & 2.stl";
  for (const auto& [text, root] :
       {std::pair(urdf_text(body), std::string("robot/link")), {mjcf_text(body), std::string("mujoco/worldbody/body")}})
    CHECK(xml_attribute(xml_elements(text), root, "name") == "a<b>&\"c' ");
  CHECK(xml_attribute(xml_elements(urdf_text(body)), "robot/link/visual/geometry/mesh", "filename") == body.mesh);
}

TEST_CASE("simulator files: the mesh is in metres, and says so") {
  const TriangleMesh triangle{{{0, 0, 0}, {1000, 0, 0}, {0, 250, 0}}, {{{0, 1, 2}}}};
  const std::string bytes = mesh_in_metres(triangle);
  CHECK(bytes.starts_with("binary STL, metres "));
  CHECK(bytes.substr(0, 80).find("milli") == std::string::npos);
  const auto read = parse_geometry(bytes, "t.stl");
  REQUIRE(read.ok());
  CHECK(area(read->mesh) == Approx(0.125));
}

TEST_CASE("simulator files: materials are in alphabetical order and as heavy as tables say") {
  CHECK(density_of("steel") == 7850);
  CHECK(density_of("aluminium") == 2700);
  CHECK(density_of("pla") == 1240);
  CHECK_FALSE(density_of("unobtainium"));
  for (std::size_t i = 1; i < materials().size(); ++i) CHECK(materials()[i - 1].name < materials()[i].name);
}

}  // namespace partscribe::testing
