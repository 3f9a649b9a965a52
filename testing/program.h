/// Runs the program as a user would and keeps what it said.
#pragma once

#include <string>
#include <vector>

#include "core/process.h"
#include "testing/places.h"

namespace partscribe::testing {

using namespace core;

/// The program with these arguments; a program that cannot be started ends the test.
ProcessOutput run_partscribe(const std::vector<std::string>& arguments, const Path& working_directory = {});

/// A file's bytes; a missing file ends the test.
std::string bytes_of(const Path& file);

/// A scan of a bundled model: the folder that `simulate` wrote.
void simulate_part(const std::string& part, const Path& folder, int resolution, double sigma);

}  // namespace partscribe::testing
