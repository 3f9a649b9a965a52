/// What parts and folders are called after an input file.
#pragma once

#include <string>

#include "core/files.h"

namespace partscribe::cli {

/// A part's name inside models and scripts, where only lower-case letters, digits and _ may stand: "Pump cover (2).ply"
/// is pump_cover_2, "Größe_Ø10.stl" is groesse_o10, "零件.stl" is u96f6_u4ef6 after its characters' numbers. Files
/// whose own name says nothing (cloud, scan, merged, model) take their folder's.
std::string part_name(const Path& input);

/// The same as a person would name a folder: "Pump_cover_2", "Größe_Ø10", "零件". Only what a shell takes for its own
/// is left out.
std::string folder_name(const Path& input);

/// What the folders that are named after a part end with.
inline constexpr const char* folder_ending = "-partscribe";

}  // namespace partscribe::cli
