// Distances from points to meshes and to trimmed surfaces, beside the peers:
//   bench_distances [--meshes|--breps] [--largest=TRIANGLES] [--repetitions=N] [--queries=N] [--refereed=N] [MESH...]
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "core/files.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/triangle_mesh.h"

namespace bench {
void meshes(const std::vector<std::pair<std::string, partscribe::geometry::TriangleMesh>>& given, int repetitions,
            std::size_t largest);
void breps(std::size_t count, std::size_t refereed);
}  // namespace bench

int main(int argc, char** argv) {
  std::size_t largest = 1000000, queries = 20000, refereed = 1000;
  int repetitions = 5;
  bool meshes = true, breps = true;
  std::vector<std::pair<std::string, partscribe::geometry::TriangleMesh>> given;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    auto number = [&](const char* name, auto& value) {
      const std::string prefix = std::string(name) + "=";
      if (word.rfind(prefix, 0) != 0) return false;
      value = static_cast<std::decay_t<decltype(value)>>(std::stoul(word.substr(prefix.size())));
      return true;
    };
    if (word == "--meshes")
      breps = false;
    else if (word == "--breps")
      meshes = false;
    else if (number("--largest", largest) || number("--repetitions", repetitions) || number("--queries", queries) ||
             number("--refereed", refereed))
      continue;
    else {
      partscribe::core::Context context;
      auto read = partscribe::geometry::read_geometry(word, context);
      if (!read.ok()) {
        std::fprintf(stderr, "%s\n", read.error().message.c_str());
        return 2;
      }
      given.emplace_back(word, std::move(read.value().mesh));
    }
  }
  if (meshes) bench::meshes(given, repetitions, largest);
  if (breps) bench::breps(queries, refereed);
}
