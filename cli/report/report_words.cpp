#include "cli/report/report_words.h"

#include <algorithm>

#include "cli/describe.h"
#include "cli/report/report_html.h"
#include "core/number.h"

namespace partscribe::cli {

std::string title_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::verified:
      return "Verified";
    case Outcome::out_of_tolerance:
      return "Out of tolerance";
    case Outcome::cannot_decide:
      return "Cannot decide";
    case Outcome::not_run:
      return "Not run";
  }
  return "Not run";
}

std::string title_of(Finding::Kind kind) {
  switch (kind) {
    case Finding::Kind::displaced:
      return "Displaced";
    case Finding::Kind::missing_material:
      return "Missing material";
    case Finding::Kind::invented_material:
      return "Invented material";
    case Finding::Kind::not_scanned:
      return "Not scanned";
    case Finding::Kind::rejected:
      return "Points set aside";
  }
  return "Finding";
}

const ArtifactVerdict* deciding_artifact(const Verdict& verdict) {
  const ArtifactVerdict* decides = nullptr;
  for (const auto& artifact : verdict.artifacts)
    if (artifact.verdict == verdict.verdict &&
        (!decides || artifact.data_to_model.local_max > decides->data_to_model.local_max))
      decides = &artifact;
  return decides || verdict.artifacts.empty() ? decides : &verdict.artifacts.front();
}

std::string spoken(const std::string& name) {
  std::string words = name;
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

namespace {

/// The first reason of an artifact, without a full stop; empty if it has none.
std::string first_reason(const ArtifactVerdict* artifact) {
  if (!artifact || artifact->reasons.empty()) return {};
  std::string reason = artifact->reasons.front();
  while (reason.ends_with('.')) reason.pop_back();
  return reason;
}

}  // namespace

std::string verdict_sentence(const Verdict& verdict) {
  const std::string tolerance = print_number(verdict.tolerance) + " mm";
  const ArtifactVerdict* artifact = deciding_artifact(verdict);
  const double worst = artifact ? artifact->data_to_model.local_max : 0;
  switch (verdict.verdict) {
    case Outcome::verified:
      return "The CAD model is the scanned part: wherever the part was scanned, the two agree within " +
             readable(worst) + " mm, and " + tolerance + " is allowed.";
    case Outcome::out_of_tolerance: {
      const std::string text = "The CAD model is not the scanned part", reason = first_reason(artifact);
      if (artifact && artifact->mesh.empty() && artifact->model_to_data.area == 0 && !reason.empty())
        return "No part came out of " + artifact->file + ": " + reason + ".";
      const Finding* fault = nullptr;
      if (artifact)
        for (const auto& f : artifact->findings)
          if (f.kind != Finding::Kind::not_scanned && !f.text.empty() && !fault) fault = &f;
      if (fault)
        return text + ": somewhere they differ by more than the " + tolerance +
               " allowed. The worst place: " + fault->text + ".";
      if (artifact && artifact->data_to_model.local_max > verdict.tolerance)
        return text + ": they differ by up to " + readable(artifact->data_to_model.local_max) + " mm, and " +
               tolerance + " is allowed.";
      if (!reason.empty()) return text + ": " + reason + ".";
      for (const auto& pair : verdict.between_backends)
        if (!pair.agree)
          return "The files do not describe the same part: " + pair.first + " and " + pair.second + " differ by " +
                 readable(pair.distance) + " mm.";
      return text + " within " + tolerance + ".";
    }
    case Outcome::cannot_decide:
      if (verdict.tolerance >= verdict.smallest_honest_tolerance && !first_reason(artifact).empty())
        return "Neither agreement nor disagreement within " + tolerance + " could be shown: " + first_reason(artifact) +
               ".";
      return "This scan cannot decide within " + tolerance +
             ": its noise would hide such a deviation. It can decide from " +
             readable(verdict.smallest_honest_tolerance) + " mm upward.";
    case Outcome::not_run:
      break;
  }
  return "Nothing is known yet: a program that is needed to look at the file is missing" +
         (first_reason(artifact).empty() ? "." : " (" + first_reason(artifact) + ").");
}

std::string honesty_sentences(const Verdict& verdict) {
  const double honest = verdict.smallest_honest_tolerance;
  std::string text = "The scanned points scatter by " + readable(verdict.noise) +
                     " mm (one standard deviation) around the surface they were taken from. Deviations below " +
                     readable(honest) + " mm drown in that scatter even after averaging over neighbouring points, so " +
                     readable(honest) + " mm is the smallest tolerance about which this scan can honestly answer. ";
  if (!(honest > 0)) return text + "No scatter was found, so every tolerance can be answered.";
  if (verdict.tolerance < honest)
    return text + "The tolerance asked for, " + print_number(verdict.tolerance) +
           " mm, is smaller: the answer is \"cannot decide\".";
  return text + "The tolerance asked for, " + print_number(verdict.tolerance) + " mm, is " +
         readable(verdict.tolerance / honest) + " times that.";
}

}  // namespace partscribe::cli
