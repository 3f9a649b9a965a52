/// What somebody may have meant by a misspelt word.
#pragma once

#include <string>
#include <vector>

namespace partscribe::cli {

/// "; did you mean --tolerance?" if one of `words` is nearly `word` or begins with it, dashes and case aside; else
/// empty.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& words);

}  // namespace partscribe::cli
