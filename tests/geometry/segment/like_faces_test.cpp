/// Claims about cylinders that are found since there are others like them.
#include "geometry/segment/like_faces.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "geometry/segment/faces.h"

using namespace partscribe::core;
using namespace partscribe::geometry;

namespace {

constexpr double radius = 2.5, noise = 0.03;

/// Adds `count` points of a hole's wall along z, 8 mm deep, over `arc` of its turn.
void add_wall(const Vec3& place, int count, double arc, Random& random, PointCloud& cloud) {
  for (int k = 0; k < count; ++k) {
    const double turn = random.uniform(0, arc);
    const Vec3 out(std::cos(turn), std::sin(turn), 0);
    cloud.points.push_back(place + (radius + noise * random.normal()) * out + random.uniform(0, 8) * Vec3::UnitZ());
    cloud.normals.push_back((-out + 0.15 * Vec3(random.normal(), random.normal(), random.normal())).normalized());
    cloud.sigma.push_back(float(noise));
  }
}

/// A hole that is known, about the origin.
std::vector<GrownFace> known() {
  GrownFace face;
  face.surface.kind = PrimitiveKind::cylinder, face.surface.radius = radius;
  face.surface.axis = Vec3::UnitZ(), face.surface.point = Vec3::Zero();
  face.sense = -1;
  return {face};
}

/// With the known hole, of which `arc` was seen.
std::vector<LikeFace> found_in(PointCloud cloud, double arc = 2 * pi) {
  Random random(5);
  std::vector<std::uint32_t> label(cloud.size(), no_face);
  add_wall(Vec3::Zero(), 200, arc, random, cloud);
  label.resize(cloud.size(), 0);
  return like_faces(cloud, std::vector<std::uint8_t>(cloud.size(), 0), label, known(), 0.01, 1.2);
}

}  // namespace

TEST_CASE("like faces: holes of forty points each are found where they are, whatever lies between them") {
  Random random(2);
  PointCloud cloud;
  add_wall({20, 0, 0}, 40, 2 * pi, random, cloud);
  add_wall({-20, 7, 0}, 40, 2 * pi, random, cloud);
  for (int k = 0; k < 300; ++k) {  // what mixed pixels leave behind
    cloud.points.emplace_back(random.uniform(-40, 40), random.uniform(-20, 20), random.uniform(0, 8));
    cloud.normals.push_back(Vec3(random.normal(), random.normal(), random.normal()).normalized());
    cloud.sigma.push_back(float(noise));
  }
  const auto found = found_in(cloud);
  REQUIRE(found.size() == 2);
  for (const Vec3& place : {Vec3(20, 0, 0), Vec3(-20, 7, 0)}) {
    double nearest = 1e9;
    for (const LikeFace& face : found) {
      Vec3 d = face.face.surface.point - place;
      nearest = std::min(nearest, d.head<2>().norm());
      CHECK(face.members.size() >= 35);
    }
    CHECK(nearest < 0.05);
  }
  // Of a round nobody knows whether it goes on to a hole.
  CHECK(found_in(cloud, pi / 2).empty());
}

TEST_CASE("like faces: a surface that passes by is none, however many of its points fit") {
  Random random(6);
  PointCloud funnel;  // its radius grows from less to more
  for (int k = 0; k < 3000; ++k) {
    const double turn = random.uniform(0, 2 * pi), height = random.uniform(0, 8);
    const Vec3 out(std::cos(turn), std::sin(turn), 0);
    funnel.points.push_back(Vec3(20, 0, 0) + (radius + 0.2 * (height - 4)) * out + height * Vec3::UnitZ());
    funnel.normals.push_back((-out + 0.2 * Vec3::UnitZ()).normalized());
    funnel.sigma.push_back(float(noise));
  }
  CHECK(found_in(funnel).empty());
}

TEST_CASE("like faces: too few points, half a turn, a round of another radius and a shaft are none") {
  Random random(4);
  PointCloud few, half, other, shaft;
  add_wall({20, 0, 0}, 15, 2 * pi, random, few);
  add_wall({20, 0, 0}, 80, pi, random, half);
  add_wall({20, 0, 0}, 80, 2 * pi, random, other);
  for (Vec3& p : other.points) p = Vec3(20, 0, 0) + Vec3(1.3, 1.3, 1).asDiagonal() * (p - Vec3(20, 0, 0));
  add_wall({20, 0, 0}, 80, 2 * pi, random, shaft);
  for (Vec3& n : shaft.normals) n = -n;
  for (const PointCloud* cloud : {&few, &half, &other, &shaft}) CHECK(found_in(*cloud).empty());
}
