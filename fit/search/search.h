/// The search for a procedure: proposals are judged, compared, and the best is made fit for print.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fit/build.h"
#include "fit/candidate.h"
#include "fit/evidence/coverage.h"
#include "fit/evidence/evidence.h"
#include "fit/procedures.h"
#include "fit/propose/superellipsoid.h"
#include "geometry/segment/faces.h"
#include "model/model.h"

namespace partscribe::fit {

/// A candidate after a first refinement, with what speaks for and against it.
struct Judged {
  Candidate candidate;
  CandidateEvidence evidence;
  Coverage coverage;
  bool meets = false;
  /// within tolerance, but refused because essential parts of it were not seen or are hidden by noise
  bool open = false;
  bool refused = false;  ///< by what was asked after the fit
  std::string reason;
};

/// What the makers proposed, what became of it, and the best as a model, if one meets the tolerance.
struct ProcedureSearch {
  SuperellipsoidFit hypothesis;
  std::shared_ptr<const Faces> faces;  ///< of the scan, once a maker asked for them
  std::vector<Judged> judged;          ///< the best first
  bool found = false;                  ///< the first of `judged`, as `model`
  Model model;
  CandidateEvidence evidence;  ///< of the winner as it will be printed
  double covered = 0;
};

/// Asks the makers and chooses: procedures of the trade first; superellipsoid and supertoroid, which serve as a last
/// resort, where `last_resort` asks for them. Asked again it goes on from what is known.
void search_procedure(ProcedureSearch& search, bool last_resort, const FitInput& input, const BuildOptions& options,
                      Context& context);

/// Removes the winner for a reason found after the fit, and chooses among the others.
void choose_another(ProcedureSearch& search, const std::string& reason, const FitInput& input,
                    const BuildOptions& options, Context& context);

/// True if the winner follows the data less closely than noise allows: a body with rounded corners, or a ring with
/// such, may fit better.
bool is_rough(const ProcedureSearch& search);

/// Why a rival is not the model. One that was refused for what was not seen may still be the truth.
std::string reason_of(const Judged& winner, const Judged& rival, const FitInput& input, Context& context);

}  // namespace partscribe::fit
