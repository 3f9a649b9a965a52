/// Words of strangers as a terminal may be shown them.
#pragma once

#include <string>

namespace partscribe::cli {

/// The text with "?" for each control character but newline and tab: names of files and what scripts say end up on the
/// screen, and must not move its cursor or change its title.
std::string printable(std::string text);

}  // namespace partscribe::cli
