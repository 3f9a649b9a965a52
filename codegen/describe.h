/// What a script's comments say about a model: how good it is, where its numbers come from.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codegen/template.h"
#include "model/model.h"

namespace partscribe::codegen {

/// "4,120".
std::string with_thousands(std::size_t count);

/// A text that is safe inside a line comment: one line, no control characters.
std::string one_line(const std::string& text);

/// "tie bar" -> "Tie bar", "tie_bar" -> "Tie bar".
std::string as_title(const std::string& name);

/// Lines on top of a script: what the part is, units, tolerance, quality of the fit, sources, program.
std::vector<std::string> header_lines(const Model& model);

/// "rms 0.042 mm from 4,120 points, local mean within 0.034 mm, 87 % of its surface scanned"; empty without evidence.
std::string describe_evidence(const Evidence& evidence);

/// "fitted 8.9987 +/- 0.0004 from 4,120 points; nominal 9 (0.5 mm grid, z = 3.2)"; empty if the value was not fitted.
std::string describe_fit(const Parameter& parameter, double tolerance);

/// "mm", "deg" or nothing.
std::string unit_of(Quantity quantity);

/// The printed text of a parameter's value: millimetres, degrees, or a plain number.
std::string value_text(Quantity quantity, double value);

/// The as-built text of a parameter that differs from its value by more than printing shows; nothing otherwise.
std::optional<std::string> as_built_text(const Parameter& parameter, double tolerance);

/// Parameters in groups for a person: after the first object that uses them, in order of presentation.
struct ParameterGroup {
  std::string title;
  std::vector<const Parameter*> parameters;
};
std::vector<ParameterGroup> grouped_parameters(const Model& model);

/// One row per parameter of the group: its meaning with the unit, its statement, what the fit said; statements that are
/// followed by the latter are padded to one width.
TemplateList parameter_rows(const ParameterGroup& group, const std::vector<std::string>& statements, double tolerance);

}  // namespace partscribe::codegen
