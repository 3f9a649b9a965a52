#include "cli/verdict_file.h"

#include <nlohmann/json.hpp>

#include "core/json_nesting.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::json;

Outcome outcome_of(const Json& json, const char* key) {
  const std::string name = json.at(key).get<std::string>();
  for (const auto outcome : {Outcome::verified, Outcome::out_of_tolerance, Outcome::cannot_decide, Outcome::not_run})
    if (name == name_of(outcome)) return outcome;
  throw std::runtime_error("expected a verdict at \"" + std::string(key) + "\", found \"" + name + "\"");
}

/// Absent and null numbers are 0: an artifact that was not run has none.
double number(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : 0.0;
}

std::size_t count(const Json& json, const char* key) {
  return static_cast<std::size_t>(std::max(0.0, number(json, key)));
}

std::string text(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Vec3 vector(const Json& json, const char* key) {
  const auto found = json.find(key);
  Vec3 v = Vec3::Zero();
  if (found != json.end() && found->is_array() && found->size() == 3)
    for (std::size_t k = 0; k < 3; ++k)
      if ((*found)[k].is_number()) v[static_cast<Eigen::Index>(k)] = (*found)[k].get<double>();
  return v;
}

Quantity quantity_of(const std::string& name) {
  if (name == "angle") return Quantity::angle;
  if (name == "count") return Quantity::count;
  return name == "ratio" ? Quantity::ratio : Quantity::length;
}

FeatureVerdict feature_of(const Json& json) {
  FeatureVerdict feature;
  feature.name = text(json, "name");
  feature.kind = text(json, "kind");
  feature.points = count(json, "points");
  feature.rms = number(json, "rms"), feature.max = number(json, "max"), feature.covered = number(json, "covered");
  feature.verdict = outcome_of(json, "verdict");
  if (const auto found = json.find("dimensions"); found != json.end() && found->is_array())
    for (const auto& d : *found)
      feature.dimensions.push_back({text(d, "name"), quantity_of(text(d, "quantity")), number(d, "nominal"),
                                    number(d, "measured"), number(d, "sigma"), number(d, "deviation"),
                                    d.value("within", true)});
  return feature;
}

Finding finding_of(const Json& json) {
  Finding finding;
  const std::string kind = text(json, "kind");
  bool known = false;
  for (const auto k : {Finding::Kind::displaced, Finding::Kind::missing_material, Finding::Kind::invented_material,
                       Finding::Kind::not_scanned, Finding::Kind::rejected})
    if (kind == name_of(k)) finding.kind = k, known = true;
  if (!known) throw std::runtime_error("expected the kind of a finding at \"kind\", found \"" + kind + "\"");
  finding.feature = text(json, "feature");
  finding.place = vector(json, "place"), finding.direction = vector(json, "direction");
  finding.deviation = number(json, "deviation"), finding.area = number(json, "area");
  finding.extent = number(json, "extent"), finding.points = count(json, "points");
  finding.reason = text(json, "reason"), finding.text = text(json, "text");
  return finding;
}

ArtifactVerdict artifact_of(const Json& json) {
  ArtifactVerdict artifact;
  artifact.file = text(json, "file");
  artifact.backend = text(json, "backend");
  artifact.program = text(json, "program");
  artifact.version = text(json, "version");
  artifact.verdict = outcome_of(json, "verdict");
  artifact.seconds = number(json, "seconds");
  artifact.evaluation_error = number(json, "evaluation_error");
  if (const auto found = json.find("alignment"); found != json.end() && found->is_object()) {
    auto& alignment = artifact.alignment.emplace();
    alignment.method = text(*found, "method") == "datums" ? AlignBy::datums : AlignBy::best_fit;
    alignment.rotation = radians(number(*found, "rotation_degrees"));
    alignment.rms = number(*found, "rms"), alignment.points = count(*found, "points"),
    alignment.remark = text(*found, "remark");
    for (int k = 0; k < 3; ++k) alignment.translation[k] = found->at("translation").at(std::size_t(k)).get<double>();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) {
        const double v = found->at("scan_to_artifact").at(std::size_t(r)).at(std::size_t(c)).get<double>();
        (c < 3 ? alignment.scan_to_artifact.rotation(r, c) : alignment.scan_to_artifact.translation[r]) = v;
      }
  }
  if (const auto found = json.find("data_to_model"); found != json.end() && found->is_object()) {
    auto& d = artifact.data_to_model;
    d.points = count(*found, "points"), d.rejected = count(*found, "rejected");
    d.set_aside = count(*found, "set_aside");
    d.local_max = number(*found, "local_max"), d.rms = number(*found, "rms"), d.p50 = number(*found, "p50");
    d.p95 = number(*found, "p95"), d.p99 = number(*found, "p99"), d.max = number(*found, "max");
    d.worst = vector(*found, "worst");
  }
  if (const auto found = json.find("model_to_data"); found != json.end() && found->is_object()) {
    auto& m = artifact.model_to_data;
    m.area = number(*found, "area"), m.supported = number(*found, "supported");
    m.not_scanned = number(*found, "not_scanned"), m.contradicted = number(*found, "contradicted");
  }
  if (const auto found = json.find("objects"); found != json.end() && found->is_array())
    for (const auto& row : *found) artifact.objects.push_back(feature_of(row));
  if (const auto found = json.find("findings"); found != json.end() && found->is_array())
    for (const auto& finding : *found) artifact.findings.push_back(finding_of(finding));
  if (const auto found = json.find("second_opinions"); found != json.end() && found->is_array())
    for (const auto& o : *found)
      artifact.second_opinions.push_back({text(o, "program"), text(o, "version"), o.value("delivered", false),
                                          o.value("agrees", false), o.value("exact_circles", false),
                                          number(o, "distance"), text(o, "note")});
  if (const auto found = json.find("reasons"); found != json.end() && found->is_array())
    for (const auto& reason : *found) artifact.reasons.push_back(reason.get<std::string>());
  return artifact;
}

}  // namespace

Result<Verdict> read_verdict_json(const std::string& bytes, const std::string& where) {
  try {
    if (nested_too_deeply(bytes)) throw std::runtime_error("the document is nested too deeply");
    const Json json = Json::parse(bytes);
    Verdict verdict;
    verdict.verdict = outcome_of(json, "verdict");
    verdict.tolerance = number(json, "tolerance");
    verdict.smallest_honest_tolerance = number(json, "smallest_honest_tolerance");
    verdict.noise = number(json, "noise");
    if (!(verdict.tolerance > 0)) throw std::runtime_error("expected a tolerance above 0");
    for (const auto& artifact : json.at("artifacts")) verdict.artifacts.push_back(artifact_of(artifact));
    if (const auto found = json.find("between_backends"); found != json.end() && found->is_array())
      for (const auto& pair : *found)
        verdict.between_backends.push_back(
            {text(pair, "first"), text(pair, "second"), number(pair, "distance"), pair.value("agree", true)});
    return verdict;
  } catch (const std::exception& error) {
    return bad_input(where + ": expected a verdict as 'partscribe verify' writes it: " + error.what());
  }
}

}  // namespace partscribe::cli
