#include "fit/procedures.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "fit/candidate.h"

namespace partscribe::fit {
namespace {

/// What a procedure is called in full, where that differs from its word.
struct FullName {
  std::string_view name, word;
};
constexpr std::array full_names = {
    FullName{"frustum of a cone", "cone"},        FullName{"frustum", "cone"},
    FullName{"convex polyhedron", "half_spaces"}, FullName{"extrusion", "extrude"},
    FullName{"surface of revolution", "revolve"}, FullName{"body with holes", "drilled"},
    FullName{"free form", only_free_form},        FullName{"body with free-form faces", "sculpted"}};

}  // namespace

const std::vector<std::string>& procedure_words() {
  static const std::vector<std::string> words = {
      "sphere",   "box",         "cylinder",       "cone",         "torus",       "wedge",
      "fillet",   "ellipsoid",   "revolve",        "extrude",      "half_spaces", "drilled",
      "sculpted", "supertoroid", "superellipsoid", only_free_form, only_a_mesh};
  return words;
}

bool is_procedure(const std::string& name) {
  return std::ranges::find(procedure_words(), procedure_word(name)) != procedure_words().end();
}

std::string procedure_word(const std::string& name) {
  const auto full = std::ranges::find(full_names, name, &FullName::name);
  return full == full_names.end() ? name : std::string(full->word);
}

bool asked_for(const std::string& name, const Candidate& candidate) {
  return name.empty() || name == candidate.procedure || name == procedure_word(candidate.procedure) ||
         name == kind_of(candidate.shape);
}

}  // namespace partscribe::fit
