/// The sentences of a report: what a customer who knows neither scanners nor CAD understands.
#pragma once

#include <string>

#include "model/model.h"
#include "verify/verify.h"

namespace partscribe::cli {

/// "Verified", "Out of tolerance", "Cannot decide", "Not run".
std::string title_of(Outcome outcome);

/// The verdict in one sentence.
std::string verdict_sentence(const Verdict& verdict);

/// What the smallest honest tolerance means for this scan, in two or three sentences.
std::string honesty_sentences(const Verdict& verdict);

/// A name as people write it: "d2_pin" is "d2 pin".
std::string spoken(const std::string& name);

/// "Displaced", "Missing material", ...
std::string title_of(Finding::Kind kind);

/// The artifact that decides: of those with the verdict of the whole the one that deviates most; null if there is none.
const ArtifactVerdict* deciding_artifact(const Verdict& verdict);

}  // namespace partscribe::cli
