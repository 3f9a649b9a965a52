/// The doors through which a stranger's bytes come in, as functions that fuzzers and a test call.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace partscribe::testing {

/// Whatever the bytes are, each of these ends soon, within little memory and without a fault; what was read is sound.
/// A broken promise ends the program.
void fuzz_ply(std::string_view bytes);
void fuzz_stl(std::string_view bytes);
void fuzz_obj(std::string_view bytes);
void fuzz_off(std::string_view bytes);
void fuzz_3mf(std::string_view bytes);
void fuzz_3mf_xml(std::string_view bytes);  ///< the model part alone, which is then packed as 3MF has it
void fuzz_pcd(std::string_view bytes);
void fuzz_xyz(std::string_view bytes);
void fuzz_vtk(std::string_view bytes);
void fuzz_range(std::string_view bytes);      ///< PNG, PGM or NPY
void fuzz_scan(std::string_view bytes);       ///< a bundle (bundle.h): scan.json, .conf or a mesh, and what it names
void fuzz_fiducials(std::string_view bytes);  ///< reference points of views
void fuzz_model(std::string_view bytes);      ///< model.json: read, checked, measured
void fuzz_emit(std::string_view bytes);       ///< model.json: written as scripts
void fuzz_template(std::string_view bytes);
void fuzz_scl(std::string_view bytes);       ///< a bundle: a procedure and what it includes, executed
void fuzz_scl_mesh(std::string_view bytes);  ///< and the triangles of what it makes
void fuzz_step(std::string_view bytes);
void fuzz_iges(std::string_view bytes);
void fuzz_brep(std::string_view bytes);  ///< what the reader of STEP and IGES hands back
void fuzz_verdict(std::string_view bytes);
void fuzz_words(std::string_view bytes);  ///< a command line, a word a line
void fuzz_mcp(std::string_view bytes);    ///< messages of an agent, one a line

/// A function above by its name without "fuzz_".
struct FuzzEntry {
  std::string name;
  void (*run)(std::string_view bytes);
};
const std::vector<FuzzEntry>& fuzz_entries();

}  // namespace partscribe::testing
