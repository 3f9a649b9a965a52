/// The damage suite: every kind of damage through every backend on every part; prints the tables of the manual.
///
/// bench_damage [--most N] [--log FILE] [--parts a,b,...] [--backends a,b,...] [--kinds "a,b,..."]
///              [--models-only | --files-only] [--in-turn]
/// --in-turn: damages of models through one backend each, in turn, instead of through all; for a quicker look.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "testing/damage/suite.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string p; std::getline(stream, p, ',');) parts.push_back(p);
  return parts;
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<std::string> parts = {"plate",   "block", "flange", "keyed_shaft", "tray", "bracket",     "pin",
                                    "tie_bar", "box",   "wedge",  "cylinder",    "cone", "half_spaces", "tri_surface"};
  SuiteOptions options;
  std::ofstream log;
  for (int i = 1; i < count; ++i) {
    const std::string option = arguments[i];
    const std::string value = i + 1 < count ? arguments[i + 1] : "";
    if (option == "--models-only")
      options.files = false;
    else if (option == "--files-only")
      options.models = false;
    else if (option == "--in-turn")
      options.in_turn = true;
    else if (option == "--most")
      options.most = static_cast<std::size_t>(std::stoi(value)), ++i;
    else if (option == "--log")
      log.open(value), ++i;
    else if (option == "--parts")
      parts = split(value), ++i;
    else if (option == "--backends")
      options.backends = split(value), ++i;
    else if (option == "--kinds")
      options.kinds = split(value), ++i;
    else if (option == "--threads")
      options.threads = std::stoi(value), ++i;
    else
      return std::fprintf(stderr, "unknown option %s\n", option.c_str()), 2;
  }
  const auto known = SuiteOptions{}.backends;
  for (const auto& backend : options.backends)
    if (std::find(known.begin(), known.end(), backend) == known.end())
      return std::fprintf(stderr, "unknown backend %s\n", backend.c_str()), 2;
  std::vector<DamageCase> all;
  for (const auto& part : parts) {
    auto cases = damage_part(part, options);
    std::size_t wrong = 0, unnamed = 0;
    for (const auto& c : cases) {
      wrong += c.kept != c.harmless;
      unnamed += !c.harmless && !c.kept && !c.named;
      log << line_of(c) << std::endl;
    }
    std::fprintf(stderr, "%s: %zu cases, %zu wrong, %zu named wrong\n", part.c_str(), cases.size(), wrong, unnamed);
    all.insert(all.end(), cases.begin(), cases.end());
    ++options.turn;
  }
  std::printf("%s", markdown_table(all).c_str());
  std::size_t wrong = 0;
  for (const auto& c : all) wrong += c.kept != c.harmless;
  return wrong == 0 ? 0 : 1;
}
