/// Damages of the emitted file itself, in its text or its facets; and edits of it that change nothing.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"
#include "model/model.h"

namespace partscribe::testing {

using namespace model;

/// The file of one backend before it is damaged.
struct FileSubject {
  std::string backend;  ///< a backend's name, or "mesh" for a .stl
  std::string suffix;   ///< ".scad"
  std::string bytes;
  const Model& model;
  const TriangleMesh& mesh;                        ///< of the part, placed, closed unless the part is a sheet
  std::function<std::string(const Model&)> write;  ///< the file of another model by the same backend
  std::string other_format;                        ///< the part as another backend writes it
  double extent = 0;                               ///< mm, diagonal of the part
};

struct FileDamage {
  std::string kind;  ///< "truncated file": a row of the table
  std::string name;  ///< "at 50 %"
  std::string bytes;
  std::vector<std::string> says;  ///< one of these must stand in the reasons or findings; none: the place decides
  bool harmless = false;
  double seconds = 600;             ///< time limit to run it with
  bool without_companions = false;  ///< the files beside it are missing
};

/// All that this file allows, in a fixed order.
std::vector<FileDamage> file_damages(const FileSubject& subject);

// ---- what the three parts share -------------------------------------------------------------------------------------

void damage_scripts(const FileSubject& subject, std::vector<FileDamage>& damages);   ///< .scad and .scl
void damage_exchange(const FileSubject& subject, std::vector<FileDamage>& damages);  ///< .step and .igs
void damage_facets(const FileSubject& subject, std::vector<FileDamage>& damages);    ///< .stl

/// `text` with the first `from` replaced; empty if there is none.
std::string with(const std::string& text, const std::string& from, const std::string& to);
std::string with_all(std::string text, const std::string& from, const std::string& to);
std::vector<std::string> lines_of(const std::string& text);
std::string text_of(const std::vector<std::string>& lines, const std::string& end = "\n");

}  // namespace partscribe::testing
