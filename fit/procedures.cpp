#include "fit/procedures.h"

#include <algorithm>
#include <array>

#include "fit/candidate.h"

namespace partscribe {
namespace {

/// Where they differ from the words.
constexpr std::array full_names = {"frustum of a cone", "convex polyhedron", "extrusion", "surface of revolution"};

}  // namespace

const std::vector<std::string>& procedure_words() {
  static const std::vector<std::string> words = {"sphere",     "box",         "cylinder",       "cone",        "torus",
                                                 "wedge",      "fillet",      "ellipsoid",      "revolve",     "extrude",
                                                 "half_spaces", "supertoroid", "superellipsoid", only_a_mesh};
  return words;
}

bool is_procedure(const std::string& name) {
  return std::ranges::find(procedure_words(), name) != procedure_words().end() || std::ranges::find(full_names, name) != full_names.end();
}

bool asked_for(const std::string& name, const Candidate& candidate) {
  return name.empty() || name == candidate.procedure || name == kind_of(candidate.shape);
}

}  // namespace partscribe
