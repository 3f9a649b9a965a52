#include "cli/suggest.h"

#include <algorithm>
#include <cstddef>

namespace partscribe::cli {
namespace {

std::string plain(std::string word) {
  word.erase(0, std::min(word.find_first_not_of('-'), word.size()));
  for (char& c : word) c = c == '_' ? '-' : c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c;
  return word;
}

/// Letters left out, put in, changed or swapped with the next one to make one word of the other.
std::size_t mistakes(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> least(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t k = 0; k <= b.size(); ++k) {
      if (i == 0 || k == 0) {
        least[i][k] = i + k;
        continue;
      }
      least[i][k] =
          std::min({least[i - 1][k] + 1, least[i][k - 1] + 1, least[i - 1][k - 1] + (a[i - 1] == b[k - 1] ? 0 : 1)});
      if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1])
        least[i][k] = std::min(least[i][k], least[i - 2][k - 2] + 1);
    }
  return least[a.size()][b.size()];
}

}  // namespace

std::string did_you_mean(const std::string& word, const std::vector<std::string>& words) {
  const std::string given = plain(word);
  const std::string* best = nullptr;
  std::size_t fewest = std::max<std::size_t>(1, given.size() / 3) + 1;  // of three letters one may be wrong
  for (const auto& known : words) {
    const std::string candidate = plain(known);
    const bool begun = given.size() >= 2 && candidate.starts_with(given);
    const std::size_t count = begun ? 0 : mistakes(given, candidate);
    if (count < fewest && count < given.size()) best = &known, fewest = count;
  }
  return best ? "; did you mean " + *best + "?" : "";
}

}  // namespace partscribe::cli
