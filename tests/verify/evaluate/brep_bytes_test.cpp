/// What the reader of STEP and IGES hands back is believed only if it is sound.
#include "verify/evaluate/brep_bytes.h"

#include <catch2/catch.hpp>
#include <limits>

using namespace partscribe::verify;

namespace {

BrepReading triangle() {
  BrepReading reading;
  reading.evaluation.backend = "step";
  reading.evaluation.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  reading.evaluation.mesh.triangles = {{0, 1, 2}};
  reading.evaluation.complaints = {"open"};
  reading.body = "body";
  return reading;
}

}  // namespace

TEST_CASE("brep bytes: a reading and an error come back as they were") {
  const auto back = from_bytes(to_bytes(triangle()));
  REQUIRE(back);
  REQUIRE(back->ok());
  CHECK((*back)->evaluation.mesh.vertices == triangle().evaluation.mesh.vertices);
  CHECK((*back)->evaluation.complaints == triangle().evaluation.complaints);
  CHECK((*back)->body == "body");
  const auto error = from_bytes(to_bytes(Error{"late", ErrorKind::stopped}));
  REQUIRE(error);
  CHECK(error->error().kind == ErrorKind::stopped);
  CHECK(error->error().message == "late");
}

TEST_CASE("brep bytes: what is cut off, points nowhere or is no value is nothing") {
  const std::string good = to_bytes(triangle());
  for (std::size_t size = 0; size < good.size(); ++size) CHECK_FALSE(from_bytes(good.substr(0, size)));
  BrepReading corner = triangle();
  corner.evaluation.mesh.triangles[0][2] = 3;
  CHECK_FALSE(from_bytes(to_bytes(corner)));
  BrepReading nowhere = triangle();
  nowhere.evaluation.mesh.vertices[1].x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(from_bytes(to_bytes(nowhere)));
  CHECK_FALSE(from_bytes(to_bytes(Error{"", static_cast<ErrorKind>(77)})));
  std::string flag = good;
  flag[flag.find('\n') + 1] = 2;
  CHECK_FALSE(from_bytes(flag));
}
