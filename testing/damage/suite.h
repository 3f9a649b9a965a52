/// Runs damages of a part through a backend and the verifier, and counts what was refused and what was named right.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/files.h"
#include "geometry/points/point_cloud.h"
#include "verify/mutate/mutate.h"
#include "verify/verify.h"

namespace partscribe::testing {

using namespace verify;

/// One file to be judged, and then what was found.
struct DamageCase {
  std::string part, backend;  ///< a backend's name, or "mesh"
  std::string kind, damage;   ///< row of the table; "radius + 0.2"
  bool harmless = false;
  bool whole = false;             ///< place, hand or size of the part
  double moved = 0;               ///< mm
  std::vector<std::string> says;  ///< lower case; one must stand in the reasons or findings; none: `harm` decides
  Harm harm;
  Path file;
  double seconds = 600;

  std::string outcome;          ///< "verified", "out_of_tolerance", ..., or "error"
  std::string words;            ///< reasons and findings, one a line
  std::string feature;          ///< of the worst finding
  bool kept = false;            ///< verified
  bool named = false;           ///< the right feature, or the right fault of the file
  bool not_applicable = false;  ///< this backend cannot write it, or it changes nothing
};

struct SuiteOptions {
  std::size_t most = 2;  ///< damages of a kind, per part and backend
  bool in_turn = false;  ///< each damage of a model through one backend only, which change in turn
  std::size_t turn = 0;  ///< the backend to begin with
  std::vector<std::string> backends = {"openscad", "alpha1", "iges", "step", "mesh"};
  std::vector<std::string> kinds;  ///< rows of the table to try; empty: all
  bool models = true, files = true;
  int threads = 2;
};

/// All cases of a part, judged. The undamaged file comes first for each backend, as harmless.
std::vector<DamageCase> damage_part(const std::string& part, const SuiteOptions& options);

/// A row per kind and a column per backend: refused / named right / tried, and a row of what is harmless.
std::string markdown_table(const std::vector<DamageCase>& cases);

/// Places where either mesh is farther than `beyond` from the other.
Harm harm_between(const TriangleMesh& truth, const TriangleMesh& damaged, double beyond);

/// One line for a log: part, backend, kind, damage, outcome, feature, words.
std::string line_of(const DamageCase& c);

}  // namespace partscribe::testing
