/// The procedures that a part can be described by, and the words by which one of them is asked for.
#pragma once

#include <string>
#include <vector>

namespace partscribe::fit {

struct Candidate;

/// Asked for by this name a triangulation needs no search: it is what is left where nothing was found.
inline constexpr const char* only_a_mesh = "triangulation";
/// The same of B-spline surfaces.
inline constexpr const char* only_free_form = "free_form";

/// One word each, as BuildOptions::force takes it: mostly the kind of the shape. The plainest first.
const std::vector<std::string>& procedure_words();

/// Whether something can be asked for by this name: one of the words, or what a procedure is called in full ("surface
/// of revolution").
bool is_procedure(const std::string& name);

/// The word for a procedure that may be named in full.
std::string procedure_word(const std::string& name);

/// Whether the candidate is what was asked for; an empty name asks for the best of all.
bool asked_for(const std::string& name, const Candidate& candidate);

}  // namespace partscribe::fit
