/// A measured part in words: rows of tables for people, in the terminal and on pages.
#pragma once

#include <string>
#include <vector>

#include "cli/measure/measured_part.h"

namespace partscribe::cli {

/// Rows of a table, the heading first; nothing but the heading if there are none.
using TableRows = std::vector<std::vector<std::string>>;

/// Of longer tables a reader sees the first rows, and how many more there are.
inline constexpr std::size_t most_rows = 40;

/// Name, kind, sizes with one standard deviation, place, faces.
TableRows feature_rows(const MeasuredPart& part);

/// Name, size, place, direction, what is covered, area, deviation, one standard deviation of place and
/// direction. Lengths in mm, angles in degrees.
TableRows face_rows(const MeasuredPart& part);

/// Groups of faces of one direction (A, B, ...), axis, plane or radius; then some that come near and are refused.
TableRows relation_rows(const MeasuredPart& part);

/// "Unclassified: 12.3 of 1420 mm2 (0.87 %) in 3 places", and the places; "All of ..." if there are none.
std::string unclassified_text(const MeasuredPart& part);

/// All tables, those of many rows cut with a line that says where the others are.
std::string measured_text(const MeasuredPart& part);

}  // namespace partscribe::cli
