#include "cli/mcp/findings.h"

#include <nlohmann/json.hpp>

#include "core/number.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;

Json place_json(const Vec3& v) { return {snapped(v.x(), 1e-4), snapped(v.y(), 1e-4), snapped(v.z(), 1e-4)}; }

/// What the scan says of the numbers of a feature, those alone that are off.
Json dimensions_off(const ArtifactVerdict& artifact, const std::string& feature) {
  Json list = Json::array();
  for (const auto& row : artifact.objects) {
    if (row.name != feature) continue;
    for (const auto& d : row.dimensions) {
      if (d.within) continue;
      const bool angle = d.quantity == Quantity::angle;
      const auto shown = [&](double value) { return snapped(angle ? value * 180 / pi : value, 1e-4); };
      list.push_back({{"name", d.name},
                      {"unit", angle ? "degrees" : "mm"},
                      {"artifact_says", shown(d.nominal)},
                      {"scan_measures", shown(d.measured)},
                      {"sigma", shown(d.sigma)}});
    }
  }
  return list;
}

}  // namespace

Json tasks_of(const Verdict& verdict) {
  Json tasks = Json::array();
  for (const auto& artifact : verdict.artifacts) {
    if (artifact.verdict == Outcome::verified) continue;
    const std::size_t before = tasks.size();
    for (const auto& finding : artifact.findings) {
      if (finding.kind == Finding::Kind::not_scanned) continue;
      tasks.push_back({{"artifact", artifact.file},
                       {"feature", finding.feature},
                       {"kind", name_of(finding.kind)},
                       {"text", finding.text},
                       {"place", place_json(finding.place)},
                       {"direction", place_json(finding.direction)},
                       {"deviation", snapped(finding.deviation, 1e-4)},
                       {"dimensions", dimensions_off(artifact, finding.feature)}});
    }
    if (tasks.size() > before) continue;
    for (const auto& reason : artifact.reasons) tasks.push_back({{"artifact", artifact.file}, {"text", reason}});
  }
  return tasks;
}

}  // namespace partscribe::cli
