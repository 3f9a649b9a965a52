/// Whether a STEP or IGES file is complete, checked before it is given to a reader that would not notice.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace partscribe::verify {

/// What is wrong with the text of a STEP file (ISO 10303-21), one line: it ends too early, refers to an entity that is
/// missing, refers to itself in a circle, defines an entity twice, holds a number that is none. Nothing if it is whole.
/// What the entities mean is left to the reader.
std::optional<std::string> fault_of_step(std::string_view text);

/// The same for a fixed-format IGES file: sections and their line numbers are complete, every record is closed and
/// belongs to its entry, numbers are finite, shells, faces and boolean trees refer to entries that exist and not in a
/// circle. Compressed and binary files are left to the reader.
std::optional<std::string> fault_of_iges(std::string_view text);

}  // namespace partscribe::verify
