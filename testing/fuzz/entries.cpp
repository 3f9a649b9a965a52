#include "testing/fuzz/entries.h"

namespace partscribe::testing {

const std::vector<FuzzEntry>& fuzz_entries() {
  static const std::vector<FuzzEntry> entries = {
      {"ply", fuzz_ply},     {"stl", fuzz_stl},         {"obj", fuzz_obj},           {"off", fuzz_off},
      {"3mf", fuzz_3mf},     {"3mf_xml", fuzz_3mf_xml}, {"pcd", fuzz_pcd},           {"xyz", fuzz_xyz},
      {"vtk", fuzz_vtk},     {"range", fuzz_range},     {"scan", fuzz_scan},         {"fiducials", fuzz_fiducials},
      {"model", fuzz_model}, {"emit", fuzz_emit},       {"template", fuzz_template}, {"scl", fuzz_scl},
      {"step", fuzz_step},   {"iges", fuzz_iges},       {"brep", fuzz_brep},         {"verdict", fuzz_verdict},
      {"words", fuzz_words}, {"mcp", fuzz_mcp},         {"scl_mesh", fuzz_scl_mesh}};
  return entries;
}

}  // namespace partscribe::testing
