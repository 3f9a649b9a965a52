/// The constructor functions that Alpha_1 brings along.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "verify/scl/scl_value.h"

namespace partscribe::verify {

/// What natives may change besides giving a value.
struct SclOutputs {
  std::vector<SclGeometryPtr> dumped;  ///< by the last dumpGeomFile, dumpA1File or saveModel
  std::vector<SclGeometryPtr> shown;   ///< by the last show
  bool has_dump = false, has_show = false;
  std::map<SclGeometryPtr, std::map<std::string, SclValue>> attributes;
};

struct SclCallContext {
  SclOutputs& outputs;
  const SclStop& stop;
};

/// Is there a function of this name (in lower case)?
bool is_scl_native(const std::string& name);
/// Why a name of the Alpha_1 manual is not available; empty for other names.
std::string why_not_native(const std::string& name);
Result<SclValue> call_scl_native(const std::string& name, const std::vector<SclValue>& arguments,
                                 SclCallContext& context);
/// Linear ... Quintic, Origin, Xaxis, Yaxis, Zaxis, unitSphere; nothing for other names.
std::optional<SclValue> scl_predefined(const std::string& name);

}  // namespace partscribe::verify
