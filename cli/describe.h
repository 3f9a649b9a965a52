/// A model in plain words: the procedure, the named dimensions with their uncertainty, the rivals.
#pragma once

#include <string>
#include <vector>

#include "model/model.h"

namespace partscribe::cli {

/// "a surface of revolution", "4 steps: ...", "a triangulation of 724 triangles, because no procedure met 0.1 mm".
std::string procedure_text(const Model& model);

/// "Found: a box." and, of a triangulation that is the fallback, what came near: a line each.
std::string found_lines(const Model& model);

/// One parameter as a person reads it; lengths in mm, angles in degrees.
struct Dimension {
  std::string name, value, unit;
  std::string fitted;   ///< "10.997 ± 0.004", empty if it was not fitted
  std::string nominal;  ///< "11 on the 0.5 mm grid, 0.8 sigma away: kept"; empty if none was looked for
  std::string points;   ///< "4120", empty if unknown
  std::string note;
};
Dimension describe(const Parameter& parameter);

/// Length or ratio with its standard deviation: both rounded to the second digit of the deviation.
std::string with_sigma(double value, double sigma);

/// A number for reading: three significant digits at most below 1000.
std::string readable(double value);

/// A table with aligned columns; the first row is the heading.
std::string table(const std::vector<std::vector<std::string>>& rows, const std::string& indent = "  ");

/// The named dimensions as a table; empty text if the model has none.
std::string dimension_table(const Model& model);

/// What was considered instead and why it lost, one line each.
std::vector<std::string> rival_lines(const Model& model);

/// The widest tolerance that is of any use for a part of this size (the diagonal of the box around it), mm.
double useful_reach(double size);

/// Of a model that is a triangulation because nothing else met the tolerance: the plainest rival that came near. Null
/// if none lies within useful_reach().
const Rival* nearest_procedure(const Model& model);

/// The nearest procedure and how near it came, in one line; empty if there is none.
std::string nearest_procedure_line(const Model& model);

/// Of such a triangulation, the last line: "No CAD procedure was found: ..." and why. `asked`: the only procedure that
/// was allowed; may be empty. Empty if a procedure was found.
std::string no_procedure_line(const Model& model, const std::string& asked);

/// The superellipsoid that was recovered first, in one line; empty if the model has none.
std::string hypothesis_line(const Model& model);

/// What `explain` prints: every number with its evidence, the steps, the rivals.
std::string explanation(const Model& model);

}  // namespace partscribe::cli
