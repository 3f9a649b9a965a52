/// model.json: the model as a file that others may read and write (schema: docs/model.schema.json).
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"
#include "model/model.h"

namespace partscribe::model {

inline constexpr int model_format = 1;

/// Byte-stable text, two-space indentation, numbers by print_number, a final newline.
std::string write_model_json(const Model& model);

/// Reads any format up to the present one. Errors name `where` and the path inside the document.
Result<Model> read_model_json(std::string_view text, const std::string& where);

}  // namespace partscribe::model
