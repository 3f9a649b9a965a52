// Point to mesh and point to B-rep distances beside the peers: bench_distances [meshes|breps] [MESH...].
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "geometry/read_geometry.h"
#include "geometry/triangle_mesh.h"

namespace bench {
void meshes(const std::vector<std::pair<std::string, partscribe::TriangleMesh>>& given, int repetitions, std::size_t largest);
}

int main(int argc, char** argv) {
  std::size_t largest = 1000000;
  int repetitions = 5;
  std::vector<std::pair<std::string, partscribe::TriangleMesh>> given;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--largest=", 0) == 0) largest = std::stoul(word.substr(10));
    if (word.rfind("--repetitions=", 0) == 0) repetitions = std::stoi(word.substr(14));
  }
  bench::meshes(given, repetitions, largest);
}
