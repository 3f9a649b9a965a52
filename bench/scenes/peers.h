/// The same question to all: which planes, cylinders, cones, spheres and tori does this scan show?
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/faces/truth.h"
#include "geometry/points/point_cloud.h"

namespace bench {

struct Question {
  PointCloud cloud;    ///< without normals and without rays
  double sigma = 0;    ///< mm, of the noise; told to all but ourselves
  double spacing = 0;  ///< mm, median distance to the nearest neighbour; told to all but ourselves
  std::uint64_t seed = 1;
};

struct FoundShape {
  FaceKind kind = FaceKind::plane;
  std::optional<Primitive> surface;  ///< where it is told
  std::vector<std::uint32_t> points;
};

struct Answer {
  std::vector<FoundShape> shapes;
  double normals = 0, seconds = 0;  ///< of processor time; `seconds`: without normals
};

struct Contestant {
  std::string name, setting;
  int runs = 1;                                                            ///< more of those that draw by chance
  std::function<std::optional<Answer>(const Question&, Context&)> answer;  ///< nothing: not installed
};

double processor_seconds();

Contestant ours();
std::vector<Contestant> cgal();          ///< Efficient RANSAC and region growing, some settings of each
std::vector<Contestant> cloudcompare();  ///< by its command line

}  // namespace bench
