// Points and meshes.
#include <algorithm>

#include "core/ensure.h"
#include "geometry/io/read_geometry.h"
#include "testing/fuzz/entries.h"
#include "testing/zip.h"

namespace partscribe::testing {

using namespace geometry;

namespace {

/// What every reader promises of what it read.
void check_sound(const RawGeometry& raw) {
  ensure(!raw.cloud.empty(), "what was read has points");
  const std::size_t size = raw.cloud.size();
  for (const auto& p : raw.cloud.points) ensure(p.allFinite(), "places are finite");
  for (const auto& t : raw.mesh.triangles)
    for (const auto corner : t) ensure(corner < raw.mesh.vertices.size(), "corners exist");
  for (const auto& n : raw.cloud.normals) ensure(n.allFinite(), "directions are finite");
  for (const auto column :
       {raw.cloud.normals.size(), raw.cloud.rays.size(), raw.cloud.pixel.size(), raw.cloud.sigma.size()})
    ensure(column == 0 || column == size, "every point has its place in a column");
}

void read_as(const char* name, std::string_view bytes) {
  const auto raw = parse_geometry(bytes, name);
  if (raw.ok())
    check_sound(*raw);
  else
    ensure(raw.error().message.find('\n') == std::string::npos, "an error is one line");
}

}  // namespace

void fuzz_ply(std::string_view bytes) { read_as("a.ply", bytes); }
void fuzz_stl(std::string_view bytes) { read_as("a.stl", bytes); }
void fuzz_obj(std::string_view bytes) { read_as("a.obj", bytes); }
void fuzz_off(std::string_view bytes) { read_as("a.off", bytes); }
void fuzz_3mf(std::string_view bytes) { read_as("a.3mf", bytes); }
void fuzz_pcd(std::string_view bytes) { read_as("a.pcd", bytes); }
void fuzz_xyz(std::string_view bytes) { read_as("a.xyz", bytes); }
void fuzz_vtk(std::string_view bytes) { read_as("a.vtk", bytes); }
void fuzz_3mf_xml(std::string_view bytes) { read_as("a.3mf", zip({{"3D/3dmodel.model", std::string(bytes)}}, false)); }

}  // namespace partscribe::testing
